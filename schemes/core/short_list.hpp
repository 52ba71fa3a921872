#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace tetrakis {

/// A list of a few plain values that allocates nothing up to N of them: rings and mask rows, which rules make by the
/// million.
template <class T, std::size_t N>
class ShortList {
    static_assert(std::is_trivially_copy_constructible_v<T> && std::is_trivially_destructible_v<T>);

  public:
    using value_type = T;

    ShortList() = default;
    ShortList(std::initializer_list<T> values) { assign(values.begin(), values.size()); }
    ShortList(const ShortList& other) { assign(other.begin(), other.size_); }
    ShortList(ShortList&& other) noexcept { take(other); }
    ShortList& operator=(const ShortList& other) {
        if (this != &other) {
            size_ = 0;
            assign(other.begin(), other.size_);
        }
        return *this;
    }
    ShortList& operator=(ShortList&& other) noexcept {
        if (this != &other) take(other);
        return *this;
    }

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    T* data() { return heap_ ? heap_.get() : here(); }
    const T* data() const { return heap_ ? heap_.get() : here(); }
    T* begin() { return data(); }
    const T* begin() const { return data(); }
    T* end() { return data() + size_; }
    const T* end() const { return data() + size_; }
    T& operator[](std::size_t i) { return data()[i]; }
    const T& operator[](std::size_t i) const { return data()[i]; }
    const T& front() const { return data()[0]; }
    const T& back() const { return data()[size_ - 1]; }

    void clear() { size_ = 0; }
    void assign(const T* values, std::size_t count) {
        if (count > capacity_) grow(std::max(count, 2 * capacity_));
        std::uninitialized_copy(values, values + count, data());
        size_ = count;
    }
    /// Keeps the first `count` <= size().
    void shorten(std::size_t count) { size_ = count; }
    void push_back(const T& value) {
        const T copy = value;
        if (size_ == capacity_) grow(2 * capacity_);
        std::construct_at(data() + size_++, copy);
    }
    template <class... Args>
    void emplace_back(Args&&... args) {
        push_back(T(std::forward<Args>(args)...));
    }

  private:
    T* here() { return std::launder(reinterpret_cast<T*>(bytes_)); }
    const T* here() const { return std::launder(reinterpret_cast<const T*>(bytes_)); }
    void grow(std::size_t capacity) {
        auto larger = std::make_unique<T[]>(capacity);
        std::copy(begin(), end(), larger.get());
        heap_ = std::move(larger);
        capacity_ = capacity;
    }
    void take(ShortList& other) {
        if (other.heap_) {
            heap_ = std::move(other.heap_);
            capacity_ = std::exchange(other.capacity_, N);
            size_ = std::exchange(other.size_, 0);
            return;
        }
        size_ = 0;
        assign(other.here(), other.size_);  // fits: no list holds less than N
    }

    std::size_t size_ = 0, capacity_ = N;
    std::unique_ptr<T[]> heap_;
    alignas(T) std::byte bytes_[N * sizeof(T)];
};

}  // namespace tetrakis
