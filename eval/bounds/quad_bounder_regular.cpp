#include "quad_bounder.hpp"
#include "quad_lattice.hpp"
#include "quad_remainder.hpp"
#include "triangle_coefficients.hpp"

#include <algorithm>
#include <cmath>

// Pieces of regular cells without a crease, or with one that counts as sharp.

namespace tetrakis {

using detail::k_centre_point;
using detail::k_line_remainder;
using detail::k_rounding;
using detail::k_side_point;
using detail::remainder_of;
using detail::WalkCell;

namespace {

/// Finest sample lattice of a smooth piece: what its quadratics leave of the cubic part is then a 64th.
constexpr int k_finest_lattice = 8;
}  // namespace

double QuadBounder::quadratic_error(const std::array<Vec3d, 3>& corner, const std::array<Vec3d, 3>& middle,
                                    const std::array<std::int8_t, 3>& edge, const Remainder& rest) const {
    double most = 0;  // squared
    if (!distance_) {
        const auto look = [&](const Vec3d& c) { most = std::max(most, glm::dot(c, c)); };
        detail::for_each_coefficient(
            corner, middle, [](std::size_t, const Vec3d&) {}, look);
        return std::sqrt(most) + rest.whole;
    }
    std::array<double, 3> on_edge{};  // squared
    if (triangle_.has_slack()) {
        double error = 0;
        detail::for_each_coefficient(
            corner, middle,
            [&](std::size_t k, const Vec3d& c) {
                if (edge[k] >= 0)
                    error = std::max(
                        error, triangle_.around_edge(c, static_cast<std::size_t>(edge[k]), rest.height, rest.edge[k]));
            },
            [&](const Vec3d& c) { error = std::max(error, triangle_.around(c, rest.height, rest.whole)); });
        return error;
    }
    const auto look = [&](const Vec3d& c) {
        const auto at = triangle_.split(c);
        const double height = at.height + rest.height, beside = at.squared_beside == 0
                                                                    ? std::max(0.0, rest.whole - triangle_.margin(c))
                                                                    : std::sqrt(at.squared_beside) + rest.whole;
        most = std::max(most, height * height + beside * beside);
    };
    detail::for_each_coefficient(
        corner, middle,
        [&](std::size_t k, const Vec3d& c) {
            if (edge[k] >= 0)
                on_edge[k] = std::max(on_edge[k], triangle_.squared_to_edge(c, static_cast<std::size_t>(edge[k])));
        },
        look);
    double error = std::sqrt(most);
    for (std::size_t k = 0; k < 3; ++k)
        if (edge[k] >= 0) error = std::max(error, std::sqrt(on_edge[k]) + rest.edge[k]);
    return error;
}

/// Bounds on a piece that is the whole leaf, from the deviations in the middles of its edges; unknown where they are
/// not small beside the triangle. The quadratic is 4 sum e_k b_i b_j; beyond edge k it can reach only by its own e_k
/// there, since the others come with the barycentric of the opposite corner, which the triangle's height times it
/// outweighs. With |e_k| at most an eighth of the least height no point is beyond two edges at once, and the foot of
/// one that is beyond an edge lies within it: both would take 4 b_i |e| > b_j height / 2 for i, j either way.
QuadBounder::FlatError QuadBounder::flat_error(const std::array<Vec3d, 3>& middle, const Remainder& rest) const {
    FlatError flat;
    double size = 0, sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d e = triangle_.local_vector(middle[k]);
        const double out = triangle_.outward(e, k);
        if (std::abs(triangle_.along(e, k)) > 0.25) return {};
        size = std::max(size, glm::dot(middle[k], middle[k]));
        flat.reach = std::max(flat.reach, std::max(out, 0.0) + rest.edge[k]);
        flat.beside = std::max(flat.beside, out);
        flat.height = std::max(flat.height, std::abs(e.z));
        sum += e.z;
        const double error = std::sqrt(e.z * e.z + out * out);
        flat.attained = std::max(flat.attained, error);
        flat.on_edges = std::max(flat.on_edges, error + rest.edge[k]);
    }
    if (8 * std::sqrt(size) > triangle_.least_height()) return {};
    flat.height = std::max(flat.height, 0.5 * std::abs(sum)) + rest.height;
    flat.beside += rest.whole;
    flat.known = true;
    return flat;
}

