// The body of root_kernels_*.cpp: compiled once per instruction set, so all of it has internal linkage, and it includes
// nothing whose inline functions could leak from one set into another.
#pragma once

#include "tetrakis/refine/root_kernels.hpp"

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
    __builtin_memcpy(p, &v, 3 * sizeof(T));
}

/// Two finer rows between and on coarse rows r and r + 1, r = row; the first of them only for r > 0.
template <bool On, class T>
TETRAKIS_INLINE inline void refine_quad_rows(const RootRows<T>& root, std::uint32_t row, const QuadWeights<T>& w,
                                             T* finer) {
    const std::uint32_t n = root.segments, inner = n - 1;
    const auto line = [&](std::uint32_t r) TETRAKIS_INLINE {
        // So that column x of any row is 3 x scalars on.
        return r == 0 ? root.bottom : r == n ? root.top : root.inner + 3 * (std::uint64_t{r - 1} * inner) - 3;
    };
    const T* b = line(row);
    const T* c = line(row + 1);
    const T* a = On ? line(row - 1) : b;
    const std::uint64_t stride = 3 * std::uint64_t{2 * n - 1};
    T* between = finer + 2 * row * stride;
    T* on = between - (On ? stride : 0);
    const T half = T(0.5);

    Lane<T> on0{}, on1, on2, mid0{}, mid1, mid2;
    const auto column = [&](const T* pa, const T* pb, const T* pc, Lane<T>& out_on, Lane<T>& out_mid) TETRAKIS_INLINE {
        const Lane<T> vb = load(pb), vc = load(pc);
        if constexpr (On) out_on = w.side * (load(pa) + vc) + w.centre * vb;
        out_mid = half * (vb + vc);
    };
    const auto left = [&](std::uint32_t r) TETRAKIS_INLINE { return root.left + 3 * std::uint64_t{r}; };
    const auto right = [&](std::uint32_t r) TETRAKIS_INLINE { return root.right + 3 * std::uint64_t{r}; };
    const auto even = [&](std::uint32_t x) TETRAKIS_INLINE {
        const std::uint64_t at = 6 * std::uint64_t{x} - 3;
        if constexpr (On) store(on + at, w.side * (on0 + on2) + w.centre * on1);
        store(between + at, w.side * (mid0 + mid2) + w.centre * mid1);
    };
    column(left(On ? row - 1 : 0), left(row), left(row + 1), on1, mid1);
    for (std::uint32_t x = 0; x + 1 < n; ++x) {
        const std::uint64_t next = 3 * std::uint64_t{x} + 3;
        column(a + next, b + next, c + next, on2, mid2);
        if (x > 0) even(x);
        const std::uint64_t at = 6 * std::uint64_t{x};
        if constexpr (On) store(on + at, half * (on1 + on2));
        store(between + at, half * (mid1 + mid2));
        on0 = on1;
        on1 = on2;
        mid0 = mid1;
        mid1 = mid2;
    }
    column(right(On ? row - 1 : 0), right(row), right(row + 1), on2, mid2);
    if (n > 1) even(n - 1);
    const std::uint64_t at = 6 * std::uint64_t{n - 1};
    if constexpr (On) store_last(on + at, half * (on1 + on2));
    store_last(between + at, half * (mid1 + mid2));
}

template <class T>
void refine_quad(const RootRows<T>& root, QuadWeights<T> w, T* finer) {
    refine_quad_rows<false>(root, 0, w, finer);
    for (std::uint32_t row = 1; row < root.segments; ++row) refine_quad_rows<true>(root, row, w, finer);
}

