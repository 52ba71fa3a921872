#include "huge_memory.hpp"

#include "freed_memory.hpp"
#include "page_pool.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#if defined(__linux__)
#    include <sys/mman.h>
#    include <unistd.h>
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

/// grow_memory() without giving back what is kept.
void* grown(void* data, std::size_t old_bytes, std::size_t bytes) {
#if defined(TETRAKIS_MAPS_PAGES)
    if (bytes >= page_pool::k_mapped) {
        const std::size_t size = page_pool::block_size(bytes), old_size = page_pool::block_size(old_bytes);
        if (old_bytes >= page_pool::k_mapped && size == old_size) return data;
        if (old_bytes >= page_pool::k_large) return page_pool::extend(data, old_size, size);
        void* const memory = page_pool::take(size);
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
    if (memory == nullptr && page_pool::give_back()) memory = grown(data, old_bytes, bytes);
#endif
    return memory;
}

void free_memory(void* data, std::size_t bytes) noexcept {
#if defined(TETRAKIS_MAPS_PAGES)
    if (bytes >= page_pool::k_mapped) {
        if (data != nullptr) page_pool::put(data, page_pool::block_size(bytes));
        return;
    }
#endif
    (void)bytes;
    free_small(data);
}

void wish_for_huge_pages(void* data, std::size_t bytes) noexcept {
#if defined(__linux__)
    constexpr std::size_t k_huge = std::size_t{2} << 20;
    char* const begin = static_cast<char*>(data);
    const std::size_t before = (k_huge - reinterpret_cast<std::uintptr_t>(begin) % k_huge) % k_huge;
    if (bytes < before + k_huge) return;
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
    detail::page_pool::keep_at_most(bytes);
#else
    (void)bytes;
#endif
}

}  // namespace tetrakis
