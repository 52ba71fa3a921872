#include "row_kernels_impl.hpp"

namespace tetrakis::detail {

// Compiled with AVX2; row_kernels() gives it where the processor has that.
const RowKernels& row_kernels_avx2();

const RowKernels& row_kernels_avx2() { return k_row_kernels; }

}  // namespace tetrakis::detail