/// Finer rows 2 row (for row > 0) and 2 row + 1.
template <bool On, class T>
TETRAKIS_INLINE inline void refine_triangle_rows(const RootRows<T>& root, std::uint32_t row,
                                                 const TriangleWeights<T>& w, T* on) {
    const std::uint32_t n = root.segments, last = n - row;  // of row `row`; one more below it, one less above
    const auto line = [&](std::uint32_t y) TETRAKIS_INLINE {
        if (y == 0) return root.bottom;
        const std::uint64_t begin = std::uint64_t{y - 1} * (n - 1) - std::uint64_t{y - 1} * y / 2;
        return root.inner + 3 * begin - 3;
    };
    const T* u = On ? line(row - 1) : root.bottom;
    const T* b = line(row);
    const T* c = line(row + 1);
    T* between = on + (On ? 3 * std::uint64_t{2 * last - 1} : 0);
    const auto left = [&](std::uint32_t y) TETRAKIS_INLINE { return root.left + 3 * std::uint64_t{y}; };
    const auto right = [&](std::uint32_t y) TETRAKIS_INLINE { return root.right + 3 * std::uint64_t{y}; };

    Lane<T> u1{}, u2{}, b0{}, b1, b2, c0{}, c1, c2{};
    if constexpr (On) u1 = load(left(row - 1));
    b1 = load(left(row));
    c1 = load(left(row + 1));
    for (std::uint32_t x = 0; x < last; ++x) {
        const std::uint64_t next = 3 * std::uint64_t{x} + 3;
        const bool end = x + 1 == last;
        if constexpr (On) u2 = load(u + next);
        b2 = load(end ? right(row) : b + next);
        if (!end) c2 = load(x + 2 == last ? right(row + 1) : c + next);
        const std::uint64_t at = 6 * std::uint64_t{x};
        if (x > 0) {
            if constexpr (On) store(on + at - 3, w.vertex * b1 + w.neighbour * (((b0 + b2) + (u1 + u2)) + (c0 + c1)));
            const Lane<T> upright = w.end * (b1 + c1) + w.opposite * (c0 + b2);
            if (end)
                store_last(between + at - 3, upright);
            else
                store(between + at - 3, upright);
        }
        if constexpr (On) {
            const Lane<T> flat = w.end * (b1 + b2) + w.opposite * (c1 + u2);
            if (end)
                store_last(on + at, flat);
            else
                store(on + at, flat);
        }
        if (!end) store(between + at, w.end * (b2 + c1) + w.opposite * (b1 + c2));
        if constexpr (On) u1 = u2;
        b0 = b1;
        b1 = b2;
        c0 = c1;
        c1 = c2;
    }
}

template <class T>
void refine_triangle(const RootRows<T>& root, TriangleWeights<T> w, T* finer) {
    const std::uint32_t n = root.segments;
    refine_triangle_rows<false>(root, 0, w, finer);
    T* out = finer + 3 * std::uint64_t{2 * n - 2};
    for (std::uint32_t row = 1; row < n; ++row) {
        refine_triangle_rows<true>(root, row, w, out);
        out += 3 * (std::uint64_t{4} * (n - row) - 3);
    }
}

template <class T>
void refine_line(const T* line, std::uint32_t n, QuadWeights<T> w, T* finer) {
    const T half = T(0.5);
    Lane<T> p0{}, p1 = load(line), p2;
    for (std::uint32_t x = 0; x + 1 < n; ++x) {
        p2 = load(line + 3 * std::uint64_t{x} + 3);
        const std::uint64_t at = 6 * std::uint64_t{x};
        if (x > 0) store(finer + at - 3, w.side * (p0 + p2) + w.centre * p1);
        store(finer + at, half * (p1 + p2));
        p0 = p1;
        p1 = p2;
    }
    p2 = load(line + 3 * std::uint64_t{n});
    const std::uint64_t at = 6 * std::uint64_t{n - 1};
    if (n > 1) store(finer + at - 3, w.side * (p0 + p2) + w.centre * p1);
    store_last(finer + at, half * (p1 + p2));
}

template <class T>
void blend3(const T* p, const T* q, const T* r, T a, T b, std::uint64_t count, T* out) {
    for (std::uint64_t i = 0; i < count; ++i) out[i] = a * (p[i] + r[i]) + b * q[i];
}

template <class T>
constexpr RootKernels<T> k_kernels{refine_quad<T>, refine_triangle<T>, refine_line<T>, blend3<T>};

}  // namespace

}  // namespace tetrakis::detail
