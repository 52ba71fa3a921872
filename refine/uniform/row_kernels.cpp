#include "row_kernels.hpp"

#include "row_kernels_impl.hpp"

#include <cassert>

namespace tetrakis::detail {

#ifdef TETRAKIS_KERNELS_AVX2
const RowKernels& row_kernels_avx2();  // in row_kernels_avx2.cpp
#endif

bool has_kernels(KernelSet set) {
    if (set == KernelSet::baseline) return true;
#ifdef TETRAKIS_KERNELS_AVX2
    static const bool avx2 = __builtin_cpu_supports("avx2") != 0;
    return avx2;
#else
    return false;
#endif
}

KernelSet best_kernels() { return has_kernels(KernelSet::avx2) ? KernelSet::avx2 : KernelSet::baseline; }

const RowKernels& row_kernels(KernelSet set) {
    assert(has_kernels(set));
#ifdef TETRAKIS_KERNELS_AVX2
    if (set == KernelSet::avx2) return row_kernels_avx2();
#endif
    return k_row_kernels;
}

}  // namespace tetrakis::detail
