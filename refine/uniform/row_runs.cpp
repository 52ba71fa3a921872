#include "row_runs.hpp"

#include "row_runs_impl.hpp"

#include <cassert>

namespace tetrakis::detail {

#ifdef TETRAKIS_KERNELS_AVX2
RowRun row_run_avx2();  // in row_runs_avx2.cpp
#endif

RowRun row_run(KernelSet set) {
    assert(has_kernels(set));
#ifdef TETRAKIS_KERNELS_AVX2
    if (set == KernelSet::avx2) return row_run_avx2();
#endif
    return run_row;
}

}  // namespace tetrakis::detail
