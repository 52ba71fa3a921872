#pragma once

#include "huge_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <type_traits>
#include <utility>

namespace tetrakis::detail {

/// A growing array of plain records for pools of many gigabytes: new elements are not initialised, and growth goes
/// through grow_memory(), which moves large blocks by their page tables where std::vector holds and copies both.
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
    std::size_t capacity() const { return capacity_; }
    T* data() { return data_; }
    const T* data() const { return data_; }
    T* begin() { return data_; }
    const T* begin() const { return data_; }
    T* end() { return data_ + size_; }
    const T* end() const { return data_ + size_; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }

    /// Room for `capacity` elements, growing by half at least. @throws std::bad_alloc, with the array as it was
    void reserve(std::size_t capacity) {
        if (capacity <= capacity_) return;
        capacity = std::max(capacity, capacity_ + capacity_ / 2);
        void* moved = grow_memory(static_cast<void*>(data_), capacity_ * sizeof(T), capacity * sizeof(T));
        if (moved == nullptr) throw std::bad_alloc();
        data_ = static_cast<T*>(moved);
        capacity_ = capacity;
    }
    /// Gives back the room for more. @throws std::bad_alloc, with the array as it was
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

}  // namespace tetrakis::detail