QuadBounder::Remainder QuadBounder::remainder(const WalkCell::Patch& patch, const Piece& piece) const {
    const detail::ThirdBounds& third = patch.facts->third;
    Remainder rest;
    rest.whole = remainder_of(third, piece.turn, piece.quarter);
    rest.height = rest.whole;
    if (distance_ && !triangle_.sliver())
        rest.height =
            remainder_of(detail::ThirdBounds::along(*patch.net, triangle_.normal()), piece.turn, piece.quarter);
    const bool flat = (piece.turn & 1) == 0;
    const double diagonal = third.xxx + 3 * (third.xxy + third.xyy) + third.yyy;
    if (piece.quarter)
        rest.edge = {diagonal / 8, flat ? third.xxx : third.yyy, diagonal / 8};
    else
        rest.edge = {flat ? third.xxx : third.yyy, diagonal, flat ? third.yyy : third.xxx};
    for (double& e : rest.edge) e *= k_line_remainder;
    return rest;
}

bool QuadBounder::bound_regular(const WalkCell::Patch& patch, const Piece& piece, const Corners& corners,
                                bool may_split) {
    const double pad = k_rounding * scale_ + patch.beyond;
    const Vec3d* point = patch.facts->point.data();
    const int k = piece.turn;
    const auto& L = corners.linear;
    const auto& D = corners.deviation;
    std::array<Vec3d, 3> s;
    if (piece.quarter) {
        const detail::LatticeShape shape(piece.turn, piece.quarter, 2);
        const auto at = [&](int i, int j) {
            return combine(*patch.net, detail::part_weights(shape.x(i, j)), detail::part_weights(shape.y(i, j)));
        };
        s = {at(1, 0), point[k_side_point[k]], at(0, 1)};
    } else {
        s = {point[k_side_point[k]], point[k_centre_point], point[k_side_point[(k + 3) & 3]]};
    }
    // S - L first: it is cheaper, and never smaller. The quadratic's part that vanishes at the corners has the Bezier
    // coefficients 2 e_k, and after one subdivision none is larger than an e_k or half their sum.
    std::array<Vec3d, 3> d;
    Vec3d sum(0);
    double at_corners = 0, bulge = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        d[i] = s[i] - 0.5 * (L[i] + L[(i + 1) % 3]);
        const Vec3d e = d[i] - 0.5 * (D[i] + D[(i + 1) % 3]);
        sum += e;
        bulge = std::max(bulge, glm::dot(e, e));
        at_corners = std::max(at_corners, glm::dot(D[i], D[i]));
    }
    bulge = std::sqrt(std::max(bulge, 0.25 * glm::dot(sum, sum)));
    if (at_corners > 0) at_corners = std::sqrt(at_corners);
    const double whole = remainder_of(patch.facts->third, piece.turn, piece.quarter);
    if (at_corners + bulge + whole + pad <= decide_at_) {
        upper_ = std::max(upper_, at_corners + bulge + whole + pad);
        return true;
    }
    need_triangle();
    const bool whole_leaf = piece.edge == std::array<std::int8_t, 3>{0, 1, 2};
    if (distance_ && whole_leaf && !triangle_.sliver() && !triangle_.has_slack()) {
        const Remainder rest = remainder(patch, piece);
        const FlatError flat = flat_error(d, rest);
        if (flat.known) {
            const auto upper = [&](double beside) {
                return std::max(flat.on_edges, std::sqrt(flat.height * flat.height + beside * beside)) + pad;
            };
            if (!attain(flat.attained - patch.beyond) || settled(upper(flat.beside))) return true;
            if (patch.beyond == 0 && one_to_one(*patch.net, piece) &&
                (settled(upper(flat.reach)) || bound_flat(*patch.net, piece, rest)))
                return true;
        }
    }
    std::array<Vec3d, 3> corner, middle;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = measured_form(L[i] + D[i], D[i]);
    if (distance_ && !whole_leaf) {
        // The chords of a part of the leaf are no further off than its corners.
        double error = 0;
        for (std::size_t i = 0; i < 3; ++i)
            error =
                std::max({error, node_error(corner[i], piece.edge[i]), node_error(corner[i], piece.edge[(i + 2) % 3])});
        if (settled(error + bulge + whole + pad)) return true;
    }
    const Remainder rest = remainder(patch, piece);
    for (std::size_t i = 0; i < 3; ++i) {
        middle[i] = measured_form(s[i], d[i]);
        if (!attain(node_error(middle[i], piece.edge[i]) - patch.beyond)) return true;
    }
    const double upper = quadratic_error(corner, middle, piece.edge, rest) + pad;
    if (settled(upper)) return true;
    if (exhausted()) {
        upper_ = std::max(upper_, upper);
        return true;
    }
    if (patch.beyond > 0) return false;  // its strips tell more than finer lattices
    return bound_on_lattice(patch, piece, corners, rest, may_split);
}

