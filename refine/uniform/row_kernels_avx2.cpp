#include "row_kernels_impl.hpp"

namespace tetrakis::detail {

// Compiled with AVX2; row_kernels() returns it if the processor has AVX2.
const RowKernels& row_kernels_avx2();

const RowKernels& row_kernels_avx2() { return k_row_kernels; }

}  // namespace tetrakis::detail
