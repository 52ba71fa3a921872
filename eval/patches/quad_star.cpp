#include "quad_star.hpp"

#include "../surface/local_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis::detail {

namespace {

/// The ring of a corner: edge(i) and face(i), counter-clockwise.
template <class Edge, class Face>
Vec3d ring_limit_position(const Vec3d& centre, int valence, Edge&& edge, Face&& face) {
    Vec3d edges(0), faces(0);
    for (int i = 0; i < valence; ++i) edges += edge(i), faces += face(i);
    const double n = valence;
    return (n * n * centre + 4.0 * edges + faces) / (n * (n + 5));
}

/// One step of it.
template <class Edge, class Face>
void refine_ring(const Vec3d& centre, int valence, Edge&& edge, Face&& face, QuadStar& child) {
    child.resize(valence);
    Vec3d edges(0), faces(0);
    for (int i = 0; i < valence; ++i)
        child.points[static_cast<std::size_t>(2 + 2 * i)] = 0.25 * (centre + edge(i) + face(i) + edge(i + 1));
    for (int i = 0; i < valence; ++i) {
        const Vec3d f = child.face(i), before = child.face(i - 1);
        child.points[static_cast<std::size_t>(1 + 2 * i)] = 0.25 * (centre + edge(i) + f + before);
        edges += edge(i);
        faces += f;
    }
    const double inv = 1.0 / valence;
    child.points[0] = (valence - 2) * inv * centre + (inv * inv) * (edges + faces);
}

}  // namespace

void QuadStar::find_limit() {
    limit = ring_limit_position(
        points[0], valence, [&](int i) { return edge(i); }, [&](int i) { return face(i); });
}

Vec3d QuadStar::corner_limit(int corner) const {
    if (corner == 0) return limit;
    if (corner == 2)
        return ring_limit_position(
            face(0), far_valence, [&](int i) { return far_edge(i); }, [&](int i) { return far_face(i); });
    const bool first = corner == 1;
    const Vec3d edges = points[0] + face(0) + far_face(first ? 1 : -1) + face(first ? -1 : 1);
    const Vec3d faces =
        edge(first ? 1 : 0) + edge(first ? -1 : 2) + far_edge(first ? 2 : -1) + outer(first ? 0 : 2 * far_valence - 2);
    return (16.0 * edge(first ? 0 : 1) + 4.0 * edges + faces) / 36.0;
}

void QuadStar::put(Net16& net) const {
    net.set(0, 0, points[0]);
    net.set(1, 0, edge(0)), net.set(0, 1, edge(1)), net.set(-1, 0, edge(2)), net.set(0, -1, edge(3));
    net.set(1, 1, face(0)), net.set(-1, 1, face(1)), net.set(-1, -1, face(2)), net.set(1, -1, face(3));
    constexpr int k_beyond[7][2] = {{2, -1}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {-1, 2}};
    for (int i = 0; i < 7; ++i) net.set(k_beyond[i][0], k_beyond[i][1], outer(i));
}

void subdivide(const QuadStar& star, QuadStar& near, StarQuarters& quarters) {
    const bool near_special = star.valence != 4, far_special = star.far_valence != 4;
    // The points as a lattice, x and y from -1 to 2. (-1, -1) and (2, 2) mean something at regular corners alone; what
    // is made of them elsewhere is never read.
    Vec3d p[4][4];
    const auto at = [&](int x, int y) -> Vec3d& { return p[y + 1][x + 1]; };
    at(0, 0) = star.points[0];
    at(1, 0) = star.edge(0), at(0, 1) = star.edge(1), at(-1, 0) = star.edge(2), at(0, -1) = star.edge(-1);
    at(1, 1) = star.face(0), at(-1, 1) = star.face(1), at(1, -1) = star.face(-1), at(-1, -1) = star.face(2);
    at(2, 0) = star.far_face(1), at(0, 2) = star.far_face(-1), at(2, 2) = star.far_face(2);
    at(2, 1) = star.far_edge(2), at(1, 2) = star.far_edge(-1);
    at(2, -1) = star.outer(0), at(-1, 2) = star.outer(2 * star.far_valence - 2);

    // New points at half steps: q[j][i] stands at ((i - 1) / 2, (j - 1) / 2), i, j = 0..4.
    Vec3d q[5][5];
    const auto new_at = [&](int i, int j) -> Vec3d& { return q[j][i]; };
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            new_at(2 * x + 2, 2 * y + 2) = 0.25 * (at(x, y) + at(x + 1, y) + at(x + 1, y + 1) + at(x, y + 1));
    for (int y = 0; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)  // the edge (x, y) - (x + 1, y)
            new_at(2 * x + 2, 2 * y + 1) =
                0.25 * (at(x, y) + at(x + 1, y) + new_at(2 * x + 2, 2 * y) + new_at(2 * x + 2, 2 * y + 2));
    for (int y = -1; y <= 1; ++y)
        for (int x = 0; x <= 1; ++x)  // the edge (x, y) - (x, y + 1)
            new_at(2 * x + 1, 2 * y + 2) =
                0.25 * (at(x, y) + at(x, y + 1) + new_at(2 * x, 2 * y + 2) + new_at(2 * x + 2, 2 * y + 2));
    for (int y = 0; y <= 1; ++y)
        for (int x = 0; x <= 1; ++x) {
            const int i = 2 * x + 1, j = 2 * y + 1;
            const Vec3d ring = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1);
            const Vec3d around =
                new_at(i - 1, j - 1) + new_at(i + 1, j - 1) + new_at(i - 1, j + 1) + new_at(i + 1, j + 1);
            new_at(i, j) = 0.5 * at(x, y) + 0.0625 * (ring + around);
        }
    if (near_special) {
        refine_ring(
            star.points[0], star.valence, [&](int i) { return star.edge(i); }, [&](int i) { return star.face(i); },
            near);
        near.limit = star.limit;
        new_at(1, 1) = near.points[0];
        new_at(0, 1) = near.edge(2);
        new_at(1, 0) = near.edge(-1);
    }
    if (far_special) {
        QuadStar& far = quarters.far;
        refine_ring(
            star.face(0), star.far_valence, [&](int i) { return star.far_edge(i); },
            [&](int i) { return star.far_face(i); }, far);
        new_at(3, 3) = far.points[0];
        new_at(4, 3) = far.edge(2);
        new_at(3, 4) = far.edge(-1);
    }
    // The seven beyond a quarter's own ring, from (2, -1) to (-1, 2).
    constexpr int k_beyond[7][2] = {{3, 0}, {3, 1}, {3, 2}, {3, 3}, {2, 3}, {1, 3}, {0, 3}};
    for (int i = 0; i < 7; ++i) {
        const auto [x, y] = k_beyond[i];
        if (near_special) near.points[static_cast<std::size_t>(2 * star.valence + 1 + i)] = new_at(x, y);
        if (far_special)
            quarters.far.points[static_cast<std::size_t>(2 * star.far_valence + 1 + i)] = new_at(4 - x, 4 - y);
    }
    if (far_special) quarters.far.limit = star.corner_limit(2);

    constexpr int k_corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 4; ++k) {
        if ((k == 0 && near_special) || (k == 2 && far_special)) continue;
        for (int y = -1; y <= 2; ++y)
            for (int x = -1; x <= 2; ++x)
                quarters.net[k].set(x, y, new_at(x + k_corner[k][0] + 1, y + k_corner[k][1] + 1));
    }
}

}  // namespace tetrakis::detail
