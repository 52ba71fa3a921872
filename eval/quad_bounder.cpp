#include "tetrakis/eval/quad_bounder.hpp"

#include "tetrakis/eval/plane_measure.hpp"
#include "tetrakis/eval/quad_lattice.hpp"
#include "tetrakis/eval/triangle_coefficients.hpp"

#include <limits>

namespace tetrakis {

using detail::k_centre_point;
using detail::k_corner_point;
using detail::k_corner_x;
using detail::k_corner_y;
using detail::k_side_point;
using detail::QuadNode;
using detail::WalkCell;

namespace {

/// Rounding of one patch evaluation and one interpolation, in units of the largest coordinate: fewer than 100
/// operations on values not larger than it, each off by half an ulp at most.
constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// A crease of finite sharpness counts as a sharp one first where that changes the error by this share of it at most.
constexpr double k_small_strip = 0.125;

/// Parts of a strip beside a crease are quartered this often before the cell is.
constexpr int k_strip_depth = 2;

/// Finest sample lattice of a smooth piece: what its quadratics leave of the cubic part is then a 64th.
constexpr int k_finest_lattice = 8;

/// A function minus the quadratic through its values at the corners and edge middles of a triangle is at most
/// xxx |f_xxx| + xxy |f_xxy| + ...: from Taylor's formula with the remainder, (1 / 6) sum_j |l_j(p)| |a_j - p|^3 with
/// the basis l_j of the nodes a_j, maximised over p for each kind of piece in the parameters of its cell.
constexpr detail::ThirdBounds k_half_remainder{0.0207, 0.0445, 0.0445, 0.0207};
constexpr detail::ThirdBounds k_quarter_remainder{0.0148, 0.0119, 0.0083, 0.0026};  // base along x

/// The same on a line of length 1: max |t (t - 1/2) (t - 1)| / 6 = sqrt(3) / 216.
constexpr double k_line_remainder = 0.00802;

double remainder_of(const detail::ThirdBounds& third, int turn, bool quarter) {
    const detail::ThirdBounds& k = quarter ? k_quarter_remainder : k_half_remainder;
    if ((turn & 1) == 0) return k.xxx * third.xxx + k.xxy * third.xxy + k.xyy * third.xyy + k.yyy * third.yyy;
    return k.xxx * third.yyy + k.xxy * third.xyy + k.xyy * third.xxy + k.yyy * third.xxx;
}

}  // namespace

QuadBounder::QuadBounder(const QuadPatches& patches) : patches_(patches), walk_(patches) {
    for (const Vec3d& p : patches.mesh().positions())
        scale_ = std::max({scale_, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

void QuadBounder::start(double decide_at, bool may_reject) {
    decide_at_ = decide_at;
    may_reject_ = may_reject;
    lower_ = upper_ = 0;
    rejected_ = false;
    distance_ = false;
}

LeafError QuadBounder::finish() const {
    if (rejected_) return {lower_, std::numeric_limits<double>::infinity()};
    return {lower_, std::max(upper_, lower_)};
}

bool QuadBounder::attain(double error) {
    lower_ = std::max(lower_, error);
    rejected_ |= may_reject_ && lower_ > decide_at_;
    return !rejected_;
}

bool QuadBounder::settled(double upper) {
    const double pad = k_rounding * scale_;
    if (upper > decide_at_ && upper > 1.05 * lower_ + pad && upper > upper_) return false;
    upper_ = std::max(upper_, upper);
    return true;
}

void QuadBounder::measure_distance(const std::array<Vec3d, 3>& corners) {
    distance_ = true;
    has_triangle_ = false;
    leaf_ = corners;
}

void QuadBounder::need_triangle() {
    if (!distance_ || has_triangle_) return;
    triangle_ = detail::TriangleDistance(leaf_);
    has_triangle_ = true;
}

double QuadBounder::node_error(const Vec3d& node, int edge) const {
    if (!distance_) return glm::length(node);
    return edge >= 0 ? triangle_.to_edge(node, static_cast<std::size_t>(edge)) : triangle_.to_triangle(node);
}

double QuadBounder::quadratic_error(const std::array<Vec3d, 3>& corner, const std::array<Vec3d, 3>& middle,
                                    const std::array<std::int8_t, 3>& edge, const Remainder& rest) const {
    double most = 0;  // squared
    if (!distance_) {
        const auto look = [&](const Vec3d& c) { most = std::max(most, glm::dot(c, c)); };
        detail::for_each_coefficient(
            corner, middle, [&](std::size_t, const Vec3d& c) { look(c); }, look);
        return std::sqrt(most) + rest.whole;
    }
    double most_on_edges = 0;
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
                most_on_edges =
                    std::max(most_on_edges, triangle_.to_edge(c, static_cast<std::size_t>(edge[k])) + rest.edge[k]);
            look(c);
        },
        look);
    return std::max(std::sqrt(most), most_on_edges);
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

bool QuadBounder::bound_regular(const WalkCell::Patch& patch, const Piece& piece, const Corners& corners) {
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
    if (distance_ && whole_leaf && !triangle_.sliver()) {
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
    if (settled(quadratic_error(corner, middle, piece.edge, rest) + pad)) return true;
    if (patch.beyond > 0) return false;  // its strips tell more than finer lattices
    return bound_on_lattice(patch, piece, corners, rest);
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
                                   const Remainder& rest) {
    const auto& L = corners.linear;
    const double pad = k_rounding * scale_ + patch.beyond;
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
        if (n == k_finest_lattice && patch.beyond == 0) upper_ = std::max(upper_, most + pad);
    }
    return patch.beyond == 0;
}

bool QuadBounder::bound_strips(WalkCell& cell, const Piece& piece, const Corners& corners) {
    const int k = piece.turn, k1 = (k + 1) & 3, k3 = (k + 3) & 3;
    const auto corner_at = [](int i) { return Vec2d(detail::k_corner_x[i], detail::k_corner_y[i]); };
    const int axis = cell.crease.side == 0 || cell.crease.side == 2 ? 1 : 0;  // across the crease
    const bool far = cell.crease.side == 1 || cell.crease.side == 2;
    struct Corner {
        Vec2d at;
        Vec3d linear;
        std::int8_t edge;  ///< to the next corner
        double distance;   ///< from the crease
    };
    constexpr std::size_t k_most = 5;  // corners of a triangle cut by two parallel lines
    using Polygon = std::array<Corner, k_most + 1>;
    Polygon whole;
    const std::array<Vec2d, 3> at = piece.quarter ? std::array<Vec2d, 3>{Vec2d(0.5), corner_at(k), corner_at(k1)}
                                                  : std::array<Vec2d, 3>{corner_at(k), corner_at(k1), corner_at(k3)};
    for (std::size_t i = 0; i < 3; ++i)
        whole[i] = {at[i], corners.linear[i], piece.edge[i], far ? 1 - at[i][axis] : at[i][axis]};
    // Keeps what lies on the one side (sign 1: at least) of the line at a distance from the crease.
    const auto clip = [](const Polygon& in, std::size_t count, double line, double sign, Polygon& out) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Corner &a = in[i], &b = in[(i + 1) % count];
            const double da = sign * (a.distance - line), db = sign * (b.distance - line);
            if (da >= 0) {
                out[kept] = a;
                if (da == 0 && db < 0) out[kept].edge = -1;
                ++kept;
            }
            if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
                const double t = da / (da - db);
                out[kept++] = {(1 - t) * a.at + t * b.at, (1 - t) * a.linear + t * b.linear,
                               da > 0 ? std::int8_t{-1} : a.edge, line};
            }
        }
        return kept;
    };
    const WalkCell::Strips& strips = cell.strips();
    for (std::size_t s = 0; s < static_cast<std::size_t>(strips.count); ++s) {
        const detail::CreaseStrip& strip = strips.strip[s];
        Polygon near, both;
        const std::size_t count = clip(near, clip(whole, 3, strip.begin, 1, near), strip.end, -1, both);
        if (count < 3) continue;
        std::array<Vec2d, k_most + 1> own;
        std::array<Vec3d, k_most + 1> surface;
        for (std::size_t i = 0; i < count; ++i) {
            own[i] = both[i].at;
            const double distance = (both[i].distance - strip.origin) / strip.span;
            own[i][axis] = far ? 1 - distance : distance;
            surface[i] = combine(strip.net, detail::cubic_basis(own[i].x), detail::cubic_basis(own[i].y));
        }
        for (std::size_t i = 1; i + 1 < count; ++i) {
            const Part part{{own[0], own[i], own[i + 1]},
                            {surface[0], surface[i], surface[i + 1]},
                            {both[0].linear, both[i].linear, both[i + 1].linear},
                            {i == 1 ? both[0].edge : std::int8_t{-1}, both[i].edge,
                             i + 2 == count ? both[i + 1].edge : std::int8_t{-1}}};
            if (!bound_part(strip.net, strips.third[s], part, k_strip_depth)) return false;
            if (rejected_) return true;
        }
    }
    return true;
}