/// Whether the foot of the surface on the leaf's plane is a one-to-one map of a piece that is the whole leaf: what it
/// reaches beside the triangle is then enclosed by what its sides reach, since the points within a distance of the
/// triangle are convex. In barycentrics the map is b + e(b), one to one if the first derivatives of e are less than one
/// in the row-sum norm; they are combinations of the net's differences.
bool QuadBounder::one_to_one(const detail::Net16& net, const Piece& piece) const {
    // The linear map's derivatives along the cell's x and y, in barycentrics of corners 1 and 2.
    const int k = piece.turn;
    const auto corner_at = [](int i) { return Vec2d(detail::k_corner_x[i], detail::k_corner_y[i]); };
    const Vec2d origin = piece.quarter ? Vec2d(0.5) : corner_at(k);
    const Vec2d d1 = corner_at(piece.quarter ? k : (k + 1) & 3) - origin;
    const Vec2d d2 = corner_at(piece.quarter ? (k + 1) & 3 : (k + 3) & 3) - origin;
    const double det = d1.x * d2.y - d1.y * d2.x;
    const Vec2d along_x = Vec2d(d2.y, -d1.y) / det, along_y = Vec2d(-d2.x, d1.x) / det;
    const Vec3d to_b1 = triangle_.to_b1(), to_b2 = triangle_.to_b2();
    double b1[16], b2[16];  // Bezier points
    for (int i = 0; i < 16; ++i) {
        b1[i] = to_b1.x * net.c[0][i] + to_b1.y * net.c[1][i] + to_b1.z * net.c[2][i];
        b2[i] = to_b2.x * net.c[0][i] + to_b2.y * net.c[1][i] + to_b2.z * net.c[2][i];
    }
    for (double* b : {b1, b2})
        for (const int stride : {1, 4})
            for (int line = 0; line < 4; ++line) {
                double* p = b + line * (5 - stride);
                const double q0 = p[0], q1 = p[stride], q2 = p[2 * stride], q3 = p[3 * stride];
                const double inner1 = (2 * q1 + q2) / 3, inner2 = (q1 + 2 * q2) / 3;
                p[0] = 0.5 * ((q0 + 2 * q1) / 3 + inner1);
                p[stride] = inner1;
                p[2 * stride] = inner2;
                p[3 * stride] = 0.5 * (inner2 + (2 * q2 + q3) / 3);
            }
    Vec2d x(0), y(0);  // largest deviations from those, by component
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 3; ++c) {
            const int i = 4 * r + c, j = 4 * c + r;
            x = glm::max(x, glm::abs(3.0 * Vec2d(b1[i + 1] - b1[i], b2[i + 1] - b2[i]) - along_x));
            y = glm::max(y, glm::abs(3.0 * Vec2d(b1[j + 4] - b1[j], b2[j + 4] - b2[j]) - along_y));
        }
    const Vec2d sums = (std::abs(d1.x) + std::abs(d2.x)) * x + (std::abs(d1.y) + std::abs(d2.y)) * y;
    constexpr double k_most = 0.99;
    return std::max(sums.x, sums.y) < k_most;
}

