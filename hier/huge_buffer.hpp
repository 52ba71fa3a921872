#pragma once

#include "tetrakis/hier/huge_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
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
        constexpr std::size_t k_line = 64, k_huge = std::size_t{2} << 20;
        const bool huge = size * sizeof(T) >= 2 * k_huge;
        const std::size_t unit = huge ? k_huge : k_line;
        const std::size_t bytes = (size * sizeof(T) + unit - 1) / unit * unit;
        data_.reset();
        capacity_ = 0;
        void* memory = std::aligned_alloc(unit, bytes);
        if (memory == nullptr) throw std::bad_alloc();
        data_.reset(static_cast<T*>(memory));
        capacity_ = size;
        wish_for_huge_pages(memory, bytes);
        return data_.get();
    }
    T* data() { return data_.get(); }

  private:
    struct Free {
        void operator()(T* p) const { std::free(p); }
    };
    std::unique_ptr<T, Free> data_;
    std::size_t capacity_ = 0;
};

}  // namespace tetrakis::detail