bool QuadBounder::bound_part(const detail::Net16& net, const detail::ThirdBounds& third, const Part& part, int depth) {
    const double pad = k_rounding * scale_;
    std::array<Vec2d, 3> at;
    std::array<Vec3d, 3> surface, linear, corner, middle;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        at[i] = 0.5 * (part.at[i] + part.at[j]);
        linear[i] = 0.5 * (part.linear[i] + part.linear[j]);
        surface[i] = combine(net, detail::cubic_basis(at[i].x), detail::cubic_basis(at[i].y));
        corner[i] = measured_form(part.surface[i], part.surface[i] - part.linear[i]);
        middle[i] = measured_form(surface[i], surface[i] - linear[i]);
        if (!attain(node_error(middle[i], part.edge[i]))) return true;
    }
    const Vec2d u = part.at[1] - part.at[0], v = part.at[2] - part.at[0];
    Remainder rest;
    rest.whole = rest.height = remainder_of(third.in_frame(u, v), 0, false);
    if (distance_ && !triangle_.sliver())
        rest.height = remainder_of(detail::ThirdBounds::along(net, triangle_.normal()).in_frame(u, v), 0, false);
    for (std::size_t i = 0; i < 3; ++i)
        rest.edge[i] = k_line_remainder * third.on_line(part.at[(i + 1) % 3] - part.at[i]);
    if (settled(quadratic_error(corner, middle, part.edge, rest) + pad)) return true;
    if (depth == 0) return false;
    const auto sub = [&](std::size_t i) {
        // The quarter at corner i.
        const std::size_t k = (i + 2) % 3;
        return Part{{part.at[i], at[i], at[k]},
                    {part.surface[i], surface[i], surface[k]},
                    {part.linear[i], linear[i], linear[k]},
                    {part.edge[i], -1, part.edge[k]}};
    };
    for (std::size_t i = 0; i < 3; ++i)
        if (!bound_part(net, third, sub(i), depth - 1)) return false;
    return bound_part(net, third, {at, surface, linear, {-1, -1, -1}}, depth - 1);
}

