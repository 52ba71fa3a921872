#pragma once

#include <cstddef>
#include <cstdint>

namespace tetrakis::detail {

/// A term of a row: the offset of a point in a root's grid from the result's, counted in numbers (three per point), and
/// its weight.
struct GridTerm {
    std::ptrdiff_t offset;
    double weight;
};

/// A row to be applied along a line of a grid: at `at` first, then each time `step` numbers further on.
struct GridRow {
    const double* at;
    std::ptrdiff_t step;
    const GridTerm* terms;
    std::size_t term_count;
};

/// A line of a root's grid: its first point, and how many numbers further on the next point and the next line begin. On
/// a grid of triangles the neighbours of point p are p +- along, p +- across and p +- (across - along).
struct GridLine {
    const double* first;
    std::ptrdiff_t along, across;
    std::uint32_t segments;
};

/// The inner loops of structured refinement, compiled once per instruction set; all sets give the same bytes. Points
/// are three numbers side by side; one number past the last point of a grid may be read.
struct RowKernels {
    /// Applies one row at `count` points and writes the sums `stride` points apart.
    void (*any)(const GridRow& row, std::uint32_t count, std::uint32_t stride, double* to);
    /// Unit cross products of the sums of two rows, written side by side; a zero product stays zero.
    void (*normals)(const GridRow& first, const GridRow& second, std::uint32_t count, double* to);
    // The regular rules of Catmull-Clark and Loop: finer points on a line, or halfway to the next line across, written
    // side by side without the first and the last. On triangles the next line has one segment less.
    void (*quads_on)(const GridLine& line, double* to);
    void (*quads_between)(const GridLine& line, double* to);
    void (*triangles_on)(const GridLine& line, double* to);
    void (*triangles_between)(const GridLine& line, double* to);
};

/// The kernels for the best instruction set that both this build and this processor support.
const RowKernels& row_kernels();

}  // namespace tetrakis::detail
