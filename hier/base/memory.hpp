#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis {

/// The first touch of fresh memory costs as much as most work on it, so the process keeps large blocks that its runs
/// (tessellations, refinements, hierarchies) have freed, for the runs to come. They count for its resident memory.
/// @param bytes  how many are kept at most, the latest first; 0: none. What is above is given back at once
/// Any thread may call it at any time. Linux only; elsewhere the system's allocator decides.
void keep_freed_memory(std::size_t bytes);

/// The limit unless it is set, in bytes: a 64th of the machine's memory, 512 MiB at most.
std::size_t default_freed_memory();

/// The largest amount of memory that this process has held so far.
std::uint64_t peak_memory_bytes();

namespace detail {

/// Refuses work that needs more memory than allowed.
/// @param what    the work with its verb, as the message begins: "3 levels need"
/// @param limit   in bytes; 0: none
/// @param advice  what the user can do about it
/// @throws Error  memory_limit: `bytes` is more than the limit
void check_memory(std::string_view what, std::uint64_t bytes, std::uint64_t limit, std::string_view advice,
                  const std::filesystem::path& file = {});

/// Memory of working arrays. Blocks from 2 MiB on are mappings of their own, on huge pages where the system has them,
/// and are kept when they are freed; smaller ones are those of malloc(). @throws std::bad_alloc
void* new_memory(std::size_t bytes);
/// @param bytes  as new_memory() was asked for
void free_memory(void* data, std::size_t bytes) noexcept;

/// Asks for huge pages for memory that has been allocated but not touched, where it is large.
void wish_for_huge_pages(void* data, std::size_t bytes) noexcept;

/// Has the system map all pages of memory that is about to be written: one call for many pages takes a fraction of a
/// page fault for each (on a virtual machine 1 us a page of 4 KiB instead of 15).
void map_at_once(void* data, std::size_t bytes) noexcept;

/// Asks for pages of ordinary size for memory that is to be met little by little: the first write to a huge page, and
/// some later ones, may take milliseconds on a virtual machine.
void wish_for_small_pages(void* data, std::size_t bytes) noexcept;
/// That for the room that an array has for more elements.
template <class Array>
void wish_for_small_pages(Array& array) {
    wish_for_small_pages(array.data() + array.size(), (array.capacity() - array.size()) * sizeof(*array.data()));
}

/// The pages of a vector's free room: huge ones where it is large, and those of `size` elements at once.
template <class T, class Allocator>
void prepare_pages(std::vector<T, Allocator>& v, std::size_t size) {
    void* const room = static_cast<void*>(v.data() + v.size());
    wish_for_huge_pages(room, (v.capacity() - v.size()) * sizeof(T));
    map_at_once(room, (size - v.size()) * sizeof(T));
}
/// Reserves room for `size` elements: for vectors that are filled once.
template <class T, class Allocator>
void reserve_large(std::vector<T, Allocator>& v, std::size_t size) {
    if (size <= v.capacity()) return;
    v.reserve(size);
    prepare_pages(v, size);
}
template <class T, class Allocator>
void resize_large(std::vector<T, Allocator>& v, std::size_t size) {
    reserve_large(v, size);
    v.resize(size);
}
/// Room for `size` elements, growing by half at least: many small calls take linear time in all.
template <class T, class Allocator>
void reserve_by_half(std::vector<T, Allocator>& v, std::size_t size) {
    if (size > v.capacity()) v.reserve(std::max(size, v.capacity() + v.capacity() / 2));
}
/// The same, of which the pages of `size` elements are prepared.
template <class T, class Allocator>
void make_room(std::vector<T, Allocator>& v, std::size_t size) {
    if (size <= v.capacity()) return;
    reserve_by_half(v, size);
    prepare_pages(v, size);
}

/// new_memory() for containers.
template <class T>
struct PoolAllocator {
    static_assert(alignof(T) <= alignof(std::max_align_t));
    using value_type = T;

    PoolAllocator() = default;
    template <class U>
    PoolAllocator(const PoolAllocator<U>&) noexcept {}

    T* allocate(std::size_t count) { return static_cast<T*>(new_memory(count * sizeof(T))); }
    void deallocate(T* data, std::size_t count) noexcept { free_memory(data, count * sizeof(T)); }

    template <class U>
    friend bool operator==(const PoolAllocator&, const PoolAllocator<U>&) noexcept {
        return true;
    }
};

/// A vector that does not outlive the run it works for.
template <class T>
using PoolVector = std::vector<T, PoolAllocator<T>>;

/// `new` and `delete` of what derives from it, by new_memory().
struct PoolNew {
    static void* operator new(std::size_t bytes) { return new_memory(bytes); }
    static void operator delete(void* memory, std::size_t bytes) noexcept { free_memory(memory, bytes); }
};

/// PoolAllocator of plain records whose new elements, where they get no value, hold garbage.
template <class T>
struct PodAllocator : PoolAllocator<T> {
    static_assert(std::is_trivially_copyable_v<T>);
    template <class U>
    struct rebind {
        using other = PodAllocator<U>;
    };
    template <class U, class... Values>
    void construct(U* at, Values&&... values) {
        if constexpr (sizeof...(Values) > 0) std::construct_at(at, std::forward<Values>(values)...);
    }
};
/// For what is large and written before it is read.
template <class T>
using PodArray = std::vector<T, PodAllocator<T>>;

}  // namespace detail
}  // namespace tetrakis
