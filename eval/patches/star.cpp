#include "star.hpp"

#include "../../schemes/rules/loop.hpp"

#include <array>

namespace tetrakis::detail {

namespace {
/// Loop::beta() without its cosine.
double known_beta(int valence) {
    static const auto table = [] {
        std::array<double, 33> betas{};
        for (int n = 3; n < 33; ++n) betas[static_cast<std::size_t>(n)] = Loop::beta(n);
        return betas;
    }();
    return valence < 33 ? table[static_cast<std::size_t>(valence)] : Loop::beta(valence);
}
}  // namespace

Vec3d corner_limit(const QuadStar& star, int corner) {
    Vec3d edges(0), faces(0);
    const int n = star.valence_of(corner);
    for (int i = 0; i < n; ++i) edges += star.ring(corner, 2 * i), faces += star.ring(corner, 2 * i + 1);
    return (double(n) * n * star.points[static_cast<std::size_t>(corner)] + 4.0 * edges + faces) /
           (double(n) * (n + 5));
}

Net16 net_of(const QuadStar& star, int corner) {
    constexpr int k_place[16][2] = {{0, 0},  {1, 0},  {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1},
                                    {1, -1}, {2, -1}, {2, 0}, {2, 1}, {2, 2},  {1, 2},  {0, 2},   {-1, 2}};
    Net16 net;
    for (std::size_t i = 0; i < 16; ++i) {
        const auto [x, y] = from_corner(corner, k_place[i][0], k_place[i][1]);
        net.set(x, y, star.points[i]);
    }
    return net;
}

void subdivide(const QuadStar& star, std::array<QuadStar, 4>& quarters) {
    // Point i + 1 of a quarter belongs to ring point i of its corner of the star: an edge point or a face point.
    for (int k = 0; k < 4; ++k) {
        QuadStar& quarter = quarters[static_cast<std::size_t>(k)];
        const int n = star.valence_of(k);
        const Vec3d& corner = star.points[static_cast<std::size_t>(k)];
        quarter.resize(QuadStar::with_first(n));
        const auto edge = [&](int i) -> const Vec3d& { return star.ring(k, i < n ? 2 * i : 0); };
        Vec3d* const new_edge = quarter.points.data() + 1;  // edge points, at every second place
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

Net12 net_of(const LoopStar& star, int corner) {
    Net12 net;
    const auto turn = static_cast<std::size_t>(corner);
    for (std::size_t k = 0; k < 3; ++k) net[(k + turn) % 3] = star.points[k];
    for (std::size_t i = 0; i < 9; ++i) net[3 + (i + 3 * turn) % 9] = star.points[3 + i];
    return net;
}

Vec3d corner_limit(const LoopStar& star, int corner) {
    const int n = star.valence_of(corner);
    const RingMask mask = Loop::limit_mask(n, known_beta(n));
    Vec3d sum(0);
    for (int i = 0; i < n; ++i) sum += star.ring(corner, i);
    return mask.vertex * star.points[static_cast<std::size_t>(corner)] + mask.edge * sum;
}

void subdivide(const LoopStar& star, std::array<LoopStar, 4>& quarters) {
    // A quarter has its corners first, then the edge points around its corner of the star: point 1 + i belongs to the
    // edge to neighbour i.
    for (int k = 0; k < 3; ++k) {
        LoopStar& quarter = quarters[static_cast<std::size_t>(k)];
        const int n = star.valence_of(k);
        const Vec3d& corner = star.points[static_cast<std::size_t>(k)];
        quarter.resize(LoopStar::with_first(n));
        Vec3d sum(0);
        const Vec3d* before = &star.ring(k, n - 1);
        for (int i = 0; i < n; ++i) {
            const Vec3d &here = star.ring(k, i), &after = star.ring(k, i + 1 == n ? 0 : i + 1);
            sum += here;
            quarter.points[static_cast<std::size_t>(1 + i)] =
                Loop::edge_end * (corner + here) + Loop::edge_opposite * (*before + after);
            before = &here;
        }
        const double beta = known_beta(n);
        quarter.points[0] = (1 - n * beta) * corner + beta * sum;
    }
    const auto point = [&](int k, int i) -> const Vec3d& {
        const auto c = static_cast<std::size_t>(k % 3);
        return quarters[c].points[static_cast<std::size_t>(i < 0 ? star.valence[c] : i)];
    };
    // Vertex k, the midpoint of the side after it, and the edge points across the sides after and before it.
    const auto vertex = [&](int k) -> const Vec3d& { return point(k, 0); };
    const auto middle = [&](int k) -> const Vec3d& { return point(k, 1); };
    const auto across_after = [&](int k) -> const Vec3d& { return point(k, -1); };
    const auto across_before = [&](int k) -> const Vec3d& { return point(k, 3); };
    for (int k = 0; k < 3; ++k) {
        Vec3d* out = &quarters[static_cast<std::size_t>(k)].points[static_cast<std::size_t>(star.valence_of(k) + 1)];
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
