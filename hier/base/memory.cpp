#include "memory.hpp"

#include "error.hpp"
#include "parallel.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <sys/resource.h>

#include <cassert>
#include <cstdlib>
#include <mutex>
#include <string>

#if defined(__linux__)
#    include <sys/mman.h>
#    include <unistd.h>
#endif

// On other systems all memory comes from the system's allocator; so it does for AddressSanitizer, which checks it.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#    define TETRAKIS_MAPS_PAGES
#endif

namespace tetrakis {

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    constexpr std::uint64_t k_unit = 1024;  // Linux counts it in KiB
    return static_cast<std::uint64_t>(usage.ru_maxrss) * k_unit;
}

}  // namespace tetrakis

namespace tetrakis::detail {

namespace {

[[maybe_unused]] constexpr std::size_t k_page = 4096;
[[maybe_unused]] constexpr std::size_t k_huge_page = std::size_t{2} << 20;  // of x86-64, and arm64 with pages of 4 KiB

#if defined(TETRAKIS_MAPS_PAGES)
constexpr std::size_t k_mapped = k_huge_page;  // smallest block, in bytes, that is a mapping of its own, on huge pages

/// The size of the mapping for `bytes` bytes: a multiple of the huge page.
std::size_t mapped_size(std::size_t bytes) { return (bytes + k_huge_page - 1) / k_huge_page * k_huge_page; }

/// A new mapping that starts at a multiple of the huge page; nullptr if there is no room.
char* map_pages(std::size_t bytes) {
    void* const memory = mmap(nullptr, bytes + k_huge_page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    char* const begin = static_cast<char*>(memory);
    const std::size_t before = (k_huge_page - reinterpret_cast<std::uintptr_t>(begin) % k_huge_page) % k_huge_page;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, k_huge_page - before);
    madvise(begin + before, bytes, MADV_HUGEPAGE);  // where it fails, pages are ordinary ones
    return begin + before;
}

/// Mapped blocks that were freed, the oldest first.
class FreedBlocks {
  public:
    FreedBlocks() { blocks_.reserve(k_most_blocks); }

    /// The latest block of this size, or the front of the smallest one up to a quarter larger; nullptr: there is none.
    char* take(std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        auto best = blocks_.end();
        for (auto at = blocks_.begin(); at != blocks_.end(); ++at)
            if (at->bytes >= bytes && at->bytes <= bytes + bytes / 4)
                if (best == blocks_.end() || at->bytes <= best->bytes) best = at;
        if (best == blocks_.end()) return nullptr;
        char* const data = best->data;
        best->data += bytes;
        best->bytes -= bytes;
        total_ -= bytes;
        if (best->bytes == 0) blocks_.erase(best);
        return data;
    }
    void put(char* data, std::size_t bytes) noexcept {
        const std::lock_guard lock(mutex_);
        if (bytes > most_) {
            munmap(data, bytes);
            return;
        }
        drop(most_ - bytes, k_most_blocks - 1);
        blocks_.push_back({data, bytes});
        total_ += bytes;
    }
    /// Sets the limit of kept bytes.
    void keep_at_most(std::size_t bytes) noexcept {
        const std::lock_guard lock(mutex_);
        most_ = bytes;
        drop(most_, k_most_blocks);
    }
    /// Gives all blocks back to the system. Returns whether there were any.
    bool give_back() noexcept {
        const std::lock_guard lock(mutex_);
        const bool any = !blocks_.empty();
        drop(0, 0);
        return any;
    }

  private:
    static constexpr std::size_t k_most_blocks = 256;
    struct Block {
        char* data;
        std::size_t bytes;
    };

    /// Unmaps the oldest blocks until at most `most_bytes` bytes and `most_blocks` blocks are left.
    void drop(std::size_t most_bytes, std::size_t most_blocks) noexcept {
        auto end = blocks_.begin();
        for (; end != blocks_.end(); ++end) {
            if (total_ <= most_bytes && static_cast<std::size_t>(blocks_.end() - end) <= most_blocks) break;
            munmap(end->data, end->bytes);
            total_ -= end->bytes;
        }
        blocks_.erase(blocks_.begin(), end);
    }

