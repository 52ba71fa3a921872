#include "page_pool.hpp"

#if defined(TETRAKIS_MAPS_PAGES)

#    include "freed_memory.hpp"

#    include <algorithm>
#    include <array>
#    include <cerrno>
#    include <cstdint>
#    include <cstdlib>
#    include <cstring>
#    include <mutex>
#    include <vector>

#    include <sys/mman.h>

namespace tetrakis::detail::page_pool {

namespace {

/// Pages from the system for a block size, large ones huge where it has them; nullptr where there are none.
char* map_fresh(std::size_t bytes) {
    const bool large = bytes >= k_large;
    const std::size_t all = large ? bytes + k_huge : bytes;
    void* const memory = mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    char* const begin = static_cast<char*>(memory);
    if (!large) return begin;
    const std::size_t before = (k_huge - reinterpret_cast<std::uintptr_t>(begin) % k_huge) % k_huge;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, k_huge - before);
    madvise(begin + before, bytes, MADV_HUGEPAGE);  // a wish: ordinary pages do as well
    return begin + before;
}

/// Moves pages with their contents over others, which go. One huge page at a time: a block that was put together is
/// several mappings to the system, of which it moves but one at once. Returns how many bytes it got to: all, but where
/// the system runs out of mappings.
std::size_t move_pages(char* from, char* to, std::size_t bytes) {
    for (std::size_t done = 0; done < bytes; done += k_huge)
        if (mremap(from + done, k_huge, k_huge, MREMAP_MAYMOVE | MREMAP_FIXED, to + done) == MAP_FAILED) return done;
    return bytes;
}

/// After a move that stopped at `to`: whether there are pages, which the system may have taken away by then.
bool still_mapped(char* to) {
    void* const at = mmap(to, k_huge, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
    return at == to || (at == MAP_FAILED && errno == EEXIST);
}

struct Block {
    char* data = nullptr;
    std::size_t bytes = 0;
    bool huge() const { return reinterpret_cast<std::uintptr_t>(data) % k_huge == 0 && bytes % k_huge == 0; }
};

/// Mapped blocks that were freed, the oldest first.
class KeptBlocks {
  public:
    /// The latest of exactly that size, or the front of the smallest larger one; nullptr: there is none.
    char* take(std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        std::size_t best = blocks_.size();
        for (std::size_t i = blocks_.size(); i-- > 0;) {
            if (blocks_[i].bytes == bytes) return take_front(i, bytes);
            if (bytes >= k_large && blocks_[i].bytes > bytes &&
                (best == blocks_.size() || blocks_[i].bytes < blocks_[best].bytes))
                best = i;
        }
        return best == blocks_.size() ? nullptr : take_front(best, bytes);
    }
    /// What is kept right behind a block, if that is as much.
    bool take_behind(const char* end, std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        const auto at = std::ranges::find(blocks_, end, &Block::data);
        if (at == blocks_.end() || !at->huge() || at->bytes < bytes) return false;
        take_front(static_cast<std::size_t>(at - blocks_.begin()), bytes);
        return true;
    }
    /// The end of the latest block on huge pages, of so many bytes at most; empty: there is none.
    Block take_any(std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = blocks_.size(); i-- > 0;) {
            Block& block = blocks_[i];
            if (!block.huge()) continue;
            const std::size_t part = std::min(bytes, block.bytes);
            const Block taken{block.data + (block.bytes - part), part};
            block.bytes -= part;
            total_ -= part;
            if (block.bytes == 0) blocks_.erase(blocks_.begin() + static_cast<std::ptrdiff_t>(i));
            return taken;
        }
        return {};
    }
    void put(void* data, std::size_t bytes) noexcept {
        Dropped dropped;
        const std::lock_guard lock(mutex_);
        const Block block{static_cast<char*>(data), bytes};
        if (bytes > most_) return dropped.add(block);  // rather than all the others
        blocks_.push_back(block);                      // within the capacity: drop() sees to it
        total_ += bytes;
        drop(most_, dropped);
    }
    void keep_at_most(std::size_t bytes) noexcept {
        Dropped dropped;
        const std::lock_guard lock(mutex_);
        most_ = bytes;
        drop(most_, dropped);
    }
    bool give_back() noexcept {
        Dropped dropped;
        const std::lock_guard lock(mutex_);
        const bool any = !blocks_.empty();
        drop(0, dropped);
        return any;
    }

  private:
    static constexpr std::size_t k_most_blocks = 256;

    /// Unmaps at the end of its life, which comes after that of the lock: large blocks take milliseconds.
    class Dropped {
      public:
        ~Dropped() {
            for (std::size_t i = 0; i < count_; ++i) munmap(blocks_[i].data, blocks_[i].bytes);
        }
        void add(const Block& block) noexcept { blocks_[count_++] = block; }

      private:
        std::array<Block, k_most_blocks> blocks_;
        std::size_t count_ = 0;
    };

    char* take_front(std::size_t i, std::size_t bytes) {
        Block& block = blocks_[i];
        char* const data = block.data;
        block.data += bytes;
        block.bytes -= bytes;
        total_ -= bytes;
        if (block.bytes == 0) blocks_.erase(blocks_.begin() + static_cast<std::ptrdiff_t>(i));
        return data;
    }
    void drop(std::size_t most, Dropped& dropped) noexcept {
        std::size_t gone = 0;
        while (gone < blocks_.size() && (total_ > most || blocks_.size() - gone == k_most_blocks)) {
            total_ -= blocks_[gone].bytes;
            dropped.add(blocks_[gone++]);
        }
        blocks_.erase(blocks_.begin(), blocks_.begin() + static_cast<std::ptrdiff_t>(gone));
    }
    static std::vector<Block> with_room() {
        std::vector<Block> blocks;
        blocks.reserve(k_most_blocks);
        return blocks;
    }

    std::mutex mutex_;
    std::vector<Block> blocks_ = with_room();
    std::size_t total_ = 0;
    std::size_t most_ = default_freed_memory();
};

/// Never destroyed: blocks of static objects may come back after everything else.
KeptBlocks& kept() {
    static KeptBlocks& blocks = *new KeptBlocks;
    return blocks;
}

/// Puts kept huge pages in the place of fresh ones, as far as there are any and the system lets them be moved. Returns
/// whether all of it is mapped.
bool pour_kept(char* to, std::size_t bytes) {
    for (std::size_t done = 0; done < bytes;) {
        const Block block = kept().take_any(bytes - done);
        if (block.bytes == 0) return true;
        const std::size_t moved = move_pages(block.data, to + done, block.bytes);
        if (moved < block.bytes) {
            kept().put(block.data + moved, block.bytes - moved);
            return still_mapped(to + done + moved);
        }
        done += moved;
    }
    return true;
}

/// Fresh pages and, from byte `begin` on, kept ones in their place; nullptr: there is no room.
char* map_with_kept(std::size_t bytes, std::size_t begin) {
    char* const memory = map_fresh(bytes);
    if (memory == nullptr || bytes < k_large || pour_kept(memory + begin, bytes - begin)) return memory;
    munmap(memory, bytes);
    return map_fresh(bytes);
}

}  // namespace

