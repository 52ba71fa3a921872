#include "row_kernels.hpp"

#include "row_kernels_impl.hpp"

namespace tetrakis::detail {

#ifdef TETRAKIS_KERNELS_AVX2
const RowKernels& row_kernels_avx2();  // in row_kernels_avx2.cpp
#endif

const RowKernels& row_kernels() {
#ifdef TETRAKIS_KERNELS_AVX2
    static const bool avx2 = __builtin_cpu_supports("avx2") != 0;
    if (avx2) return row_kernels_avx2();
#endif
    return k_row_kernels;
}

}  // namespace tetrakis::detail