double QuadBounder::tip_error(const QuadNode& node, const Piece& piece, const Corners& corners) const {
    constexpr double k_unknown = std::numeric_limits<double>::infinity();
    if (!distance_ || node.kind != QuadNode::Kind::star || !node.tip) return k_unknown;
    const detail::QuadTip& tip = node.tip;
    // The star's corner as the piece's, and the piece's edges that lie along d0, d1 and between them.
    constexpr std::size_t none = 3;
    std::size_t corner = none, along0 = none, along1 = none, diagonal = none;
    const int from = (node.turn - piece.turn) & 3;
    if (piece.quarter) {
        if (from == 0) corner = 1, along0 = 1, diagonal = 0;
        if (from == 1) corner = 2, along1 = 1, diagonal = 2;
    } else {
        if (from == 0) corner = 0, along0 = 0, along1 = 2;
        if (from == 1) corner = 1, along1 = 0, diagonal = 1;
        if (from == 3) corner = 2, along0 = 2, diagonal = 1;
    }
    if (corner == none || corners.deviation[corner] != Vec3d(0)) return k_unknown;
    const Vec3d& origin = corners.linear[corner];
    const double reach = tip.map->reach;
    const Vec3d far = origin + reach * (tip.d0 + tip.d1);
    double error = triangle_.to_triangle(triangle_.local(far));
    const auto look = [&](std::size_t edge, const Vec3d& end, bool inside) {
        if (edge == none) return;
        const Vec3d local = triangle_.local(end);
        if (inside) error = std::max(error, triangle_.to_triangle(local));
        if (piece.edge[edge] >= 0)
            error = std::max(error, triangle_.to_edge(local, static_cast<std::size_t>(piece.edge[edge])));
    };
    look(along0, origin + reach * tip.d0, true);
    look(along1, origin + reach * tip.d1, true);
    look(diagonal, far, false);
    return error + tip.rest;
}