/// A whole leaf that flat_error() knows and that is one_to_one(), by quadratics over its quarters: its height, and its
/// edges in their own planes.
bool QuadBounder::bound_flat(const detail::Net16& net, const Piece& piece, const Remainder& rest) {
    constexpr int n = 4;
    constexpr double k_part = 1.0 / 8;  // remainders are cubic
    const detail::LatticeShape shape(piece.turn, piece.quarter, n);
    const detail::LatticeColumns columns(net, shape);
    double height[n + 1][n + 1], highest = 0, on_edges = 0, reach = 0;  // the latter squared
    std::array<std::array<Vec3d, n + 1>, 3> edge;
    const auto look_on_edge = [&](std::size_t k, const Vec3d& p) {
        reach = std::max(reach, triangle_.split(p).squared_beside);
        on_edges = std::max(on_edges, triangle_.to_edge(p, k));
    };
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i + j <= n; ++i) {
            const Vec3d p = triangle_.local(columns.at(shape.x(i, j), shape.y(i, j)));
            height[j][i] = p.z;
            highest = std::max(highest, std::abs(p.z));
            if (j == 0) edge[0][static_cast<std::size_t>(i)] = p;
            if (i + j == n) edge[1][static_cast<std::size_t>(j)] = p;
            if (i == 0) edge[2][static_cast<std::size_t>(n - j)] = p;
        }
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 1; i < n; ++i) look_on_edge(k, edge[k][i]);
    if (!attain(std::max(highest, on_edges))) return true;
    // Bezier coefficients of the quadratics, once subdivided.
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t half = 0; half < n; half += 2) {
            const Vec3d &a = edge[k][half], &m = edge[k][half + 1], &b = edge[k][half + 2];
            const Vec3d control = 2.0 * m - 0.5 * (a + b);
            look_on_edge(k, 0.5 * (a + control));
            look_on_edge(k, 0.5 * (control + b));
        }
    const auto look = [&](double a, double b, double c, double ab, double bc, double ca) {
        const double start[3] = {a, b, c}, end[3] = {b, c, a};
        const double control[3] = {2 * ab - 0.5 * (a + b), 2 * bc - 0.5 * (b + c), 2 * ca - 0.5 * (c + a)};
        const double sum = (control[0] + control[1]) + control[2];
        for (int k = 0; k < 3; ++k)
            highest = std::max({highest, 0.5 * std::abs(start[k] + control[k]), 0.5 * std::abs(control[k] + end[k]),
                                0.25 * std::abs(sum + end[k])});
    };
    for (int j = 0; j + 2 <= n; j += 2)
        for (int i = 0; i + j + 2 <= n; i += 2) {
            look(height[j][i], height[j][i + 2], height[j + 2][i], height[j][i + 1], height[j + 1][i + 1],
                 height[j + 1][i]);
            if (i + j + 4 <= n)
                look(height[j + 2][i + 2], height[j + 2][i], height[j][i + 2], height[j + 2][i + 1],
                     height[j + 1][i + 1], height[j + 1][i + 2]);
        }
    const double rest_on_edges = k_part * std::max({rest.edge[0], rest.edge[1], rest.edge[2]});
    highest += k_part * rest.height;
    const double beside = std::sqrt(reach) + rest_on_edges;
    return settled(std::max(std::sqrt(highest * highest + beside * beside), on_edges + rest_on_edges) +
                   k_rounding * scale_);
}

