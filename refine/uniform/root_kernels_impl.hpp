// The body of root_kernels_*.cpp: compiled once per instruction set, so all of it has internal linkage, and it includes
// nothing whose inline functions could leak from one set into another.
#pragma once

#include "root_kernels.hpp"

#if defined(__SSE2__)
#    include <immintrin.h>
#endif

namespace tetrakis::detail {

namespace {

/// A point in a register of four lanes; the fourth holds whatever follows.
template <class T>
struct Lanes {
    typedef T Type __attribute__((vector_size(4 * sizeof(T))));
};
template <class T>
using Lane = typename Lanes<T>::Type;

#define TETRAKIS_INLINE __attribute__((always_inline))

template <class T>
TETRAKIS_INLINE inline Lane<T> load(const T* p) {
    Lane<T> v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
}
/// Overwrites the scalar after the point: only where that is written later.
template <class T>
TETRAKIS_INLINE inline void store(T* p, const Lane<T>& v) {
    __builtin_memcpy(p, &v, sizeof v);
}
template <class T>
TETRAKIS_INLINE inline void store_last(T* p, const Lane<T>& v) {
    // As two and one: to copy three goes by way of the stack.
    typedef T Two __attribute__((vector_size(2 * sizeof(T))));
    const Two two = __builtin_shufflevector(v, v, 0, 1);
    __builtin_memcpy(p, &two, sizeof two);
    p[2] = v[2];
}
/// @param last  nothing follows that could be written over
template <class T>
TETRAKIS_INLINE inline void store(T* p, const Lane<T>& v, bool last) {
    if (last)
        store_last(p, v);
    else
        store(p, v);
}

/// Point i of a line of n + 1 without turns.
template <class T>
TETRAKIS_INLINE inline const T* point_of(const PointLine<T>& line, std::uint32_t i, std::uint32_t n) {
    return i == 0 ? line.first : i == n ? line.last : line.inner + (static_cast<std::ptrdiff_t>(i) - 1) * line.step;
}

/// The inner points of a lattice row, one after the other. `Side`: it may be a side of the root.
template <bool Side, class T>
struct QuadRow {
    const T* next;
    std::ptrdiff_t step;
    TETRAKIS_INLINE const T* take() {
        const T* p = next;
        next += Side ? step : 3;
        return p;
    }
};
template <bool Side, class T>
TETRAKIS_INLINE inline QuadRow<Side, T> quad_row(const RootLines<T>& root, std::uint32_t r) {
    if (Side && r == 0) return {root.bottom.inner, root.bottom.step};
    if (Side && r == root.segments) return {root.top.inner, root.top.step};
    return {root.inner + 3 * (std::uint64_t{r - 1} * (root.segments - 1)), 3};
}

/// One finer row of 2 n - 1 points from means across the coarse rows: column() is that of the next inner points, left
/// and right are those of the sides.
template <class T, class Column>
TETRAKIS_INLINE inline void refine_quad_columns(std::uint32_t n, const QuadWeights<T>& w, const Lane<T>& left,
                                                const Lane<T>& right, Column column, T* out) {
    const T half = T(0.5);
    Lane<T> p0{}, p1 = left, p2;
    for (std::uint32_t x = 0; x + 1 < n; ++x, out += 6) {
        p2 = column();
        if (x > 0) store(out - 3, w.side * (p0 + p2) + w.centre * p1);
        store(out, half * (p1 + p2));
        p0 = p1;
        p1 = p2;
    }
    p2 = right;
    if (n > 1) store(out - 3, w.side * (p0 + p2) + w.centre * p1);
    store_last(out, half * (p1 + p2));
}

/// Finer rows 2 row (for row > 0) and 2 row + 1, which lie on and above coarse row `row`. One after the other: where
/// they are not in the caches, to write both at once takes more than twice as long. `Side`: one of the coarse rows is a
/// side of the root.
template <bool On, bool Side, class T>
TETRAKIS_INLINE inline void refine_quad_rows(const RootLines<T>& root, std::uint32_t row, const QuadWeights<T>& w,
                                             T* finer) {
    const std::uint32_t n = root.segments;
    const std::uint64_t stride = 3 * std::uint64_t{2 * n - 1};
    if constexpr (On) {
        QuadRow<Side, T> a = quad_row<Side>(root, row - 1), b = quad_row<Side>(root, row),
                         c = quad_row<Side>(root, row + 1);
        const auto mean = [&](const T* pa, const T* pb, const T* pc)
                              TETRAKIS_INLINE { return w.side * (load(pa) + load(pc)) + w.centre * load(pb); };
        const auto side = [&](const PointLine<T>& s) TETRAKIS_INLINE {
            return mean(point_of(s, row - 1, n), point_of(s, row, n), point_of(s, row + 1, n));
        };
        const auto column = [&]() TETRAKIS_INLINE { return mean(a.take(), b.take(), c.take()); };
        refine_quad_columns(n, w, side(root.left), side(root.right), column, finer + (2 * row - 1) * stride);
    }
    QuadRow<Side, T> b = quad_row<Side>(root, row), c = quad_row<Side>(root, row + 1);
    const auto mean = [&](const T* pb, const T* pc) TETRAKIS_INLINE { return T(0.5) * (load(pb) + load(pc)); };
    const auto side = [&](const PointLine<T>& s)
                          TETRAKIS_INLINE { return mean(point_of(s, row, n), point_of(s, row + 1, n)); };
    const auto column = [&]() TETRAKIS_INLINE { return mean(b.take(), c.take()); };
    refine_quad_columns(n, w, side(root.left), side(root.right), column, finer + 2 * row * stride);
}

template <class T>
void refine_quad(const RootLines<T>& root, QuadWeights<T> w, T* finer) {
    const std::uint32_t n = root.segments;
    refine_quad_rows<false, true>(root, 0, w, finer);
    for (std::uint32_t row = 1; row < n; ++row) {
        if (row == 1 || row + 1 == n)
            refine_quad_rows<true, true>(root, row, w, finer);
        else
            refine_quad_rows<true, false>(root, row, w, finer);
    }
}

/// As refine_quad_rows(), by half-steps. The centres between rows r - 1 and r give way to those between r and r + 1.
template <bool On, bool Side, class T>
TETRAKIS_INLINE inline void factored_quad_rows(const RootLines<T>& root, std::uint32_t row, T* centres, T* finer) {
    const std::uint32_t n = root.segments;
    const std::uint64_t stride = 3 * std::uint64_t{2 * n - 1};
    const T half = T(0.5), quarter = T(0.25), sixteenth = T(0.0625);
    const Lane<T> b_first = load(point_of(root.left, row, n)), c_first = load(point_of(root.left, row + 1, n));
    {
        QuadRow<Side, T> b = quad_row<Side>(root, row), c = quad_row<Side>(root, row + 1),
                         a = On ? quad_row<Side>(root, row - 1) : b;
        T* on = finer + (2 * row - (On ? 1 : 0)) * stride;
        Lane<T> a1{}, b0{}, b1 = b_first, c1 = c_first, cells0{};
        const auto cell = [&](std::uint32_t x, const T* pa, const T* pb, const T* pc, bool last) TETRAKIS_INLINE {
            const std::uint64_t at = 3 * std::uint64_t{x};
            const Lane<T> b2 = load(pb), c2 = load(pc), centre = quarter * ((b1 + c1) + (b2 + c2));
            if constexpr (On) {
                const Lane<T> cells = load(centres + at) + centre;
                if (x > 0) store(on + 2 * at - 3, half * b1 + sixteenth * (((b0 + b2) + (a1 + c1)) + (cells0 + cells)));
                store(on + 2 * at, quarter * ((b1 + b2) + cells), last);
                if (!last) a1 = load(pa);
                cells0 = cells;
            }
            store_last(centres + at, centre);
            b0 = b1;
            b1 = b2;
            c1 = c2;
        };
        for (std::uint32_t x = 0; x + 1 < n; ++x) cell(x, On ? a.take() : nullptr, b.take(), c.take(), false);
        cell(n - 1, nullptr, point_of(root.right, row, n), point_of(root.right, row + 1, n), true);
    }
    QuadRow<Side, T> b = quad_row<Side>(root, row), c = quad_row<Side>(root, row + 1);
    T* between = finer + 2 * row * stride;
    Lane<T> sides = b_first + c_first, centre0{};
    for (std::uint32_t x = 0; x < n; ++x, between += 6) {
        const Lane<T> centre = load(centres + 3 * std::uint64_t{x});
        if (x > 0) store(between - 3, quarter * (sides + (centre0 + centre)));
        if (x + 1 == n) {
            store_last(between, centre);
            break;
        }
        store(between, centre);
        sides = load(b.take()) + load(c.take());
        centre0 = centre;
    }
}

template <class T>
void factored_quad(const RootLines<T>& root, T* centres, T* finer) {
    const std::uint32_t n = root.segments;
    factored_quad_rows<false, true>(root, 0, centres, finer);
    for (std::uint32_t row = 1; row < n; ++row) {
        if (row == 1 || row + 1 == n)
            factored_quad_rows<true, true>(root, row, centres, finer);
        else
            factored_quad_rows<true, false>(root, row, centres, finer);
    }
}

/// Finer rows 2 row (for row > 0) and 2 row + 1, one after the other as in refine_quad_rows(). `Side`: the row or the
/// one below it is the root's bottom.
template <bool On, bool Side, class T>
TETRAKIS_INLINE inline void refine_triangle_rows(const RootLines<T>& root, std::uint32_t row,
                                                 const TriangleWeights<T>& w, T* on) {
    const std::uint32_t n = root.segments, last = n - row;  // of row `row`; one more below it, one less above
    const std::ptrdiff_t bottom = Side ? root.bottom.step : 3;
    /// What point x = 1 of a line lies at.
    const auto line = [&](std::uint32_t y) TETRAKIS_INLINE {
        if (Side && y == 0) return root.bottom.inner;
        const std::uint64_t begin = std::uint64_t{y - 1} * (n - 1) - std::uint64_t{y - 1} * y / 2;
        return root.inner + 3 * begin;
    };
    const Lane<T> b_first = load(point_of(root.left, row, n)), c_first = load(point_of(root.left, row + 1, n)),
                  b_last = load(point_of(root.right, row, n));
    if constexpr (On) {
        const T *u = line(row - 1), *b = line(row), *c = line(row + 1);
        const std::ptrdiff_t below = row == 1 ? bottom : 3;
        Lane<T> u1 = load(point_of(root.left, row - 1, n)), b0{}, b1 = b_first, c0{}, c1 = c_first;
        for (std::uint32_t x = 0; x < last; ++x, u += below, b += 3, c += 3) {
            const bool end = x + 1 == last;
            const Lane<T> u2 = load(u), b2 = end ? b_last : load(b);
            T* const out = on + 6 * std::uint64_t{x};
            if (x > 0) store(out - 3, w.vertex * b1 + w.neighbour * (((b0 + b2) + (u1 + u2)) + (c0 + c1)));
            store(out, w.end * (b1 + b2) + w.opposite * (c1 + u2), end);
            u1 = u2;
            b0 = b1;
            b1 = b2;
            c0 = c1;
            if (!end) c1 = load(x + 2 == last ? point_of(root.right, row + 1, n) : c);
        }
    }
    T* const between = on + (On ? 3 * std::uint64_t{2 * last - 1} : 0);
    const T *b = line(row), *c = line(row + 1);
    Lane<T> b1 = b_first, c0{}, c1 = c_first;
    for (std::uint32_t x = 0; x < last; ++x, b += On ? 3 : bottom, c += 3) {
        const bool end = x + 1 == last;
        const Lane<T> b2 = end ? b_last : load(b);
        T* const out = between + 6 * std::uint64_t{x};
        if (x > 0) store(out - 3, w.end * (b1 + c1) + w.opposite * (c0 + b2), end);
        if (end) break;
        const Lane<T> c2 = load(x + 2 == last ? point_of(root.right, row + 1, n) : c);
        store(out, w.end * (b2 + c1) + w.opposite * (b1 + c2));
        b1 = b2;
        c0 = c1;
        c1 = c2;
    }
}

template <class T>
void refine_triangle(const RootLines<T>& root, TriangleWeights<T> w, T* finer) {
    const std::uint32_t n = root.segments;
    refine_triangle_rows<false, true>(root, 0, w, finer);
    T* out = finer + 3 * std::uint64_t{2 * n - 2};
    for (std::uint32_t row = 1; row < n; ++row) {
        if (row == 1)
            refine_triangle_rows<true, true>(root, row, w, out);
        else
            refine_triangle_rows<true, false>(root, row, w, out);
        out += 3 * (std::uint64_t{4} * (n - row) - 3);
    }
}

template <class T>
void refine_line(const PointLine<T>& line, std::uint32_t n, QuadWeights<T> w, T* finer) {
    const T half = T(0.5);
    const T* next = line.inner;
    Lane<T> p0{}, p1 = load(line.first), p2;
    std::uint64_t at = 0;
    for (std::uint32_t x = 0; x + 1 < n; ++x, at += 6, next += line.step) {
        p2 = load(next);
        if (x > 0) store(finer + at - 3, w.side * (p0 + p2) + w.centre * p1);
        store(finer + at, half * (p1 + p2));
        p0 = p1;
        p1 = p2;
    }
    p2 = load(line.last);
    if (n > 1) store(finer + at - 3, w.side * (p0 + p2) + w.centre * p1);
    store_last(finer + at, half * (p1 + p2));
}

template <class T>
void refine_strip_quads(const PointLine<T>& left, const PointLine<T>& line, const PointLine<T>& right, std::uint32_t n,
                        QuadWeights<T> w, T* finer) {
    const T half = T(0.5);
    const auto mean = [&](const T* l, const T* m, const T* r)
                          TETRAKIS_INLINE { return w.side * (load(l) + load(r)) + w.centre * load(m); };
    const T *l = left.inner, *m = line.inner, *r = right.inner;
    Lane<T> p0{}, p1 = mean(left.first, line.first, right.first), p2;
    std::uint64_t at = 0;
    for (std::uint32_t x = 0; x + 1 < n; ++x, at += 6) {
        p2 = mean(l, m, r);
        l += left.step;
        m += line.step;
        r += right.step;
        if (x > 0) store(finer + at - 3, w.side * (p0 + p2) + w.centre * p1);
        store(finer + at, half * (p1 + p2));
        p0 = p1;
        p1 = p2;
    }
    p2 = mean(left.last, line.last, right.last);
    if (n > 1) store(finer + at - 3, w.side * (p0 + p2) + w.centre * p1);
    store_last(finer + at, half * (p1 + p2));
}

template <class T>
void factored_strip(const PointLine<T>& left, const PointLine<T>& line, const PointLine<T>& right, bool across_left,
                    bool across_right, std::uint32_t n, T* finer) {
    const T half = T(0.5), quarter = T(0.25), sixteenth = T(0.0625);
    const auto centre = [&](bool across, Lane<T> p1, Lane<T> p2, Lane<T> q1, Lane<T> q2) TETRAKIS_INLINE {
        return quarter * (across ? (p1 + q1) + (p2 + q2) : (p1 + p2) + (q1 + q2));
    };
    const T *l = left.inner, *m = line.inner, *r = right.inner;
    Lane<T> p0{}, p1 = load(line.first), l1 = load(left.first), r1 = load(right.first), left0{}, right0{};
    for (std::uint32_t x = 0; x < n; ++x) {
        const bool last = x + 1 == n;
        const Lane<T> p2 = load(last ? line.last : m), l2 = load(last ? left.last : l),
                      r2 = load(last ? right.last : r);
        l += left.step;
        m += line.step;
        r += right.step;
        const Lane<T> centre_left = centre(across_left, p1, p2, l1, l2),
                      centre_right = centre(across_right, p1, p2, r1, r2);
        const std::uint64_t at = 6 * std::uint64_t{x};
        if (x > 0)
            store(finer + at - 3, half * p1 + sixteenth * (((p0 + p2) + (l1 + r1)) +
                                                           ((left0 + centre_left) + (right0 + centre_right))));
        const Lane<T> edge = quarter * ((p1 + p2) + (centre_left + centre_right));
        store(finer + at, edge, last);
        p0 = p1;
        p1 = p2;
        l1 = l2;
        r1 = r2;
        left0 = centre_left;
        right0 = centre_right;
    }
}

template <class T>
void refine_strip_triangles(const PointLine<T>& left, const PointLine<T>& line, const PointLine<T>& right,
                            std::uint32_t n, TriangleWeights<T> w, T* finer) {
    struct Beside {
        const T* next;
        std::ptrdiff_t step, turn;
        TETRAKIS_INLINE const T* take() {
            const T* p = next;
            next += step;
            step += turn;
            return p;
        }
    };
    Beside l{left.inner, left.step, left.turn}, r{right.inner, right.step, right.turn};
    const T* m = line.inner;
    Lane<T> p0{}, p1 = load(line.first), a0{}, b0{};
    std::uint64_t at = 0;
    for (std::uint32_t x = 0; x < n; ++x, at += 6, m += line.step) {
        const bool end = x + 1 == n;
        const Lane<T> p2 = load(end ? line.last : m),
                      a1 = load(x == 0 ? left.first
                                : end  ? left.last
                                       : l.take()),
                      b1 = load(x == 0 ? right.first
                                : end  ? right.last
                                       : r.take());
        if (x > 0) store(finer + at - 3, w.vertex * p1 + w.neighbour * (((p0 + p2) + (a0 + a1)) + (b0 + b1)));
        const Lane<T> middle = w.end * (p1 + p2) + w.opposite * (a1 + b1);
        store(finer + at, middle, end);
        p0 = p1;
        p1 = p2;
        a0 = a1;
        b0 = b1;
    }
}

typedef unsigned Numbers __attribute__((vector_size(16)));

TETRAKIS_INLINE inline void store_numbers(unsigned* p, const Numbers& v) { __builtin_memcpy(p, &v, sizeof v); }

void number_quads(const RootNumbers& root, std::uint32_t* out) {
    const unsigned n = root.segments, inner = n - 1;
    const auto quad = [&](unsigned a, unsigned b, unsigned c, unsigned d) TETRAKIS_INLINE {
        store_numbers(out, Numbers{a, b, c, d});
        out += 4;
    };
    if (n == 1) return quad(root.bottom[0], root.bottom[1], root.top[1], root.top[0]);
    const unsigned last = root.inner + inner * (inner - 1);
    quad(root.bottom[0], root.bottom[1], root.inner, root.left[1]);
    for (unsigned x = 1; x < inner; ++x) quad(root.bottom[x], root.bottom[x + 1], root.inner + x, root.inner + x - 1);
    quad(root.bottom[inner], root.bottom[n], root.right[1], root.inner + inner - 1);
    for (unsigned y = 1; y < inner; ++y) {
        const unsigned low = root.inner + (y - 1) * inner, high = low + inner;
        quad(root.left[y], low, high, root.left[y + 1]);
        Numbers v{low, low + 1, high + 1, high};
        for (unsigned x = 1; x < inner; ++x, out += 4) {
            store_numbers(out, v);
            v += 1;
        }
        quad(high - 1, root.right[y], root.right[y + 1], high + inner - 1);
    }
    quad(root.left[inner], last, root.top[1], root.top[0]);
    for (unsigned x = 1; x < inner; ++x) quad(last + x - 1, last + x, root.top[x + 1], root.top[x]);
    quad(last + inner - 1, root.right[inner], root.top[n], root.top[inner]);
}

/// Line y has the points 0 ... n - y; the lines at hand are copied to where the root's bottom and top were, and beside
/// these. Each is written well before it is read: to read in larger pieces what has just been written takes long.
void number_triangles(const RootNumbers& root, std::uint32_t* out) {
    unsigned *low = root.bottom, *high = root.top, *after = root.spare, inner = root.inner;
    const unsigned n = root.segments;
    const auto fill = [&](unsigned* line, unsigned y) TETRAKIS_INLINE {
        line[0] = root.left[y];
        for (unsigned x = 1; x + y < n; ++x) line[x] = inner++;
        line[n - y] = root.right[y];
    };
    fill(high, 1);
    for (unsigned y = 0, last = n; last > 0; ++y, --last) {
        if (y + 2 <= n) fill(after, y + 2);
        unsigned x = 0;
        for (; x + 2 < last; x += 2, out += 12) {
            Numbers a, b;
            __builtin_memcpy(&a, low + x, sizeof a);
            __builtin_memcpy(&b, high + x, sizeof b);
            store_numbers(out, __builtin_shufflevector(a, b, 0, 1, 4, 1));
            store_numbers(out + 4, __builtin_shufflevector(a, b, 5, 4, 1, 2));
            store_numbers(out + 8, __builtin_shufflevector(a, b, 5, 2, 6, 5));
        }
        for (; x < last; ++x) {
            *out++ = low[x];
            *out++ = low[x + 1];
            *out++ = high[x];
            if (x + 1 == last) break;
            *out++ = low[x + 1];
            *out++ = high[x + 1];
            *out++ = high[x];
        }
        unsigned* const free = low;
        low = high;
        high = after;
        after = free;
    }
}

/// 1 / sqrt, correctly rounded twice, so alike in every variant.
TETRAKIS_INLINE inline Lane<double> inverse_root(const Lane<double>& s) {
#if defined(__AVX2__)
    return 1.0 / Lane<double>(_mm256_sqrt_pd(__m256d(s)));
#else
    Lane<double> r;
    for (int i = 0; i < 4; ++i) r[i] = __builtin_sqrt(s[i]);
    return 1.0 / r;
#endif
}
TETRAKIS_INLINE inline Lane<float> inverse_root(const Lane<float>& s) {
#if defined(__SSE2__)
    return 1.0f / Lane<float>(_mm_sqrt_ps(__m128(s)));
#else
    Lane<float> r;
    for (int i = 0; i < 4; ++i) r[i] = __builtin_sqrtf(s[i]);
    return 1.0f / r;
#endif
}

/// Four points, as they are stored (three registers) or by component.
template <class T>
struct FourPoints {
    Lane<T> a, b, c;

