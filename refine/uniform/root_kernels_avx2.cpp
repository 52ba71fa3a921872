#include "root_kernels_impl.hpp"

namespace tetrakis::detail {

// Compiled with AVX2; root_kernels() calls it where the processor has that.
const RootKernels<float>& root_kernels_avx2(const float*);
const RootKernels<double>& root_kernels_avx2(const double*);

const RootKernels<float>& root_kernels_avx2(const float*) { return k_kernels<float>; }
const RootKernels<double>& root_kernels_avx2(const double*) { return k_kernels<double>; }

}  // namespace tetrakis::detail