    std::mutex mutex_;
    std::vector<Block> blocks_;
    std::size_t total_ = 0, most_ = default_freed_memory();
};

/// Never destroyed, because destructors of static objects may still free memory.
FreedBlocks& freed_blocks() {
    static auto& blocks = *new FreedBlocks;
    return blocks;
}

/// grow_memory() without giving back freed blocks.
void* grown(void* data, std::size_t old_bytes, std::size_t bytes) {
    if (bytes < k_mapped) return std::realloc(data, bytes);
    const std::size_t size = mapped_size(bytes), old_size = mapped_size(old_bytes);
    if (old_bytes >= k_mapped && size == old_size) return data;
    char* memory = freed_blocks().take(size);
    if (memory == nullptr) {
        memory = map_pages(size);
        // mremap() moves the pages of the old block to the new mapping. If it fails, it may have unmapped the new
        // mapping, which is then not used again: the contents are copied to another one.
        if (memory != nullptr && old_bytes >= k_mapped) {
            if (mremap(data, old_size, size, MREMAP_MAYMOVE | MREMAP_FIXED, memory) != MAP_FAILED) return memory;
            memory = map_pages(size);
        }
    }
    if (memory != nullptr && old_bytes > 0) {
        std::memcpy(memory, data, old_bytes);
        free_memory(data, old_bytes);
    }
    return memory;
}
#endif

/// A size as text for messages: in MiB, or below 1 MiB in KiB, rounded down.
std::string in_units(std::uint64_t bytes) {
    constexpr int k_kib = 10, k_mib = 20;
    return bytes >> k_mib != 0 ? fmt::format("{} MiB", bytes >> k_mib) : fmt::format("{} KiB", bytes >> k_kib);
}

}  // namespace

void check_memory(std::string_view what, std::uint64_t bytes, std::uint64_t limit, std::string_view advice,
                  const std::filesystem::path& file) {
    if (limit == 0 || bytes <= limit) return;
    throw Error(ErrorCode::memory_limit,
                fmt::format("{} about {}, and the limit is {}; {}", what, in_units(bytes), in_units(limit), advice),
                file);
}

void* grow_memory(void* data, std::size_t old_bytes, std::size_t bytes) {
    assert(bytes >= old_bytes);
#if defined(TETRAKIS_MAPS_PAGES)
    void* memory = grown(data, old_bytes, bytes);
    if (memory == nullptr && freed_blocks().give_back()) memory = grown(data, old_bytes, bytes);
    return memory;
#else
    (void)old_bytes;
    return std::realloc(data, bytes);
#endif
}

void free_memory(void* data, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(TETRAKIS_MAPS_PAGES)
    if (bytes < k_mapped)
        std::free(data);
    else if (data != nullptr)
        freed_blocks().put(static_cast<char*>(data), mapped_size(bytes));
#else
    std::free(data);
#endif
}

#if defined(__linux__)
namespace {

/// Calls madvise() for the whole pages of a block, if the block has `least` bytes from the first of them on. Older
/// systems refuse some advice, and systems with larger pages may; the pages then stay as they are.
void advise(void* data, std::size_t bytes, std::size_t page, std::size_t least, int advice) noexcept {
    const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(data) % page) % page;
    if (bytes >= before + least) madvise(static_cast<char*>(data) + before, (bytes - before) / page * page, advice);
}

}  // namespace

void wish_for_huge_pages(void* data, std::size_t bytes) noexcept {
    advise(data, bytes, k_huge_page, k_huge_page, MADV_HUGEPAGE);
}
void map_at_once([[maybe_unused]] void* data, [[maybe_unused]] std::size_t bytes) noexcept {
#    if defined(MADV_POPULATE_WRITE)
    constexpr std::size_t k_few = 16 * k_page;  // for less memory, page faults cost no more than the call
    constexpr std::uint32_t k_pages = 2048;     // for a thread
    const auto map = [&](std::uint32_t begin, std::uint32_t end) {
        advise(static_cast<char*>(data) + begin * k_page, (end - begin) * k_page, k_page, k_few, MADV_POPULATE_WRITE);
    };
    // The caller may be one of several threads: while it waits here it must not begin other work of theirs.
    oneapi::tbb::this_task_arena::isolate(
        [&] { for_each_block(static_cast<std::uint32_t>(bytes / k_page), k_pages, map); });
#    endif
}
void wish_for_small_pages(void* data, std::size_t bytes) noexcept {
    advise(data, bytes, k_page, k_page, MADV_NOHUGEPAGE);
}
#else
void wish_for_huge_pages(void*, std::size_t) noexcept {}
void map_at_once(void*, std::size_t) noexcept {}
void wish_for_small_pages(void*, std::size_t) noexcept {}
#endif

}  // namespace tetrakis::detail

namespace tetrakis {

std::size_t default_freed_memory() {
#if defined(__linux__)
    constexpr std::size_t k_most = std::size_t{512} << 20;  // a container may see the whole machine's memory
    const long pages = sysconf(_SC_PHYS_PAGES), bytes = sysconf(_SC_PAGESIZE);
    if (pages <= 0 || bytes <= 0) return 0;
    return std::min(static_cast<std::size_t>(pages) / 64 * static_cast<std::size_t>(bytes), k_most);
#else
    return 0;
#endif
}

void keep_freed_memory(std::size_t bytes) {
#if defined(TETRAKIS_MAPS_PAGES)
    detail::freed_blocks().keep_at_most(bytes);
#else
    (void)bytes;
#endif
}

}  // namespace tetrakis
