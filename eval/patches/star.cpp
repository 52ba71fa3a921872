#include "star.hpp"

#include "../../schemes/rules/loop.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis::detail {

std::size_t QuadStar::ring_place(int corner, int i) const {
    if (i < 3) return static_cast<std::size_t>((corner + 1 + i) & 3);
    // Two neighbours of each corner are the next one's, too.
    constexpr int k_regular = 3;
    const int around[4] = {0, 2 * valence - 5, 2 * valence - 5 + k_regular,
                           2 * (valence + far_valence) - 10 + k_regular};
    const auto outer = static_cast<std::size_t>(around[corner] + i - 3), count = points.size() - 4;
    return 4 + (outer < count ? outer : outer - count);
}

Vec3d QuadStar::corner_limit(int corner) const {
    Vec3d edges(0), faces(0);
    for (int i = 0; i < valence_of(corner); ++i) edges += ring(corner, 2 * i), faces += ring(corner, 2 * i + 1);
    const double n = valence_of(corner);
    return (n * n * points[static_cast<std::size_t>(corner)] + 4.0 * edges + faces) / (n * (n + 5));
}

CornerRing QuadStar::corner_ring(int corner) const {
    CornerRing out;
    out.scheme = SchemeKind::catmull_clark;
    out.centre = points[static_cast<std::size_t>(corner)];
    for (int i = 0; i < valence_of(corner); ++i) out.spokes.push_back({ring(corner, 2 * i), ring(corner, 2 * i + 1)});
    return out;
}

Net16 QuadStar::net(int corner) const {
    constexpr int k_place[16][2] = {{0, 0},  {1, 0},  {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1},
                                    {1, -1}, {2, -1}, {2, 0}, {2, 1}, {2, 2},  {1, 2},  {0, 2},   {-1, 2}};
    Net16 net;
    for (std::size_t i = 0; i < 16; ++i) {
        const auto [x, y] = from_corner(corner, k_place[i][0], k_place[i][1]);
        net.set(x, y, points[i]);
    }
    return net;
}

void subdivide(const QuadStar& star, std::array<QuadStar, 4>& quarters) {
    // A quarter's point i + 1 belongs to neighbour i of its corner of the star: an edge's point or a face's.
    for (int k = 0; k < 4; ++k) {
        QuadStar& quarter = quarters[static_cast<std::size_t>(k)];
        const int n = star.valence_of(k);
        const Vec3d& corner = star.points[static_cast<std::size_t>(k)];
        quarter.resize(n);
        const auto edge = [&](int i) -> const Vec3d& { return star.ring(k, i < n ? 2 * i : 0); };
        Vec3d* const new_edge = quarter.points.data() + 1;  // every other one
        Vec3d* const new_face = new_edge + 1;
        Vec3d edges(0), faces(0);
        for (int i = 0; i < n; ++i) {
            new_face[2 * i] = 0.25 * (corner + edge(i) + star.ring(k, 2 * i + 1) + edge(i + 1));
            edges += edge(i);
            faces += new_face[2 * i];
        }
        for (int i = 0; i < n; ++i)
            new_edge[2 * i] = 0.25 * (corner + edge(i) + new_face[2 * i] + new_face[2 * (i > 0 ? i - 1 : n - 1)]);
        const double inv = 1.0 / n;
        quarter.points[0] = (n - 2) * inv * corner + (inv * inv) * (edges + faces);
    }
    for (int k = 0; k < 4; ++k) {
        const auto point = [&](int corner, int i) -> const Vec3d& {
            return quarters[static_cast<std::size_t>((k + corner) & 3)].points[static_cast<std::size_t>(i)];
        };
        Vec3d* out = quarters[static_cast<std::size_t>(k)].points.data() + 2 * star.valence_of(k) + 1;
        // (2, -1), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (-1, 2)
        *out++ = point(1, 5), *out++ = point(1, 0), *out++ = point(1, 1), *out++ = point(2, 0), *out++ = point(2, 1);
        *out++ = point(3, 0), *out++ = point(3, 2 * star.valence_of((k + 3) & 3) - 1);
    }
}

