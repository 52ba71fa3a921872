#include "tetrakis/hier/huge_memory.hpp"

#include "tetrakis/hier/freed_memory.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <vector>

// Under AddressSanitizer everything comes from the system's allocator, which it watches.
#if defined(__linux__)
#    include <sys/mman.h>
#    include <unistd.h>
#    if !defined(__SANITIZE_ADDRESS__)
#        define TETRAKIS_MAPS_PAGES
#    endif
#endif
#if !defined(__SANITIZE_ADDRESS__)
#    include <oneapi/tbb/scalable_allocator.h>
#endif

namespace tetrakis::detail {

namespace {

#if defined(__SANITIZE_ADDRESS__)
void* grow_small(void* data, std::size_t bytes) { return std::realloc(data, bytes); }
void free_small(void* data) noexcept { std::free(data); }
#else
void* grow_small(void* data, std::size_t bytes) { return scalable_realloc(data, bytes); }
void free_small(void* data) noexcept { scalable_free(data); }
#endif

constexpr std::size_t k_huge = std::size_t{2} << 20;  // a huge page of x86-64, and of arm64 with pages of 4 KiB
constexpr std::size_t k_large = 2 * k_huge;           // blocks from here on are on huge pages

#if defined(TETRAKIS_MAPS_PAGES)

// Blocks from here on have pages of their own; below, the parts of pages at the ends outweigh.
constexpr std::size_t k_mapped = std::size_t{1} << 20;

std::size_t rounded(std::size_t bytes) {
    constexpr std::size_t k_unit = std::size_t{64} << 10;  // few different sizes, so that kept blocks fit again
    const std::size_t unit = bytes >= k_large ? k_huge : k_unit;
    return (bytes + unit - 1) / unit * unit;
}

/// Fresh pages for a rounded size, large ones huge where the system has them; nullptr where there are none.
void* map_pages(std::size_t bytes) {
    const bool large = bytes >= k_large;
    const std::size_t all = large ? bytes + k_huge : bytes;
    void* const memory = mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    if (!large) return memory;
    char* const begin = static_cast<char*>(memory);
    const std::size_t before = (k_huge - reinterpret_cast<std::uintptr_t>(begin) % k_huge) % k_huge;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, k_huge - before);
    madvise(begin + before, bytes, MADV_HUGEPAGE);  // a wish: ordinary pages do as well
    return begin + before;
}

/// A large block with its pages in a larger one; nullptr, with the block as it was: there is no room.
void* moved(void* data, std::size_t old_bytes, std::size_t bytes) {
    void* const memory = map_pages(bytes);
    if (memory == nullptr) return nullptr;
    if (mremap(data, old_bytes, bytes, MREMAP_MAYMOVE | MREMAP_FIXED, memory) == MAP_FAILED) {
        munmap(memory, bytes);
        return nullptr;
    }
    madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
}

/// Mapped blocks that were freed, the oldest first: what was touched once is ready for the next run.
class KeptBlocks {
  public:
    /// The latest of exactly that size; nullptr: there is none.
    void* take(std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = blocks_.size(); i-- > 0;) {
            if (blocks_[i].bytes != bytes) continue;
            void* const data = blocks_[i].data;
            blocks_.erase(blocks_.begin() + static_cast<std::ptrdiff_t>(i));
            total_ -= bytes;
            return data;
        }
        return nullptr;
    }
    void put(void* data, std::size_t bytes) noexcept {
        Dropped dropped;
        const std::lock_guard lock(mutex_);
        if (bytes > most_) return dropped.add({data, bytes});  // rather than all the others
        blocks_.push_back({data, bytes});                      // within the capacity: drop() sees to it
        total_ += bytes;
        drop(most_, dropped);
    }
    void keep_at_most(std::size_t bytes) noexcept {
        Dropped dropped;
        const std::lock_guard lock(mutex_);
        most_ = bytes;
        drop(most_, dropped);
    }
    /// Gives all back. Returns whether there were any.
    bool give_back() noexcept {
        Dropped dropped;
        const std::lock_guard lock(mutex_);
        const bool any = !blocks_.empty();
        drop(0, dropped);
        return any;
    }

