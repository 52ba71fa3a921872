#pragma once

#include "root_kernels.hpp"
#include "root_layout.hpp"

#include <cstring>

namespace tetrakis::detail {

/// Three scalars of point v.
template <class T>
inline void copy_point(T* to, const T* points, std::uint32_t v) {
    std::memcpy(to, points + 3 * std::uint64_t{v}, 3 * sizeof(T));
}

/// A line of points where they are.
template <class T>
[[gnu::always_inline]] inline PointLine<T> points_of(const VertexLine& line, const T* points) {
    const auto at = [&](std::uint32_t v) { return points + 3 * std::uint64_t{v}; };
    const auto scalars = [](std::uint32_t vertices) { return std::ptrdiff_t{3} * static_cast<std::int32_t>(vertices); };
    return {at(line.first), at(line.inner.begin), at(line.last), scalars(line.inner.step), scalars(line.inner.turn)};
}
template <class T>
[[gnu::always_inline]] inline RootLines<T> points_of(const VertexRoot& root, const T* points) {
    return {points + 3 * std::uint64_t{root.inner}, points_of(root.bottom, points), points_of(root.top, points),
            points_of(root.left, points),           points_of(root.right, points),  root.segments};
}

/// Copies a line of `count` >= 1 points.
template <class T>
inline void gather(VertexLine line, std::uint32_t count, const T* points, T* to) {
    copy_point(to, points, line.first);
    for (std::uint32_t i = 1; i + 1 < count; ++i) {
        copy_point(to + 3 * std::uint64_t{i}, points, line.inner.begin);
        line.inner.begin += line.inner.step;
        line.inner.step += line.inner.turn;
    }
    if (count > 1) copy_point(to + 3 * std::uint64_t{count - 1}, points, line.last);
}

/// Copies of a root's sides; `lines` has room for 4 (N + 1) points and a scalar.
template <class T>
inline RootRows<T> gather(const VertexRoot& root, const T* points, T* lines) {
    const std::uint32_t count = root.segments + 1;
    const std::uint64_t length = 3 * std::uint64_t{count};
    T *bottom = lines, *right = lines + length, *left = right + length, *top = left + length;
    gather(root.bottom, count, points, bottom);
    gather(root.right, count, points, right);
    gather(root.left, count, points, left);
    gather(root.top, count, points, top);
    return {points + 3 * std::uint64_t{root.inner}, bottom, top, left, right, root.segments};
}

/// Points of the lattice line one step off side h in its face, in its direction or against it: N + 1; triangles: N.
template <class T, class Layout>
inline void gather_beside(const Layout& at, std::uint32_t h, bool reversed, const T* points, T* to) {
    const std::uint32_t count = at.segments() + (at.quads() ? 1 : 0);
    if (at.is_root(at.face_of(h))) {
        const VertexLine line = at.beside(h);
        return gather(reversed ? line.reversed(count) : line, count, points, to);
    }
    at.for_each_beside(h, [&](std::uint32_t j, std::uint32_t v) {
        copy_point(to + 3 * std::uint64_t{reversed ? count - 1 - j : j}, points, v);
    });
}

}  // namespace tetrakis::detail
