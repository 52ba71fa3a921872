#pragma once

#include <cstddef>
#include <vector>

namespace tetrakis::detail {

/// Memory that is not the caller's to keep. The first touch of a page costs more than what is done with its contents
/// (a fifth of a run of ten thousand triangles), so small blocks come from oneTBB's allocator, which has them ready for
/// the next run; large ones are kept for it when they are freed (freed_memory.hpp says how many) and are on huge pages
/// where the system has them. Contents stay as blocks grow; large ones are moved by their page tables where none is
/// kept.
/// @param data       from this function, or nullptr
/// @param old_bytes  what it was asked for
/// @param bytes      not less than that
/// @return nullptr where memory runs out; `data` is then as it was
void* grow_memory(void* data, std::size_t old_bytes, std::size_t bytes);
void free_memory(void* data, std::size_t bytes) noexcept;

/// Asks for huge pages for memory that has been allocated but not touched, where it is large.
void wish_for_huge_pages(void* data, std::size_t bytes) noexcept;

/// Reserves room for `size` elements, on huge pages if it is large: for vectors of many megabytes that are filled once.
template <class T, class Allocator>
void reserve_large(std::vector<T, Allocator>& v, std::size_t size) {
    if (size <= v.capacity()) return;
    v.reserve(size);
    wish_for_huge_pages(static_cast<void*>(v.data() + v.size()), (v.capacity() - v.size()) * sizeof(T));
}
template <class T, class Allocator>
void resize_large(std::vector<T, Allocator>& v, std::size_t size) {
    reserve_large(v, size);
    v.resize(size);
}

}  // namespace tetrakis::detail