  private:
    static constexpr std::size_t k_most_blocks = 256;
    struct Block {
        void* data = nullptr;
        std::size_t bytes = 0;
    };

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

    void drop(std::size_t most, Dropped& dropped) noexcept {
        std::size_t gone = 0;
        while (gone < blocks_.size() && (total_ > most || blocks_.size() - gone == k_most_blocks)) {
            total_ -= blocks_[gone].bytes;
            dropped.add(blocks_[gone++]);
        }
        blocks_.erase(blocks_.begin(), blocks_.begin() + static_cast<std::ptrdiff_t>(gone));
    }

    std::mutex mutex_;
    std::vector<Block> blocks_ = with_room();
    std::size_t total_ = 0;
    std::size_t most_ = default_freed_memory();
    static std::vector<Block> with_room() {
        std::vector<Block> blocks;
        blocks.reserve(k_most_blocks);
        return blocks;
    }
};

/// Never destroyed: blocks of static objects may come back after everything else.
KeptBlocks& kept_blocks() {
    static KeptBlocks& blocks = *new KeptBlocks;
    return blocks;
}

#endif

/// grow_memory() without giving back what is kept.
void* grown(void* data, std::size_t old_bytes, std::size_t bytes) {
#if defined(TETRAKIS_MAPS_PAGES)
    if (bytes >= k_mapped) {
        const std::size_t size = rounded(bytes), old_size = rounded(old_bytes);
        if (old_bytes >= k_mapped && size == old_size) return data;
        void* memory = kept_blocks().take(size);
        if (memory == nullptr && old_bytes >= k_large) return moved(data, old_size, size);
        if (memory == nullptr) memory = map_pages(size);
        if (memory != nullptr && old_bytes > 0) {
            std::memcpy(memory, data, old_bytes);
            free_memory(data, old_bytes);
        }
        return memory;
    }
#endif
    (void)old_bytes;
    return grow_small(data, bytes);
}

}  // namespace

void* grow_memory(void* data, std::size_t old_bytes, std::size_t bytes) {
    assert(bytes >= old_bytes);
    void* memory = grown(data, old_bytes, bytes);
#if defined(TETRAKIS_MAPS_PAGES)
    if (memory == nullptr && kept_blocks().give_back()) memory = grown(data, old_bytes, bytes);
#endif
    return memory;
}

void free_memory(void* data, std::size_t bytes) noexcept {
#if defined(TETRAKIS_MAPS_PAGES)
    if (bytes >= k_mapped) {
        if (data != nullptr) kept_blocks().put(data, rounded(bytes));
        return;
    }
#endif
    (void)bytes;
    free_small(data);
}

void wish_for_huge_pages(void* data, std::size_t bytes) noexcept {
#if defined(__linux__)
    if (bytes < k_large) return;
    char* const begin = static_cast<char*>(data);
    const std::size_t before = (k_huge - reinterpret_cast<std::uintptr_t>(begin) % k_huge) % k_huge;
    madvise(begin + before, (bytes - before) / k_huge * k_huge, MADV_HUGEPAGE);
#else
    (void)data, (void)bytes;
#endif
}

}  // namespace tetrakis::detail

namespace tetrakis {

std::size_t default_freed_memory() {
#if defined(__linux__)
    constexpr std::size_t k_most = std::size_t{512} << 20;  // the machine may be larger than the container that sees it
    const long pages = sysconf(_SC_PHYS_PAGES), bytes = sysconf(_SC_PAGESIZE);
    if (pages <= 0 || bytes <= 0) return 0;
    return std::min(static_cast<std::size_t>(pages) / 64 * static_cast<std::size_t>(bytes), k_most);
#else
    return 0;
#endif
}

void keep_freed_memory(std::size_t bytes) {
#if defined(TETRAKIS_MAPS_PAGES)
    detail::kept_blocks().keep_at_most(bytes);
#else
    (void)bytes;
#endif
}

}  // namespace tetrakis
