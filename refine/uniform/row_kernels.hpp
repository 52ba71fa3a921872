#pragma once

#include <cstddef>
#include <cstdint>

namespace tetrakis::detail {

/// A term of a row: the place of a point in a root's grid, counted in points from the result's, and its weight.
struct GridTerm {
    std::ptrdiff_t offset;
    double weight;
};

/// A row, the first of the points on a line that it is read at, and how many numbers further on the next one begins.
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
    /// Sums of one row for `count` points; written `stride` points apart.
    void (*any)(const GridRow& row, std::uint32_t count, std::uint32_t stride, double* to);
    /// Cross products of two rows' sums, scaled to length 1; zero stays zero. Written side by side.
    void (*normals)(const GridRow& first, const GridRow& second, std::uint32_t count, double* to);
    // Catmull-Clark's and Loop's regular rules: the finer points on a line, or halfway between it and the one across;
    // all but the first and the last of them, one after the other. Between lines of triangles, the one across has a
    // segment less.
    void (*quads_on)(const GridLine& line, double* to);
    void (*quads_between)(const GridLine& line, double* to);
    void (*triangles_on)(const GridLine& line, double* to);
    void (*triangles_between)(const GridLine& line, double* to);
};

/// Of the best instruction set that this build and this processor have.
const RowKernels& row_kernels();

}  // namespace tetrakis::detail