double QuadBounder::hull_error(const QuadNode& node, const Piece& piece, const Corners& corners) const {
    const Vec3d* points = node.kind == QuadNode::Kind::star ? node.star->points.data() : node.local->points.data();
    const std::size_t count = node.kind == QuadNode::Kind::star ? node.star->points.size() : node.local->points.size();
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        // A corner of the piece that all the leaf's edges at the piece meet at stands for all of them.
        const std::size_t opposite = (k + 1) % 3;
        if (distance_ && piece.edge[opposite] >= 0) continue;
        double far = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3d d = points[i] - corners.linear[k];
            far = std::max(far, glm::dot(d, d));
        }
        most = std::max(most, far);
        least = std::min(least, far);
    }
    return std::sqrt(distance_ ? least : most);
}

void QuadBounder::bound(const Piece& piece, const Corners& corners, int depth) {
    if (rejected_) return;
    WalkCell& cell = home(piece);
    if (cell.irregular() || cell.crease) need_triangle();
    if (cell.irregular()) {
        double upper = tip_error(*cell.node, piece, corners);
        if (upper > decide_at_) upper = std::min(upper, hull_error(*cell.node, piece, corners));
        upper += k_rounding * scale_;
        if (settled(upper)) return;
        if (depth == 0) {
            upper_ = std::max(upper_, upper);
            return;
        }
    } else if (!cell.crease) {
        if (bound_regular(cell.patch(), piece, corners)) return;
    } else {
        // Where the crease's strip is next to nothing, as if the crease were sharp: that is cheaper.
        if (cell.beyond() <= k_small_strip * decide_at_ && bound_regular(cell.patch(), piece, corners)) return;
        if (bound_strips(cell, piece, corners)) return;
    }
    split(piece, corners, depth);
}