bool QuadBounder::bound_on_lattice(const WalkCell::Patch& patch, const Piece& piece, const Corners& corners,
                                   const Remainder& rest, bool may_split) {
    const auto& L = corners.linear;
    const double pad = k_rounding * scale_ + patch.beyond;
    // At the corners of a leaf that slides there is no room for what the quadratics leave out.
    const bool splits = may_split && distance_ && triangle_.has_slack();
    constexpr int k_side = k_finest_lattice + 1;
    std::array<Vec3d, k_side * k_side> node, surface;
    const auto at = [&](int i, int j) -> Vec3d& { return node[static_cast<std::size_t>(k_side * j + i)]; };
    constexpr std::int8_t none = -1;
    for (int n = 4; n <= k_finest_lattice; n *= 2) {
        const detail::LatticeShape shape(piece.turn, piece.quarter, n);
        const detail::LatticeColumns columns(*patch.net, shape);
        const double inv = 1.0 / n;
        double attained = 0;
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i + j <= n; ++i) {
                const Vec3d p = columns.at(shape.x(i, j), shape.y(i, j));
                const double b1 = i * inv, b2 = j * inv, b0 = 1 - b1 - b2;
                const Vec3d deviation = p - (b0 * L[0] + b1 * L[1] + b2 * L[2]);
                at(i, j) = measured_form(p, deviation);
                surface[static_cast<std::size_t>(k_side * j + i)] = p;
                if ((i == 0) + (j == 0) + (i + j == n) > 1) continue;  // a corner
                const int edge =
                    j == 0 ? piece.edge[0] : (i == 0 ? piece.edge[2] : (i + j == n ? piece.edge[1] : none));
                const double error = node_error(at(i, j), edge);
                attained = std::max(attained, error);
                if (!attain(error - patch.beyond)) return true;
            }
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3d& corner = c == 0 ? at(0, 0) : (c == 1 ? at(n, 0) : at(0, n));
            attained =
                std::max({attained, node_error(corner, piece.edge[c]), node_error(corner, piece.edge[(c + 2) % 3])});
        }
        const double parts = 0.5 * n;
        const Remainder part = rest * (1 / (parts * parts * parts));
        // Between neighbouring nodes the quadratics bulge a quarter as far as over their own triangles.
        double bulge = 0;
        const auto p_at = [&](int i, int j) -> const Vec3d& {
            return surface[static_cast<std::size_t>(k_side * j + i)];
        };
        const auto look = [&](const Vec3d& e) { bulge = std::max(bulge, glm::dot(e, e)); };
        const auto quadratic_bulge = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& ab,
                                         const Vec3d& bc, const Vec3d& ca) {
            const Vec3d x = ab - 0.5 * (a + b), y = bc - 0.5 * (b + c), z = ca - 0.5 * (c + a);
            look(x), look(y), look(z), look(0.5 * (x + y + z));
        };
        for (int j = 0; j + 2 <= n; j += 2)
            for (int i = 0; i + j + 2 <= n; i += 2) {
                quadratic_bulge(p_at(i, j), p_at(i + 2, j), p_at(i, j + 2), p_at(i + 1, j), p_at(i + 1, j + 1),
                                p_at(i, j + 1));
                if (i + j + 4 <= n)
                    quadratic_bulge(p_at(i + 2, j + 2), p_at(i, j + 2), p_at(i + 2, j), p_at(i + 1, j + 2),
                                    p_at(i + 1, j + 1), p_at(i + 2, j + 1));
            }
        if (settled(attained + 0.25 * std::sqrt(bulge) + part.whole + pad)) return true;
        double most = 0;
        for (int j = 0; j + 2 <= n; j += 2)
            for (int i = 0; i + j + 2 <= n; i += 2) {
                const std::array<std::int8_t, 3> edge = {j == 0 ? piece.edge[0] : none,
                                                         i + j + 2 == n ? piece.edge[1] : none,
                                                         i == 0 ? piece.edge[2] : none};
                most = std::max(most, quadratic_error({at(i, j), at(i + 2, j), at(i, j + 2)},
                                                      {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, edge, part));
                if (i + j + 4 <= n)
                    most = std::max(most, quadratic_error({at(i + 2, j + 2), at(i, j + 2), at(i + 2, j)},
                                                          {at(i + 1, j + 2), at(i + 1, j + 1), at(i + 2, j + 1)},
                                                          {-1, -1, -1}, part));
            }
        if (settled(most + pad)) return true;
        if (n == k_finest_lattice && patch.beyond == 0 && !splits) upper_ = std::max(upper_, most + pad);
    }
    return patch.beyond == 0 && !splits;
}

}  // namespace tetrakis
