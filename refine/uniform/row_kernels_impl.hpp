#pragma once

#include "row_kernels.hpp"

// Included by one file per instruction set. All of it is local, so that no set's code is linked into another set's.
namespace tetrakis::detail {
namespace {

#define TETRAKIS_INLINE [[gnu::always_inline]] inline

/// A point in a register of four numbers; the fourth is whatever follows.
typedef double Lane __attribute__((vector_size(4 * sizeof(double))));

TETRAKIS_INLINE Lane load(const double* p) {
    Lane v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
}
/// Also overwrites the number after the point, which must therefore be written later.
TETRAKIS_INLINE void store(double* p, const Lane& v) { __builtin_memcpy(p, &v, sizeof v); }
TETRAKIS_INLINE void store_last(double* p, const Lane& v) {
    // Two numbers and one: a copy of three at once would go through the stack.
    typedef double Two __attribute__((vector_size(2 * sizeof(double))));
    const Two two = __builtin_shufflevector(v, v, 0, 1);
    __builtin_memcpy(p, &two, sizeof two);
    p[2] = v[2];
}
TETRAKIS_INLINE void store(double* p, const Lane& v, bool last) {
    if (last)
        store_last(p, v);
    else
        store(p, v);
}

/// Calls write.operator()<size>(first point) for blocks of points. If `count` is not a multiple of the size, the last
/// block overlaps the one before it.
template <class Write>
TETRAKIS_INLINE void for_each_block_of_points(std::uint32_t count, const Write& write) {
    constexpr std::uint32_t k_block = 4;  // so many sums fit into registers
    if (count < k_block) {
        for (std::uint32_t i = 0; i < count; ++i) write.template operator()<1>(i);
        return;
    }
    for (std::uint32_t i = 0; i < count; i += k_block)
        write.template operator()<k_block>(i + k_block <= count ? i : count - k_block);
}

template <std::uint32_t Points>
TETRAKIS_INLINE void add_sums(const GridRow& row, std::uint32_t first, Lane (&sums)[Points]) {
    const double* const at = row.at + first * row.step;
    for (std::size_t t = 0; t < row.term_count; ++t)
        for (std::uint32_t i = 0; i < Points; ++i)
            sums[i] += row.terms[t].weight * load(at + row.terms[t].offset + i * row.step);
}

void any_row(const GridRow& row, std::uint32_t count, std::uint32_t stride, double* to) {
    for_each_block_of_points(
        count, [&]<std::uint32_t Points>(std::uint32_t begin) __attribute__((always_inline)) {
            Lane sums[Points] = {};
            add_sums(row, begin, sums);
            for (std::uint32_t i = 0; i < Points; ++i) store_last(to + std::size_t{3} * (begin + i) * stride, sums[i]);
        });
}

void unit_normals(const GridRow& first, const GridRow& second, std::uint32_t count, double* to) {
    for_each_block_of_points(
        count, [&]<std::uint32_t Points>(std::uint32_t begin) __attribute__((always_inline)) {
            Lane a[Points] = {}, b[Points] = {};
            add_sums(first, begin, a);
            add_sums(second, begin, b);
            double scale[Points];
            for (std::uint32_t i = 0; i < Points; ++i) {
                a[i] =
                    __builtin_shufflevector(a[i], a[i], 1, 2, 0, 3) * __builtin_shufflevector(b[i], b[i], 2, 0, 1, 3) -
                    __builtin_shufflevector(a[i], a[i], 2, 0, 1, 3) * __builtin_shufflevector(b[i], b[i], 1, 2, 0, 3);
                const Lane squares = a[i] * a[i];
                scale[i] = squares[0] + squares[1] + squares[2];
            }
            for (double& s : scale) s = s == 0 ? 0 : 1 / __builtin_sqrt(s);
            for (std::uint32_t i = 0; i < Points; ++i) store_last(to + std::size_t{3} * (begin + i), scale[i] * a[i]);
        });
}

// The cubic B-spline's rule in each direction.
constexpr double k_side = 0.125, k_centre = 0.75;

/// Finer points along a line from the values of its columns, which are weighted means across the line.
template <class Column>
TETRAKIS_INLINE void refine_columns(std::uint32_t segments, Column column, double* to) {
    Lane p0 = column(0), p1 = column(1);
    for (std::uint32_t x = 2; x <= segments; ++x, to += 6) {
        const Lane p2 = column(x);
        store(to, 0.5 * (p0 + p1));
        store(to + 3, k_side * (p0 + p2) + k_centre * p1);
        p0 = p1;
        p1 = p2;
    }
    store_last(to, 0.5 * (p0 + p1));
}

// The lambdas copy the line: the compiler would read a reference again after each store, which might have changed it.
void quads_on(const GridLine& line, double* to) {
    const auto column = [at = line](std::uint32_t x) __attribute__((always_inline)) {
        const double* const p = at.first + x * at.along;
        return k_side * (load(p - at.across) + load(p + at.across)) + k_centre * load(p);
    };
    refine_columns(line.segments, column, to);
}

void quads_between(const GridLine& line, double* to) {
    const auto column = [at = line](std::uint32_t x) __attribute__((always_inline)) {
        const double* const p = at.first + x * at.along;
        return 0.5 * (load(p) + load(p + at.across));
    };
    refine_columns(line.segments, column, to);
}

// Loop's rules of a vertex with six neighbours, and of an edge.
constexpr double k_vertex = 0.625, k_neighbour = 0.0625, k_end = 0.375, k_opposite = 0.125;

void triangles_on(const GridLine& line, double* to) {
    const std::ptrdiff_t along = line.along;
    const double *at = line.first, *above = at + line.across, *below = at - line.across + along;
    // Points around the current segment: b on the line itself, a on the line above, c on the line below.
    Lane b0{}, b1 = load(at), a0{}, c0 = load(below - along);
    for (std::uint32_t x = 0; x < line.segments; ++x, to += 6) {
        at += along;
        const Lane b2 = load(at), a1 = load(above), c1 = load(below);
        above += along;
        below += along;
        if (x > 0) store(to - 3, k_vertex * b1 + k_neighbour * (((b0 + b2) + (c0 + c1)) + (a0 + a1)));
        store(to, k_end * (b1 + b2) + k_opposite * (a1 + c1), x + 1 == line.segments);
        b0 = b1;
        b1 = b2;
        a0 = a1;
        c0 = c1;
    }
}

void triangles_between(const GridLine& line, double* to) {
    const std::ptrdiff_t along = line.along;
    const double *at = line.first + along, *above = line.first + line.across;
    Lane b0 = load(line.first), b1 = load(at), a0 = load(above);
    for (std::uint32_t x = 1; x < line.segments; ++x, to += 6) {
        at += along;
        above += along;
        const Lane b2 = load(at), a1 = load(above);
        store(to, k_end * (b1 + a0) + k_opposite * (b0 + a1));
        store(to + 3, k_end * (b1 + a1) + k_opposite * (a0 + b2), x + 1 == line.segments);
        b0 = b1;
        b1 = b2;
        a0 = a1;
    }
}

constexpr RowKernels k_row_kernels{any_row, unit_normals, quads_on, quads_between, triangles_on, triangles_between};

}  // namespace
}  // namespace tetrakis::detail
