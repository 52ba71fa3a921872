#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetrakis {

/// A set of 64-bit numbers, many of which lie close together: a hash table of blocks of 64 of them, a bit for each.
class NumberSet {
  public:
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    bool contains(std::uint64_t number) const {
        return !blocks_.empty() && (blocks_[place(number >> k_shift)].bits >> (number & k_mask) & 1) != 0;
    }
    /// Whether it is new. The set is unchanged where memory runs out.
    bool insert(std::uint64_t number);
    /// Whether it was there.
    bool erase(std::uint64_t number);
    /// All numbers, increasing.
    std::vector<std::uint64_t> sorted() const;
    std::uint64_t memory_bytes() const { return blocks_.capacity() * sizeof(Block); }

  private:
    static constexpr int k_shift = 6;
    static constexpr std::uint64_t k_mask = (1u << k_shift) - 1, k_none = ~std::uint64_t{0};
    struct Block {
        std::uint64_t key = k_none;  ///< the numbers' upper bits
        std::uint64_t bits = 0;      ///< none set: an erased block, whose place stays taken until the next growth
    };

    /// Of the block, or of the empty place where it would be.
    std::size_t place(std::uint64_t key) const {
        const std::size_t mask = blocks_.size() - 1;
        // Multiplicative hashing (Knuth, TAOCP 3, 6.4): the upper bits are the good ones.
        std::size_t at = static_cast<std::size_t>(key * 0x9E37'79B9'7F4A'7C15u >> 32) & mask;
        while (blocks_[at].key != key && blocks_[at].key != k_none) at = (at + 1) & mask;
        return at;
    }
    void grow();

    std::vector<Block> blocks_;  // a power of two, at most half of them taken
    std::size_t taken_ = 0, size_ = 0;
};

}  // namespace tetrakis