std::size_t block_size(std::size_t bytes) {
    constexpr std::size_t k_unit = std::size_t{64} << 10;
    const std::size_t unit = bytes >= k_large ? k_huge : k_unit;
    return (bytes + unit - 1) / unit * unit;
}

void* take(std::size_t bytes) {
    char* const memory = kept().take(bytes);
    return memory != nullptr ? memory : map_with_kept(bytes, 0);
}

void* extend(void* data, std::size_t old_bytes, std::size_t bytes) {
    char* const old = static_cast<char*>(data);
    if (kept().take_behind(old + old_bytes, bytes - old_bytes)) return data;
    char* const memory = map_with_kept(bytes, old_bytes);
    if (memory == nullptr) return nullptr;
    const std::size_t moved = move_pages(old, memory, old_bytes);
    if (moved < old_bytes) {
        // What cannot be moved is copied. Without pages here the block would be lost between two places.
        if (!still_mapped(memory + moved)) std::abort();
        std::memcpy(memory + moved, old + moved, old_bytes - moved);
        munmap(old + moved, old_bytes - moved);
    }
    madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
}

void put(void* data, std::size_t bytes) noexcept { kept().put(data, bytes); }
void keep_at_most(std::size_t bytes) noexcept { kept().keep_at_most(bytes); }
bool give_back() noexcept { return kept().give_back(); }

}  // namespace tetrakis::detail::page_pool

#endif
