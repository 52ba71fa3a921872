#pragma once

#include "huge_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>

namespace tetrakis::detail {

/// Scratch memory of plain records for arrays of many megabytes, on huge pages where the system has them: the first
/// touch of small ones costs more than what is written (bench_uniform: 30 against 5 ns a vertex).
template <class T>
class HugeBuffer {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    /// At least `size` elements, aligned to a cache line; what was in it is lost where it has to grow.
    /// @throws std::bad_alloc
    T* reserve(std::size_t size) {
        if (size <= capacity_) return data_.get();
        constexpr std::size_t k_line = 64;
        const std::size_t bytes = size * sizeof(T) + k_line;
        data_.reset();
        capacity_ = 0;
        void* const memory = grow_memory(nullptr, 0, bytes);
        if (memory == nullptr) throw std::bad_alloc();
        const std::size_t past = reinterpret_cast<std::uintptr_t>(memory) % k_line;
        const std::size_t before = past == 0 ? 0 : k_line - past;
        data_ = {reinterpret_cast<T*>(static_cast<char*>(memory) + before), Free{bytes, before}};
        capacity_ = size;
        return data_.get();
    }
    T* data() { return data_.get(); }

  private:
    struct Free {
        std::size_t bytes = 0, before = 0;
        void operator()(T* p) const { free_memory(reinterpret_cast<char*>(p) - before, bytes); }
    };
    std::unique_ptr<T, Free> data_;
    std::size_t capacity_ = 0;
};

}  // namespace tetrakis::detail