    /// The lanes of each component are in three different places, so blends collect them and one permutation sorts.
    TETRAKIS_INLINE FourPoints by_component() const {
        const Lane<T> x = __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 1, 6, 3), c, 0, 5, 2, 3);
        const Lane<T> y = __builtin_shufflevector(__builtin_shufflevector(a, b, 4, 1, 2, 7), c, 0, 1, 6, 3);
        const Lane<T> z = __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 5, 2, 3), c, 4, 1, 2, 7);
        return {__builtin_shufflevector(x, x, 0, 3, 2, 1), __builtin_shufflevector(y, y, 1, 0, 3, 2),
                __builtin_shufflevector(z, z, 2, 1, 0, 3)};
    }
    TETRAKIS_INLINE FourPoints by_point() const {
        const Lane<T> x = __builtin_shufflevector(a, a, 0, 3, 2, 1), y = __builtin_shufflevector(b, b, 1, 0, 3, 2),
                      z = __builtin_shufflevector(c, c, 2, 1, 0, 3);
        return {__builtin_shufflevector(__builtin_shufflevector(x, y, 0, 5, 2, 3), z, 0, 1, 6, 3),
                __builtin_shufflevector(__builtin_shufflevector(y, z, 0, 5, 2, 3), x, 0, 1, 6, 3),
                __builtin_shufflevector(__builtin_shufflevector(z, x, 0, 5, 2, 3), y, 0, 1, 6, 3)};
    }
    /// Only the first `count` points.
    TETRAKIS_INLINE void put(T* out, std::uint32_t count) const {
        if (count >= 4) {
            store(out, a);
            store(out + 4, b);
            store(out + 8, c);
            return;
        }
        T all[12];
        store(all, a);
        store(all + 4, b);
        store(all + 8, c);
        for (std::uint32_t i = 0; i < 3 * count; ++i) out[i] = all[i];
    }
    TETRAKIS_INLINE void clip(std::uint32_t count) {
        T all[12] = {};
        put(all, count);
        *this = {load(all), load(all + 4), load(all + 8)};
    }
};

