#include "root_kernels.hpp"

#include "root_kernels_impl.hpp"

#include <cassert>

namespace tetrakis::detail {

#ifdef TETRAKIS_KERNELS_AVX2
// In root_kernels_avx2.cpp; the argument only chooses the scalar.
const RootKernels<float>& root_kernels_avx2(const float*);
const RootKernels<double>& root_kernels_avx2(const double*);
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

template <class T>
const RootKernels<T>& root_kernels(KernelSet set) {
    assert(has_kernels(set));
#ifdef TETRAKIS_KERNELS_AVX2
    if (set == KernelSet::avx2) return root_kernels_avx2(static_cast<const T*>(nullptr));
#endif
    return k_kernels<T>;
}

template const RootKernels<float>& root_kernels<float>(KernelSet set);
template const RootKernels<double>& root_kernels<double>(KernelSet set);

}  // namespace tetrakis::detail