Net12 LoopStar::net(int corner) const {
    Net12 net;
    for (int k = 0; k < 3; ++k) net[static_cast<std::size_t>((k + corner) % 3)] = points[static_cast<std::size_t>(k)];
    for (int i = 0; i < 9; ++i)
        net[static_cast<std::size_t>(3 + (i + 3 * corner) % 9)] = points[static_cast<std::size_t>(3 + i)];
    return net;
}

CornerRing LoopStar::corner_ring(int corner) const {
    const auto k = static_cast<std::size_t>(corner);
    CornerRing out;
    out.centre = points[k];
    for (int i = 0; i < valence[k]; ++i) out.spokes.push_back({ring(corner, i)});
    return out;
}

Vec3d LoopStar::corner_limit(int corner) const {
    const auto k = static_cast<std::size_t>(corner);
    static const RingMask regular = Loop::limit_mask(6);  // most are: no cosine
    const RingMask mask = valence[k] == 6 ? regular : Loop::limit_mask(valence[k]);
    Vec3d sum(0);
    for (int i = 0; i < valence[k]; ++i) sum += ring(corner, i);
    return mask.vertex * points[k] + mask.edge * sum;
}

void subdivide(const LoopStar& star, std::array<LoopStar, 4>& quarters) {
    static const double regular = Loop::beta(6);
    // A quarter's corners, then the edge points around its corner of the star: points from 1 on are those of the edges
    // to neighbours 0, 1, 2 and so on.
    for (int k = 0; k < 3; ++k) {
        LoopStar& quarter = quarters[static_cast<std::size_t>(k)];
        const int n = star.valence[static_cast<std::size_t>(k)];
        const Vec3d& corner = star.points[static_cast<std::size_t>(k)];
        quarter.resize({n, 6, 6});
        Vec3d sum(0);
        const Vec3d* before = &star.ring(k, n - 1);
        for (int i = 0; i < n; ++i) {
            const Vec3d &here = star.ring(k, i), &after = star.ring(k, i + 1 == n ? 0 : i + 1);
            sum += here;
            quarter.points[static_cast<std::size_t>(1 + i)] =
                Loop::edge_end * (corner + here) + Loop::edge_opposite * (*before + after);
            before = &here;
        }
        const double beta = n == 6 ? regular : Loop::beta(n);
        quarter.points[0] = (1 - n * beta) * corner + beta * sum;
    }
    const auto point = [&](int k, int i) -> const Vec3d& {
        const auto c = static_cast<std::size_t>(k % 3);
        return quarters[c].points[static_cast<std::size_t>(i < 0 ? star.valence[c] : i)];
    };
    // Vertex k, the middle of the side after it, and the edge points across the sides after and before it.
    const auto vertex = [&](int k) -> const Vec3d& { return point(k, 0); };
    const auto middle = [&](int k) -> const Vec3d& { return point(k, 1); };
    const auto across_after = [&](int k) -> const Vec3d& { return point(k, -1); };
    const auto across_before = [&](int k) -> const Vec3d& { return point(k, 3); };
    for (int k = 0; k < 3; ++k) {
        Vec3d* out = &quarters[static_cast<std::size_t>(k)]
                          .points[static_cast<std::size_t>(star.valence[static_cast<std::size_t>(k)] + 1)];
        *out++ = across_before(k + 1), *out++ = vertex(k + 1), *out++ = middle(k + 1), *out++ = vertex(k + 2);
        *out++ = across_after(k + 2);
    }
    quarters[3].resize({6, 6, 6});
    for (int k = 0; k < 3; ++k) {
        quarters[3].points[static_cast<std::size_t>(k)] = middle(k + 1);
        Vec3d* out = &quarters[3].points[static_cast<std::size_t>(3 + 3 * k)];
        *out++ = vertex(k + 1), *out++ = across_after(k + 1), *out++ = across_before(k + 2);
    }
}

}  // namespace tetrakis::detail