/// Limit position and the tangents along x and y, four scalars at a time; scalar k of the result belongs to scalar
/// k + 3 of the lines.
template <class T>
struct QuadLimits {
    static constexpr T k_side = T(1.0 / 6), k_centre = T(2.0 / 3);  // cubic B-spline at its knots
    const T *mean, *step;                                           // the same rule and a difference, across the lines

    TETRAKIS_INLINE void get(std::uint64_t k, Lane<T>& position, Lane<T>& x, Lane<T>& y) const {
        const Lane<T> before = load(mean + k), after = load(mean + k + 6);
        position = k_side * (before + after) + k_centre * load(mean + k + 3);
        x = after - before;
        y = k_side * (load(step + k) + load(step + k + 6)) + k_centre * load(step + k + 3);
    }
};

/// The regular Loop limit masks.
template <class T>
struct TriangleLimits {
    static constexpr T k_vertex = T(0.5), k_neighbour = T(1.0 / 12);
    const T *below, *at, *above;

    TETRAKIS_INLINE void get(std::uint64_t k, Lane<T>& position, Lane<T>& x, Lane<T>& y) const {
        const Lane<T> b0 = load(at + k), b1 = load(at + k + 3), b2 = load(at + k + 6), a0 = load(above + k),
                      a1 = load(above + k + 3), c0 = load(below + k + 3), c1 = load(below + k + 6);
        position = k_vertex * b1 + k_neighbour * (((b0 + b2) + (a0 + a1)) + (c0 + c1));
        x = T(2) * (b2 - b0) + ((a1 - a0) + (c1 - c0));
        y = T(2) * (a1 - c0) + ((b2 - c1) + (a0 - b0));
    }
};

