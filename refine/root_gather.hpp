#pragma once

#include "tetrakis/refine/root_kernels.hpp"
#include "tetrakis/refine/root_layout.hpp"

#include <cstring>

namespace tetrakis::detail {

/// Three scalars of point v.
template <class T>
inline void copy_point(T* to, const T* points, std::uint32_t v) {
    std::memcpy(to, points + 3 * std::uint64_t{v}, 3 * sizeof(T));
}

/// Copies `count` points of a run to every `step`-th (1 or -1) place from `to` on.
template <class T>
inline void copy_run(const T* points, RootLayout::Run run, std::uint32_t count, T* to, std::ptrdiff_t step = 1) {
    std::uint32_t v = run.begin;
    for (std::uint32_t i = 0; i < count; ++i) {
        copy_point(to, points, v);
        v += run.step;
        run.step += run.turn;
        to += 3 * step;
    }
}

template <class T>
inline PointLine<T> line_between(const T* points, std::uint32_t first, RootLayout::Run run, std::uint32_t last) {
    const auto at = [&](std::uint32_t v) { return points + 3 * std::uint64_t{v}; };
    const auto scalars = [](std::uint32_t vertices) { return std::ptrdiff_t{3} * static_cast<std::int32_t>(vertices); };
    return {at(first), at(run.begin), at(last), scalars(run.step), scalars(run.turn)};
}

/// The line of N + 1 points along side h, from its start (or its end), where it is.
template <class T>
inline PointLine<T> side_line(const RootLayout& at, std::uint32_t h, bool reversed, const T* points) {
    const MeshLevel& base = at.base();
    const std::uint32_t n = at.segments(), from = base.origin[h], to = base.origin[base.next(h)];
    RootLayout::Run run{from, 0, 0};
    if (n > 1) run = reversed ? at.inner_along(h).reversed(n - 1) : at.inner_along(h);
    return line_between(points, reversed ? to : from, run, reversed ? from : to);
}

/// The sides of a root where they are.
template <class T>
inline RootLines<T> root_lines(const RootLayout& at, std::uint32_t f, const T* points) {
    const T* inner = points + 3 * std::uint64_t{at.root_begin(f)};
    const auto side = [&](std::uint32_t h, bool reversed) { return side_line(at, h, reversed, points); };
    if (at.quads())
        return {inner,        side(4 * f, false), side(4 * f + 2, true), side(4 * f + 3, true), side(4 * f + 1, false),
                at.segments()};
    return {inner, side(3 * f, false), {}, side(3 * f + 2, true), side(3 * f + 1, false), at.segments()};
}

/// The lattice line one step off side h in h's root, where it is: N + 1 points (triangles: N) in h's direction, or
/// against it.
template <class T>
inline PointLine<T> beside_line(const RootLayout& at, std::uint32_t h, bool reversed, const T* points) {
    const MeshLevel& base = at.base();
    const std::uint32_t last = at.quads() ? at.segments() : at.segments() - 1;
    const std::uint32_t from = at.last_along(base.prev(h)), to = last == 0 ? from : at.first_along(base.next(h));
    RootLayout::Run run{from, 0, 0};
    if (last > 1) run = reversed ? at.inner_beside(h).reversed(last - 1) : at.inner_beside(h);
    return line_between(points, reversed ? to : from, run, reversed ? from : to);
}

/// The line of N + 1 points along side h, from its start (or its end).
template <class T>
inline void gather_side(const RootLayout& at, std::uint32_t h, bool reversed, const T* points, T* line) {
    const MeshLevel& base = at.base();
    const std::uint32_t n = at.segments(), from = base.origin[h], to = base.origin[base.next(h)];
    T* end = line + 3 * std::uint64_t{n};
    copy_point(line, points, reversed ? to : from);
    copy_point(end, points, reversed ? from : to);
    if (n > 1) copy_run(points, at.inner_along(h), n - 1, reversed ? end - 3 : line + 3, reversed ? -1 : 1);
}

/// The sides of a root, in the directions of RootRows; `lines` has room for 4 (N + 1) points and a scalar.
template <class T>
inline RootRows<T> gather_sides(const RootLayout& at, std::uint32_t f, const T* points, T* lines) {
    const std::uint64_t length = 3 * (std::uint64_t{at.segments()} + 1);
    T *bottom = lines, *right = lines + length, *left = right + length, *top = left + length;
    if (at.quads()) {
        gather_side(at, 4 * f, false, points, bottom);
        gather_side(at, 4 * f + 1, false, points, right);
        gather_side(at, 4 * f + 2, true, points, top);
        gather_side(at, 4 * f + 3, true, points, left);
    } else {
        gather_side(at, 3 * f, false, points, bottom);
        gather_side(at, 3 * f + 1, false, points, right);
        gather_side(at, 3 * f + 2, true, points, left);
    }
    return {points + 3 * std::uint64_t{at.root_begin(f)}, bottom, top, left, right, at.segments()};
}

/// The lattice lines on both sides of the edge of half-edge h, which has two: left in h's root, right in its twin's,
/// each in h's direction, N + 1 points (triangles: N).
template <class T>
inline void gather_beside(const RootLayout& at, std::uint32_t h, const T* points, T* left, T* right) {
    const MeshLevel& base = at.base();
    const std::uint32_t t = base.twin[h], last = at.quads() ? at.segments() : at.segments() - 1;
    const auto line = [&](std::uint32_t side, T* begin, std::ptrdiff_t step) {
        copy_point(begin, points, at.last_along(base.prev(side)));
        if (last > 1) copy_run(points, at.inner_beside(side), last - 1, begin + 3 * step, step);
        if (last > 0)
            copy_point(begin + 3 * step * static_cast<std::ptrdiff_t>(last), points, at.first_along(base.next(side)));
    };
    line(h, left, 1);
    line(t, right + 3 * std::uint64_t{last}, -1);
}

}  // namespace tetrakis::detail