void QuadBounder::split(const Piece& piece, const Corners& corners, int depth) {
    // The new corners are the midpoints of the edges (of the base alone for a quarter).
    WalkCell& cell = home(piece);
    const auto& L = corners.linear;
    const auto& D = corners.deviation;
    const auto& E = piece.edge;
    const int k = piece.turn, k1 = (k + 1) & 3, k2 = (k + 2) & 3, k3 = (k + 3) & 3;
    const auto part = [&](int at, int turn, std::array<std::int8_t, 3> edge) {
        Piece p = piece;
        p.level += 1;
        p.x = 2 * piece.x + static_cast<unsigned>(k_corner_x[at]);
        p.y = 2 * piece.y + static_cast<unsigned>(k_corner_y[at]);
        p.turn = turn;
        p.quarter = false;
        p.edge = edge;
        return p;
    };
    const std::int8_t none = -1;
    std::array<Vec3d, 3> l, d;
    const auto middle = [&](std::size_t i, int point) {
        const Vec3d s = cell.point(point);
        l[i] = 0.5 * (L[i] + L[(i + 1) % 3]);
        d[i] = s - l[i];
        return attain(node_error(measured_form(s, d[i]), E[i]));
    };
    if (piece.quarter) {
        if (!middle(1, k_side_point[k])) return;
        bound(part(k, k1, {none, E[0], E[1]}), {{l[1], L[0], L[1]}, {d[1], D[0], D[1]}}, depth - 1);
        bound(part(k1, k, {E[1], E[2], none}), {{l[1], L[2], L[0]}, {d[1], D[2], D[0]}}, depth - 1);
        return;
    }
    if (!middle(0, k_side_point[k]) || !middle(1, k_centre_point) || !middle(2, k_side_point[k3])) return;
    bound(part(k, k, {E[0], none, E[2]}), {{L[0], l[0], l[2]}, {D[0], d[0], d[2]}}, depth - 1);
    bound(part(k, k2, {none, none, none}), {{l[1], l[2], l[0]}, {d[1], d[2], d[0]}}, depth - 1);
    bound(part(k1, k, {E[0], E[1], none}), {{l[0], L[1], l[1]}, {d[0], D[1], d[1]}}, depth - 1);
    bound(part(k3, k, {none, E[1], E[2]}), {{l[2], l[1], L[2]}, {d[2], d[1], D[2]}}, depth - 1);
}

QuadBounder::Piece QuadBounder::piece_of(const CellTriangle& leaf) {
    const LatticePoint a = leaf.corner[0], b = leaf.corner[1], apex = leaf.corner[2];
    Piece piece;
    piece.root = leaf.root;
    piece.edge = {0, 1, 2};
    const std::uint32_t x0 = std::min({a.x, b.x, apex.x}), x1 = std::max({a.x, b.x, apex.x});
    const std::uint32_t y0 = std::min({a.y, b.y, apex.y}), y1 = std::max({a.y, b.y, apex.y});
    if (x1 - x0 == 1 && y1 - y0 == 1) {
        piece.level = leaf.level;
        piece.x = x0, piece.y = y0;
        const int cx = apex.x != x0, cy = apex.y != y0;
        piece.turn = cy == 0 ? cx : 3 - cx;
        return piece;
    }
    piece.level = leaf.level - 1;
    piece.quarter = true;
    piece.x = (apex.x - 1) / 2, piece.y = (apex.y - 1) / 2;
    if (a.y < apex.y && b.y < apex.y)
        piece.turn = 0;
    else if (a.x > apex.x && b.x > apex.x)
        piece.turn = 1;
    else if (a.y > apex.y && b.y > apex.y)
        piece.turn = 2;
    else
        piece.turn = 3;
    return piece;
}

QuadBounder::Corners QuadBounder::leaf_corners(const Piece& piece) {
    WalkCell& cell = home(piece);
    const int k = piece.turn;
    Corners corners;
    if (piece.quarter) {
        corners.linear = {cell.point(k_centre_point), cell.point(k_corner_point[k]),
                          cell.point(k_corner_point[(k + 1) & 3])};
    } else {
        corners.linear = {cell.point(k_corner_point[k]), cell.point(k_corner_point[(k + 1) & 3]),
                          cell.point(k_corner_point[(k + 3) & 3])};
    }
    corners.deviation = {Vec3d(0), Vec3d(0), Vec3d(0)};
    return corners;
}

bool QuadBounder::is_root(const CellTriangle& leaf) { return leaf.level == 0 && leaf.corner[1].x == 2; }

