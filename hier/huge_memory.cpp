#include "tetrakis/hier/huge_memory.hpp"

#include <cstdint>
#include <cstdlib>
#include <cstring>

#if defined(__linux__)
#    include <sys/mman.h>
#endif
#if !defined(__SANITIZE_ADDRESS__)
#    include <oneapi/tbb/scalable_allocator.h>
#endif

namespace tetrakis::detail {

namespace {

// Under AddressSanitizer the system's allocator, which it watches.
#if defined(__SANITIZE_ADDRESS__)
void* grow_small(void* data, std::size_t bytes) { return std::realloc(data, bytes); }
void free_small(void* data) noexcept { std::free(data); }
#else
void* grow_small(void* data, std::size_t bytes) { return scalable_realloc(data, bytes); }
void free_small(void* data) noexcept { scalable_free(data); }
#endif

constexpr std::size_t k_huge = std::size_t{2} << 20;  // a huge page of x86-64, and of arm64 with pages of 4 KiB

#if defined(__linux__)

// Below that the parts of pages at the ends outweigh.
constexpr std::size_t k_large = 2 * k_huge;

std::size_t rounded(std::size_t bytes) { return (bytes + k_huge - 1) / k_huge * k_huge; }

/// Fresh pages, aligned to huge ones; nullptr where there are none.
void* map_pages(std::size_t bytes) {
    const std::size_t all = bytes + k_huge;
    void* const memory = mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    char* const begin = static_cast<char*>(memory);
    const std::size_t before = (k_huge - reinterpret_cast<std::uintptr_t>(begin) % k_huge) % k_huge;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + bytes, k_huge - before);
    return begin + before;
}

#endif

}  // namespace

void* grow_memory(void* data, std::size_t old_bytes, std::size_t bytes) {
#if defined(__linux__)
    if (bytes >= k_large) {
        void* const memory = map_pages(rounded(bytes));
        if (memory == nullptr) return nullptr;
        if (old_bytes >= k_large) {
            if (mremap(data, rounded(old_bytes), rounded(bytes), MREMAP_MAYMOVE | MREMAP_FIXED, memory) == MAP_FAILED) {
                munmap(memory, rounded(bytes));
                return nullptr;
            }
        } else if (old_bytes > 0) {
            std::memcpy(memory, data, old_bytes);
            free_small(data);
        }
        madvise(memory, rounded(bytes), MADV_HUGEPAGE);  // a wish: ordinary pages do as well
        return memory;
    }
#endif
    (void)old_bytes;
    return grow_small(data, bytes);
}

void free_memory(void* data, std::size_t bytes) noexcept {
#if defined(__linux__)
    if (bytes >= k_large) {
        munmap(data, rounded(bytes));
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
