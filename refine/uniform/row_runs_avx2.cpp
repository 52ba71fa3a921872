#include "row_runs_impl.hpp"

namespace tetrakis::detail {

// Compiled with AVX2; row_run() gives it where the processor has that.
RowRun row_run_avx2();

RowRun row_run_avx2() { return run_row; }

}  // namespace tetrakis::detail