template <bool Positions, bool Normals, class T, class Limits>
TETRAKIS_INLINE inline bool limit_line(const Limits& limits, std::uint32_t count, T* positions, T* normals) {
    Lane<T> sum_x{}, sum_y{}, least = Lane<T>{} + T(__builtin_inf());
    for (std::uint32_t block = 0; block < count; block += 4) {
        // The last four again rather than a shorter rest, where there are four.
        const std::uint32_t k = block + 4 > count && count >= 4 ? count - 4 : block, left = count - k;
        const std::uint64_t at = 3 * std::uint64_t{k};
        FourPoints<T> position, x, y;
        limits.get(at, position.a, x.a, y.a);
        limits.get(at + 4, position.b, x.b, y.b);
        limits.get(at + 8, position.c, x.c, y.c);
        if constexpr (Positions) position.put(positions + at, left);
        if constexpr (Normals) {
            // What lies behind the line's end must not have a say.
            if (left < 4) {
                x.clip(left);
                y.clip(left);
            }
            sum_x += (x.a * x.a + x.b * x.b) + x.c * x.c;
            sum_y += (y.a * y.a + y.b * y.b) + y.c * y.c;
            const FourPoints<T> u = x.by_component(), v = y.by_component();
            const FourPoints<T> cross{u.b * v.c - u.c * v.b, u.c * v.a - u.a * v.c, u.a * v.b - u.b * v.a};
            Lane<T> square = (cross.a * cross.a + cross.b * cross.b) + cross.c * cross.c;
            if (left < 4)
                for (std::uint32_t i = left; i < 4; ++i) square[i] = T(__builtin_inf());
            least = square < least ? square : least;
            const Lane<T> scale = inverse_root(square);
            FourPoints<T>{cross.a * scale, cross.b * scale, cross.c * scale}.by_point().put(normals + at, left);
        }
    }
    if constexpr (Normals) {
        // The tangents of the whole line stand for each point's own: never lets a bad one pass.
        const T bound = k_parallel<T> * k_parallel<T> * ((sum_x[0] + sum_x[1]) + (sum_x[2] + sum_x[3])) *
                        ((sum_y[0] + sum_y[1]) + (sum_y[2] + sum_y[3]));
        return least[0] > bound && least[1] > bound && least[2] > bound && least[3] > bound;
    }
    return true;
}

