#include "number_set.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace tetrakis {

bool NumberSet::insert(std::uint64_t number) {
    if (2 * (taken_ + 1) > blocks_.size()) grow();
    Block& block = blocks_[place(number >> k_shift)];
    if (block.key == k_none) {
        block.key = number >> k_shift;
        ++taken_;
    }
    const std::uint64_t bit = std::uint64_t{1} << (number & k_mask);
    if ((block.bits & bit) != 0) return false;
    block.bits |= bit;
    ++size_;
    return true;
}

bool NumberSet::erase(std::uint64_t number) {
    if (!contains(number)) return false;
    blocks_[place(number >> k_shift)].bits &= ~(std::uint64_t{1} << (number & k_mask));
    if (--size_ == 0) {
        blocks_.clear();
        taken_ = 0;
    }
    return true;
}

void NumberSet::grow() {
    std::size_t live = 0;
    for (const Block& block : blocks_) live += block.bits != 0 ? 1 : 0;
    NumberSet larger;
    constexpr std::size_t k_least = 4;
    // Room for half as many again.
    larger.blocks_.resize(std::bit_ceil(std::max(k_least, 3 * live)));
    for (const Block& block : blocks_)
        if (block.bits != 0) larger.blocks_[larger.place(block.key)] = block;
    larger.taken_ = live;
    larger.size_ = size_;
    *this = std::move(larger);
}

std::vector<std::uint64_t> NumberSet::sorted() const {
    std::vector<Block> blocks;
    for (const Block& block : blocks_)
        if (block.bits != 0) blocks.push_back(block);
    std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) { return a.key < b.key; });
    std::vector<std::uint64_t> result;
    result.reserve(size_);
    for (const Block& block : blocks)
        for (std::uint64_t bits = block.bits; bits != 0; bits &= bits - 1)
            result.push_back(block.key << k_shift | static_cast<std::uint64_t>(std::countr_zero(bits)));
    return result;
}

}  // namespace tetrakis