LeafError QuadBounder::leaf_error(const CellTriangle& leaf, double decide_at) {
    start(decide_at, may_reject_);
    if (is_root(leaf)) {
        bound_root(leaf.root, nullptr);
        return finish();
    }
    // The middle of the base decides most leaves that must be split.
    const Piece piece = piece_of(leaf);
    const Corners corners = leaf_corners(piece);
    WalkCell& cell = home(piece);
    const Vec3d middle = cell.point(piece.quarter ? k_side_point[piece.turn] : k_centre_point);
    if (attain(detail::segment_distance(middle, corners.linear[1], corners.linear[2]))) {
        measure_distance(corners.linear);
        bound(piece, corners, detail::k_max_refinement);
    }
    return finish();
}

void QuadBounder::bound_root(HalfedgeId h, const Vec3d* centre) {
    // Two half-cells that share the edge from the midpoint m of the base to the centre c. Edges of the leaf: from c to
    // v, v to w, w to c.
    const HalfedgeId g = patches_.mesh().next(h);
    const Piece first{h, 0, 0, 0, 1, false, {-1, 0, 1}}, second{g, 0, 0, 0, 3, false, {1, 2, -1}};
    Corners left = leaf_corners(first), right = leaf_corners(second);
    const Vec3d v = left.linear[2], c = left.linear[1], w = right.linear[1], m = left.linear[0];
    const Vec3d base = 0.5 * (v + w), linear_centre = centre ? *centre : c;
    if (!centre) {
        // The middles of the edges decide most leaves that must be split.
        const auto reject = [&](const Vec3d& p, const Vec3d& a, const Vec3d& b) {
            return !attain(detail::segment_distance(p, a, b));
        };
        if (reject(m, v, w) || reject(home(second).point(k_centre_point), w, c) ||
            reject(home(first).point(k_centre_point), c, v))
            return;
        measure_distance({c, v, w});
        need_triangle();
    }
    left.linear = {base, linear_centre, v};
    right.linear = {base, w, linear_centre};
    left.deviation[0] = right.deviation[0] = m - base;
    left.deviation[1] = right.deviation[2] = c - linear_centre;
    if (!attain(std::max(node_error(measured_form(m, m - base), 1), centre ? glm::length(c - linear_centre) : 0.0)))
        return;
    bound(first, left, detail::k_max_refinement);
    bound(second, right, detail::k_max_refinement);
}

LeafError QuadBounder::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    start(decide_at, may_reject);
    bound_root(root, &centre);
    may_reject_ = true;
    return finish();
}

double QuadBounder::certified_error(const CellTriangle& leaf, double floor) {
    may_reject_ = false;
    const LeafError e = leaf_error(leaf, floor);
    may_reject_ = true;
    return e.upper;
}

QuickError QuadBounder::quick_error(const CellTriangle& leaf) {
    QuickError quick;
    if (is_root(leaf)) {
        WalkCell& cell = walk_.cell(leaf.root, 0, 0, 0);
        const Vec3d v = cell.point(k_corner_point[0]), m = cell.point(k_corner_point[1]),
                    c = cell.point(k_corner_point[2]);
        const Vec3d w = walk_.cell(patches_.mesh().next(leaf.root), 0, 0, 0).point(k_corner_point[0]);
        quick.corners = {v, w, c};
        quick.middle = m - 0.5 * (v + w);
        return quick;
    }
    const Piece piece = piece_of(leaf);
    const Corners corners = leaf_corners(piece);
    const Vec3d middle = home(piece).point(piece.quarter ? k_side_point[piece.turn] : k_centre_point);
    // corners.linear starts at the apex or right angle, which is the leaf's corner 2; 1 and 2 follow counter-clockwise.
    quick.corners = {corners.linear[1], corners.linear[2], corners.linear[0]};
    quick.middle = middle - 0.5 * (quick.corners[0] + quick.corners[1]);
    return quick;
}

}  // namespace tetrakis
