#pragma once

#include <cstddef>
#include <cstdint>

namespace tetrakis::detail {

/// One root of one level as the row kernels see it. Points are three scalars each, and may be read one scalar past the
/// end. N segments a side. Quads: lines of N + 1 points along the sides, with x or y: bottom (y = 0), top (y = N), left
/// (x = 0), right (x = N), corners included in each. Triangles: bottom (y = 0, by x), left (x = 0, by y), and `right`
/// the points (N - y, y), by y; no top.
template <class T>
struct RootRows {
    const T* inner;
    const T *bottom, *top, *left, *right;
    std::uint32_t segments;
};

/// A line of points where they are: its ends, and its inner points, which lie `step` scalars apart; the step itself
/// grows by `turn`. A line of one point is its first.
template <class T>
struct PointLine {
    const T *first, *inner, *last;
    std::ptrdiff_t step, turn;
};

/// As RootRows, with its sides where they are.
template <class T>
struct RootLines {
    const T* inner;
    PointLine<T> bottom, top, left, right;
    std::uint32_t segments;
};

/// The vertex numbers of a root: lines along its sides as in RootRows, and the first of its inner ones. N + 1 places
/// each, for triangles also in `top`; what numbers triangles writes over bottom and top.
struct RootNumbers {
    std::uint32_t *left, *right, *bottom, *top;
    std::uint32_t* spare;  ///< as long as they are
    std::uint32_t inner;
    std::uint32_t segments;
};

/// Weights of the rows' rules, so that one kernel serves a scheme and its linear counterpart.
template <class T>
struct QuadWeights {
    T side, centre;  ///< of a vertex along one direction: neighbours, itself; 1/8, 3/4 for Catmull-Clark; 0, 1 linear
};
template <class T>
struct TriangleWeights {
    T vertex, neighbour;  ///< 5/8, 1/16 for Loop; 1, 0 linear
    T end, opposite;      ///< of an edge: 3/8, 1/8 for Loop; 1/2, 0 linear
};

/// Tangents whose sine is below this are parallel but for rounding.
template <class T>
inline constexpr T k_parallel = T(1e-10);
template <>
inline constexpr float k_parallel<float> = 1e-5f;

/// Points are taken by fours: 12 scalars, of which 3 are the line's own at least, and 6 to the next neighbour but one.
inline constexpr std::uint32_t k_limit_padding = 16;

/// Row kernels; every variant of them (see root_kernels()) gives the same bits. None allocates, none throws.
template <class T>
struct RootKernels {
    /// Inner points of a quad root one level on: 2 N - 1 rows of 2 N - 1 points.
    void (*refine_quad)(const RootLines<T>& root, QuadWeights<T> weights, T* finer);
    /// The same in two half-steps. First: the centres of the root's faces (means of their corners), and from them the
    /// inner vertices moved by Catmull-Clark's corner rule; second: the inner edge points between the vertices as they
    /// were and the centres.
    /// @param centres  3 N + 1 scalars of scratch
    void (*factored_quad)(const RootLines<T>& root, T* centres, T* finer);
    /// Inner points of a triangle root one level on, in RootLayout's order.
    void (*refine_triangle)(const RootLines<T>& root, TriangleWeights<T> weights, T* finer);
    /// The 2 N - 1 inner points of a line of N + 1 points by the vertex rule given and midpoints.
    void (*refine_line)(const PointLine<T>& line, std::uint32_t segments, QuadWeights<T> weights, T* finer);
    /// The same between lines beside it, by the smooth rules; triangles: N points in each, the first beside the line's
    /// first piece.
    void (*refine_strip_quads)(const PointLine<T>& left, const PointLine<T>& line, const PointLine<T>& right,
                               std::uint32_t segments, QuadWeights<T> weights, T* finer);
    void (*refine_strip_triangles)(const PointLine<T>& left, const PointLine<T>& line, const PointLine<T>& right,
                                   std::uint32_t segments, TriangleWeights<T> weights, T* finer);
    /// refine_strip_quads() in two half-steps: the centres of the faces beside the line and its vertices, then its edge
    /// points.
    /// @param across_left, across_right  whether their root has the line along x: the order that corners are added in
    void (*factored_strip)(const PointLine<T>& left, const PointLine<T>& line, const PointLine<T>& right,
                           bool across_left, bool across_right, std::uint32_t segments, T* finer);
    /// Limit positions and unit normals, where not null, of the points 1 ... count of lattice line `at` between the
    /// lines below (y - 1) and above; x is the place in each. Their normals point to x cross y.
    /// Returns false where the tangents of some point may not span a plane: its normal is then worth nothing.
    /// @param left, right  null, or (quads) the lines' first and last points, three in a row, where they are not in
    /// place
    /// @param scratch  2 (3 (count + 2) + k_limit_padding) scalars; the lines may be read k_limit_padding scalars past
    /// their
    ///                 ends (what is there counts for nothing)
    bool (*limit_quads)(const T* below, const T* at, const T* above, std::uint32_t count, const T* left, const T* right,
                        T* positions, T* normals, T* scratch);
    bool (*limit_triangles)(const T* below, const T* at, const T* above, std::uint32_t count, const T* left,
                            const T* right, T* positions, T* normals, T* scratch);
    /// Corners of the N^2 faces of a root, as UniformRefiner orders them.
    void (*number_quads)(const RootNumbers& root, std::uint32_t* corners);
    void (*number_triangles)(const RootNumbers& root, std::uint32_t* corners);
};

/// Instruction sets that kernels are compiled for.
enum class KernelSet { baseline, avx2 };

/// Whether this build and this processor have it.
bool has_kernels(KernelSet set);
/// The best set there is.
KernelSet best_kernels();
/// float and double.
template <class T>
const RootKernels<T>& root_kernels(KernelSet set);

}  // namespace tetrakis::detail
