#include "quad_star.hpp"

#include "local_frame.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

void QuadStar::find_limit() {
    Vec3d edges(0), faces(0);
    for (int i = 0; i < valence; ++i) edges += edge(i), faces += face(i);
    const double n = valence;
    limit = (n * n * points[0] + 4.0 * edges + faces) / (n * (n + 5));
    find_reach();
}

void QuadStar::find_reach() {
    double most = 0;
    for (const Vec3d& p : points) most = std::max(most, glm::dot(p - limit, p - limit));
    reach = round_up(std::sqrt(most));
}

void subdivide(const QuadStar& star, QuadStar& child, std::array<Net16, 3>& regular) {
    const int n = star.valence;
    // The regular part as a lattice, x and y from -1 to 2; (-1, -1) does not exist and is never read.
    Vec3d p[4][4];
    const auto at = [&](int x, int y) -> Vec3d& { return p[y + 1][x + 1]; };
    at(-1, -1) = Vec3d(0);
    at(0, 0) = star.points[0];
    at(1, 0) = star.edge(0), at(0, 1) = star.edge(1), at(-1, 0) = star.edge(2), at(0, -1) = star.edge(-1);
    at(1, 1) = star.face(0), at(-1, 1) = star.face(1), at(1, -1) = star.face(-1);
    at(2, -1) = star.outer(0), at(2, 0) = star.outer(1), at(2, 1) = star.outer(2), at(2, 2) = star.outer(3);
    at(1, 2) = star.outer(4), at(0, 2) = star.outer(5), at(-1, 2) = star.outer(6);

    // New points at half steps: q[j][i] stands at ((i - 1) / 2, (j - 1) / 2), i, j = 0..4.
    Vec3d q[5][5];
    const auto face_point = [&](int x, int y) {
        return 0.25 * (at(x, y) + at(x + 1, y) + at(x + 1, y + 1) + at(x, y + 1));
    };
    const auto new_at = [&](int i, int j) -> Vec3d& { return q[j][i]; };
    new_at(0, 0) = Vec3d(0);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            if (x != -1 || y != -1) new_at(2 * x + 2, 2 * y + 2) = face_point(x, y);
    // Edge points off the corner's own special edges.
    for (int y = 0; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)  // the edge (x, y) - (x + 1, y)
            if (x != -1 || y != 0)
                new_at(2 * x + 2, 2 * y + 1) =
                    0.25 * (at(x, y) + at(x + 1, y) + new_at(2 * x + 2, 2 * y) + new_at(2 * x + 2, 2 * y + 2));
    for (int y = -1; y <= 1; ++y)
        for (int x = 0; x <= 1; ++x)  // the edge (x, y) - (x, y + 1)
            if (x != 0 || y != -1)
                new_at(2 * x + 1, 2 * y + 2) =
                    0.25 * (at(x, y) + at(x, y + 1) + new_at(2 * x, 2 * y + 2) + new_at(2 * x + 2, 2 * y + 2));

    // The corner's own ring: face points, edge points, the vertex point.
    child.valence = n;
    child.limit = star.limit;
    child.points.resize(QuadStar::point_count(n));
    const Vec3d centre = star.points[0];
    Vec3d edges(0), faces(0);
    for (int i = 0; i < n; ++i)
        child.points[static_cast<std::size_t>(2 + 2 * i)] =
            0.25 * (centre + star.edge(i) + star.face(i) + star.edge(i + 1));
    for (int i = 0; i < n; ++i) {
        const Vec3d f = child.face(i), before = child.face(i - 1);
        child.points[static_cast<std::size_t>(1 + 2 * i)] = 0.25 * (centre + star.edge(i) + f + before);
        edges += star.edge(i);
        faces += f;
    }
    const double inv = 1.0 / n;
    child.points[0] = (n - 2) * inv * centre + (inv * inv) * (edges + faces);
    new_at(1, 1) = child.points[0];
    new_at(0, 1) = child.edge(2);
    new_at(1, 0) = child.edge(-1);

    // The regular vertices at (1, 0), (0, 1), (1, 1).
    const auto vertex_point = [&](int x, int y) {
        const int i = 2 * x + 1, j = 2 * y + 1;
        const Vec3d ring = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1);
        const Vec3d around = new_at(i - 1, j - 1) + new_at(i + 1, j - 1) + new_at(i - 1, j + 1) + new_at(i + 1, j + 1);
        return 0.5 * at(x, y) + 0.0625 * (ring + around);
    };
    new_at(3, 1) = vertex_point(1, 0);
    new_at(1, 3) = vertex_point(0, 1);
    new_at(3, 3) = vertex_point(1, 1);

    Vec3d* outer = child.points.data() + 2 * n + 1;
    outer[0] = new_at(3, 0), outer[1] = new_at(3, 1), outer[2] = new_at(3, 2), outer[3] = new_at(3, 3);
    outer[4] = new_at(2, 3), outer[5] = new_at(1, 3), outer[6] = new_at(0, 3);
    child.find_reach();

    constexpr int corner[3][2] = {{1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 3; ++k)
        for (int y = -1; y <= 2; ++y)
            for (int x = -1; x <= 2; ++x) regular[k].set(x, y, new_at(x + corner[k][0] + 1, y + corner[k][1] + 1));
}

}  // namespace tetrakis::detail