template <class T, class Limits>
TETRAKIS_INLINE inline bool limit_any(const Limits& limits, std::uint32_t count, T* positions, T* normals) {
    if (positions != nullptr && normals != nullptr) return limit_line<true, true>(limits, count, positions, normals);
    if (normals != nullptr) return limit_line<false, true>(limits, count, positions, normals);
    return limit_line<true, false>(limits, count, positions, normals);
}

template <class T>
bool limit_quads(const T* below, const T* at, const T* above, std::uint32_t count, const T* left, const T* right,
                 T* positions, T* normals, T* scratch) {
    const std::uint64_t length = 3 * (std::uint64_t{count} + 2);
    T *mean = scratch, *step = scratch + length + k_limit_padding;
    const auto column = [&](const T* a, const T* b, const T* c, std::uint64_t i) TETRAKIS_INLINE {
        const Lane<T> p = load(a), r = load(c);
        store(mean + i, QuadLimits<T>::k_side * (p + r) + QuadLimits<T>::k_centre * load(b));
        store(step + i, r - p);
    };
    if (left == nullptr) {
        for (std::uint64_t i = 0; i < length; i += 4) column(below + i, at + i, above + i, i);
    } else {
        column(left, left + 3, left + 6, 0);
        for (std::uint64_t i = 3; i + 3 < length; i += 4) column(below + i, at + i, above + i, i);
        column(right, right + 3, right + 6, length - 3);
    }
    return limit_any(QuadLimits<T>{mean, step}, count, positions, normals);
}

template <class T>
bool limit_triangles(const T* below, const T* at, const T* above, std::uint32_t count, const T*, const T*, T* positions,
                     T* normals, T*) {
    return limit_any(TriangleLimits<T>{below, at, above}, count, positions, normals);
}

template <class T>
constexpr RootKernels<T> k_kernels{refine_quad<T>,    factored_quad<T>,      refine_triangle<T>,
                                   refine_line<T>,    refine_strip_quads<T>, refine_strip_triangles<T>,
                                   factored_strip<T>, limit_quads<T>,        limit_triangles<T>,
                                   number_quads,      number_triangles};

}  // namespace

}  // namespace tetrakis::detail
