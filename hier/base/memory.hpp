#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis {

/// Limits the freed memory that the process keeps for later runs (tessellations, refinements, hierarchies), because the
/// first write to fresh memory costs as much as most work on it. Only large blocks are kept; they are resident memory.
/// @param bytes  most bytes to keep, those freed last first; 0: none. Memory above the limit is freed at once
/// Any thread may call it at any time. Linux only; elsewhere the system's allocator decides.
void keep_freed_memory(std::size_t bytes);

/// The default of this limit, in bytes: 1/64 of the machine's memory, at most 512 MiB; 0 where nothing is kept.
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

/// Allocates or enlarges a block for a working array; the contents stay. A block of 2 MiB or more is a mapping of its
/// own, on huge pages where the system has them, and is kept when freed. Smaller blocks come from malloc().
/// @param data       block from this function, or nullptr
/// @param old_bytes  size that was requested for `data`
/// @param bytes      new size, at least `old_bytes`
/// @return nullptr where memory runs out; `data` is then unchanged
void* grow_memory(void* data, std::size_t old_bytes, std::size_t bytes);
void free_memory(void* data, std::size_t bytes) noexcept;

/// grow_memory() of a new block. @throws std::bad_alloc
inline void* new_memory(std::size_t bytes) {
    void* const memory = grow_memory(nullptr, 0, bytes);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

/// Asks for huge pages for allocated memory that is not written yet, if a whole huge page fits into it.
void wish_for_huge_pages(void* data, std::size_t bytes) noexcept;

/// Has the system map all pages of memory that is about to be written, by several threads if it is large. One call for
/// many pages is faster than a page fault for each (on a virtual machine 1 us per page of 4 KiB instead of 15).
void map_at_once(void* data, std::size_t bytes) noexcept;

/// Asks for pages of ordinary size for memory that is going to be filled little by little: the first write to a huge
/// page, and some later ones, may take milliseconds on a virtual machine.
void wish_for_small_pages(void* data, std::size_t bytes) noexcept;
/// The same for the unused capacity of an array.
template <class Array>
void wish_for_small_pages(Array& array) {
    wish_for_small_pages(array.data() + array.size(), (array.capacity() - array.size()) * sizeof(*array.data()));
}

/// The same for the elements that an array is going to have after its present ones, within its capacity.
template <class Array>
void map_at_once(Array& array, std::size_t size) {
    if (size > array.size()) map_at_once(array.data() + array.size(), (size - array.size()) * sizeof(*array.data()));
}

/// Prepares the pages of a vector's unused capacity: huge ones if it is large. Maps those of `size` elements at once.
template <class T, class Allocator>
void prepare_pages(std::vector<T, Allocator>& v, std::size_t size) {
    wish_for_huge_pages(static_cast<void*>(v.data() + v.size()), (v.capacity() - v.size()) * sizeof(T));
    map_at_once(v, size);
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
/// Reserves room for `size` elements, growing by half at least, so that many small calls take linear time in total.
template <class T, class Allocator>
void make_room(std::vector<T, Allocator>& v, std::size_t size) {
    if (size <= v.capacity()) return;
    v.reserve(std::max(size, v.capacity() + v.capacity() / 2));
    prepare_pages(v, size);
}

/// Allocator for containers, by grow_memory() and free_memory().
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

/// A vector of working data that is freed by the end of a run, so that the next run can take over its memory.
template <class T>
using PoolVector = std::vector<T, PoolAllocator<T>>;

/// Base of classes whose objects are allocated by grow_memory().
struct PoolNew {
    static void* operator new(std::size_t bytes) { return new_memory(bytes); }
    static void operator delete(void* memory, std::size_t bytes) noexcept { free_memory(memory, bytes); }
};

/// A growing array of plain records, for pools of many gigabytes and for scratch memory: new elements are not
/// initialised, and large blocks grow by remapping their pages, where std::vector copies and holds two blocks.
template <class T>
class PodArray {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignof(std::max_align_t));

  public:
    PodArray() = default;
    PodArray(const PodArray& other) {
        resize(other.size_);
        if (size_ != 0) std::memcpy(static_cast<void*>(data_), other.data_, size_ * sizeof(T));
    }
    PodArray(PodArray&& other) noexcept { swap(other); }
    PodArray& operator=(PodArray other) noexcept {
        swap(other);
        return *this;
    }
    ~PodArray() { free_memory(data_, capacity_ * sizeof(T)); }

    void swap(PodArray& other) noexcept {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    std::size_t capacity() const { return capacity_; }
    T* data() { return data_; }
    const T* data() const { return data_; }
    T* begin() { return data_; }
    const T* begin() const { return data_; }
    T* end() { return data_ + size_; }
    const T* end() const { return data_ + size_; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }

    /// Makes room for `capacity` elements; grows by half at least. @throws std::bad_alloc; the array is then unchanged
    void reserve(std::size_t capacity) {
        if (capacity <= capacity_) return;
        capacity = std::max(capacity, capacity_ + capacity_ / 2);
        void* moved = grow_memory(static_cast<void*>(data_), capacity_ * sizeof(T), capacity * sizeof(T));
        if (moved == nullptr) throw std::bad_alloc();
        data_ = static_cast<T*>(moved);
        capacity_ = capacity;
    }
    /// Frees the unused capacity. @throws std::bad_alloc; the array is then unchanged
    void shrink_to_fit() {
        if (capacity_ > size_) *this = PodArray(*this);
    }
    /// New elements hold garbage. Does not throw within the capacity.
    void resize(std::size_t size) {
        reserve(size);
        size_ = size;
    }
    /// New elements are zero bytes.
    void resize_zeroed(std::size_t size) {
        const std::size_t old = size_;
        resize(size);
        if (size > old) std::memset(static_cast<void*>(data_ + old), 0, (size - old) * sizeof(T));
    }
    void push_back(const T& value) {
        const T copy = value;
        resize(size_ + 1);
        data_[size_ - 1] = copy;
    }

  private:
    T* data_ = nullptr;
    std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace detail
}  // namespace tetrakis
