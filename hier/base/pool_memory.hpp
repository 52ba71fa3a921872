#pragma once

#include "huge_memory.hpp"

#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// grow_memory() for containers.
template <class T>
struct PoolAllocator {
    static_assert(alignof(T) <= alignof(std::max_align_t));
    using value_type = T;

    PoolAllocator() = default;
    template <class U>
    PoolAllocator(const PoolAllocator<U>&) noexcept {}

    T* allocate(std::size_t count) {
        void* const memory = grow_memory(nullptr, 0, count * sizeof(T));
        if (memory == nullptr) throw std::bad_alloc();
        return static_cast<T*>(memory);
    }
    void deallocate(T* data, std::size_t count) noexcept { free_memory(data, count * sizeof(T)); }

    template <class U>
    friend bool operator==(const PoolAllocator&, const PoolAllocator<U>&) noexcept {
        return true;
    }
};

/// A vector that does not outlive the run it works for.
template <class T>
using PoolVector = std::vector<T, PoolAllocator<T>>;

/// The same, but resize(n) leaves new elements as they are, with any contents.
template <class T>
struct RawPoolAllocator : PoolAllocator<T> {
    static_assert(std::is_trivial_v<T>);
    template <class U>
    struct rebind {
        using other = RawPoolAllocator<U>;
    };
    template <class U, class... Values>
    void construct(U* at, Values&&... values) {
        if constexpr (sizeof...(Values) > 0) ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
    }
};
template <class T>
using RawPoolVector = std::vector<T, RawPoolAllocator<T>>;

/// `new` and `delete` of what derives from it, by grow_memory().
struct PoolNew {
    static void* operator new(std::size_t bytes) {
        void* const memory = grow_memory(nullptr, 0, bytes);
        if (memory == nullptr) throw std::bad_alloc();
        return memory;
    }
    static void operator delete(void* memory, std::size_t bytes) noexcept { free_memory(memory, bytes); }
};

}  // namespace tetrakis::detail
