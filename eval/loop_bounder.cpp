#include "tetrakis/eval/loop_bounder.hpp"

#include "tetrakis/eval/second_bounds.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace tetrakis {

using detail::Bary;
using detail::BoxSplineHessian;
using detail::LoopCell;

namespace {

/// Rounding of one patch evaluation and one interpolation, in units of the largest coordinate: fewer than 100
/// operations on values not larger than it, each off by half an ulp at most.
constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// Pieces are split at most this many levels below the leaf; cells that are still irregular then are bounded by their
/// hull.
constexpr int k_max_refinement = 40;

/// A bound this close above an attained value is not refined any more.
constexpr double k_tight = 1.05;

constexpr int next3(int i) { return i == 2 ? 0 : i + 1; }
constexpr int prev3(int i) { return i == 0 ? 2 : i - 1; }

double squared(const Vec3d& v) { return glm::dot(v, v); }

Bary middle(const Bary& a, const Bary& b) { return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])}; }

/// Second derivatives of a patch along an edge of a triangle within it, as a quadratic: its Bernstein coefficients on
/// the triangle at the corners and at the edge itself, and a bound on its norm.
struct EdgeSecond {
    std::array<Vec3d, 3> corner;
    Vec3d along_edge;  ///< the coefficient of the edge
    double bound = 0;  ///< of the norm over the triangle

    /// S - L in the middle of the edge, when it vanishes at both ends. The weights are the integrals of the three
    /// Bernstein polynomials against the Green function of the second derivative at 1/2.
    Vec3d middle_deviation(int edge) const {
        return (-1.0 / 192) * (7.0 * (corner[edge] + corner[next3(edge)]) + 10.0 * along_edge);
    }
};

/// For a triangle of a quadtree (edges parallel to the patch's): edge k of `at` is parallel to patch edge `parallel`.
EdgeSecond edge_second_red(const BoxSplineHessian& h, const std::array<Bary, 3>& at, int k, int parallel, double size) {
    EdgeSecond out;
    const double scale = size * size;
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        out.corner[i] = scale * h.along(parallel, at[i]);
        largest = std::max(largest, squared(out.corner[i]));
    }
    // The blossom of a product of two coordinates lies below the mean by half the product of their differences, here
    // -size^2.
    out.along_edge = 0.5 * (out.corner[k] + out.corner[next3(k)]) + (0.5 * scale * scale) * h.bend[parallel];
    out.bound = std::sqrt(std::max(largest, squared(out.along_edge)));
    return out;
}

/// Along the difference of two points: -(d0 d1 D01 + d1 d2 D12 + d2 d0 D20), as for any quadratic form.
std::array<double, 3> along_weights(const Bary& d) { return {-d[0] * d[1], -d[1] * d[2], -d[2] * d[0]}; }

EdgeSecond edge_second(const BoxSplineHessian& h, const std::array<Bary, 3>& at, int k) {
    const auto difference = [&](int i) {
        const Bary &a = at[i], &b = at[next3(i)];
        return Bary{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    };
    const std::array<double, 3> weight = along_weights(difference(k));
    EdgeSecond out;
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        out.corner[i] = Vec3d(0);
        for (int e = 0; e < 3; ++e)
            if (weight[e] != 0) out.corner[i] += weight[e] * h.along(e, at[i]);
        largest = std::max(largest, squared(out.corner[i]));
    }
    for (int i = 0; i < 3; ++i) {
        const Bary d = difference(i);
        Vec3d control = 0.5 * (out.corner[i] + out.corner[next3(i)]);
        for (int e = 0; e < 3; ++e)
            if (weight[e] != 0) control -= (0.5 * weight[e] * d[e] * d[next3(e)]) * h.bend[e];
        largest = std::max(largest, squared(control));
        if (i == k) out.along_edge = control;
    }
    out.bound = std::sqrt(largest);
    return out;
}

std::array<EdgeSecond, 3> edge_seconds(const BoxSplineHessian& h, const std::array<Bary, 3>& at) {
    // Red triangles: edge k runs along patch edge p (the third coordinate does not change), one after the other.
    for (int p = 0; p < 3; ++p) {
        const int p1 = next3(p), p2 = prev3(p);
        if (at[0][p2] == at[1][p2] && at[1][p] == at[2][p] && at[2][p1] == at[0][p1]) {
            const double size = std::abs(at[1][p] - at[0][p]);
            return {edge_second_red(h, at, 0, p, size), edge_second_red(h, at, 1, p1, size),
                    edge_second_red(h, at, 2, p2, size)};
        }
    }
    return {edge_second(h, at, 0), edge_second(h, at, 1), edge_second(h, at, 2)};
}

/// S - L at the centroid: two thirds of the deviation in the middle of edge 1, plus what the median from corner 0 to it
/// bends. 13, 22 and 19 over 486 are the integrals of the Bernstein polynomials against the Green function at 2/3.
Vec3d centroid_deviation(const BoxSplineHessian& h, const std::array<Bary, 3>& at, const Vec3d& middle_of_edge_1) {
    const Bary &a = at[0], m = middle(at[1], at[2]);
    const Bary d{m[0] - a[0], m[1] - a[1], m[2] - a[2]};
    const std::array<double, 3> weight = along_weights(d);
    Vec3d first(0), last(0), bend(0);
    for (int e = 0; e < 3; ++e) {
        first += weight[e] * h.along(e, a);
        last += weight[e] * h.along(e, m);
        bend += (weight[e] * d[e] * d[next3(e)]) * h.bend[e];
    }
    const Vec3d control = 0.5 * (first + last) - 0.5 * bend;
    return (2.0 / 3) * middle_of_edge_1 - (1.0 / 486) * (13.0 * first + 22.0 * control + 19.0 * last);
}

bool is_corner(const Bary& b) { return b[0] == 1 || b[1] == 1 || b[2] == 1; }
int corner_of(const Bary& b) { return b[0] == 1 ? 0 : b[1] == 1 ? 1 : 2; }

}  // namespace

LoopBounder::LoopBounder(const LoopPatches& patches)
    : patches_(patches), pad_(k_rounding * patches.largest_coordinate()), way_(1) {}

LoopBounder::Level& LoopBounder::locate(const CellTriangle& leaf, Corners& at) {
    if (leaf.root != root_ || known_ == 0) {
        root_ = leaf.root;
        way_[0].cell = patches_.root_cell(leaf.root);
        way_[0].has_hessian = false;
        known_ = 1;
    }
    std::int64_t size = std::int64_t{1} << leaf.level;
    std::array<std::array<std::int64_t, 3>, 3> p;
    const auto turn = [&](int by) {
        if (by == 0) return;
        for (auto& b : p) std::rotate(b.begin(), b.begin() + by, b.end());
    };
    for (int i = 0; i < 3; ++i) {
        const std::int64_t x = leaf.corner[i].x, y = leaf.corner[i].y;
        p[i] = {size - x - y, x, y};
    }
    turn(way_[0].cell.turn);
    int depth = 0;
    while (way_[depth].cell.kind != LoopCell::Kind::regular && size > 1) {
        // The quarter that holds all three corners, if there is one.
        const std::int64_t half = size / 2;
        int quarter = -1;
        for (int k = 0; k < 3; ++k)
            if (p[0][k] >= half && p[1][k] >= half && p[2][k] >= half) quarter = k;
        if (quarter < 0) {
            bool in_centre = true;
            for (const auto& b : p) in_centre &= b[0] <= half && b[1] <= half && b[2] <= half;
            if (!in_centre) break;
            quarter = 3;
        }
        for (auto& b : p) {
            if (quarter == 3)
                b = {half - b[0], half - b[1], half - b[2]};
            else
                b[quarter] -= half;
        }
        size = half;
        ++depth;
        if (static_cast<std::size_t>(depth) == way_.size()) way_.emplace_back();
        Level& level = way_[depth];
        if (depth >= known_ || level.quarter != quarter) {
            level.cell = patches_.child(way_[depth - 1].cell, quarter);
            level.quarter = quarter;
            level.has_hessian = false;
            known_ = depth + 1;
        }
        turn(level.cell.turn);
    }
    const double scale = 1.0 / static_cast<double>(size);
    for (int i = 0; i < 3; ++i)
        at[i] = {static_cast<double>(p[i][0]) * scale, static_cast<double>(p[i][1]) * scale,
                 static_cast<double>(p[i][2]) * scale};
    return way_[depth];
}

const BoxSplineHessian& LoopBounder::hessian(Level& level) {
    if (!level.has_hessian) {
        level.hessian = BoxSplineHessian(level.cell.net);
        level.has_hessian = true;
    }
    return level.hessian;
}

void LoopBounder::attain(const Vec3d& deviation) {
    lower_ = std::max(lower_, std::sqrt(squared(deviation)));
    if (lower_ > decide_at_) rejected_ = true;
}

/// Whether a piece with this bound needs no further work.
bool LoopBounder::settle(double upper) {
    if (upper > decide_at_ && upper > k_tight * lower_ + pad_ && upper > upper_) return false;
    upper_ = std::max(upper_, upper);
    return true;
}

void LoopBounder::bound_regular(const BoxSplineHessian& h, const Corners& at, const std::array<Vec3d, 3>& deviation,
                                int depth) {
    if (rejected_) return;
    const std::array<EdgeSecond, 3> edge = edge_seconds(h, at);
    const double own = detail::triangle_deviation(edge[0].bound, edge[1].bound, edge[2].bound);
    const double attained = std::sqrt(std::max({squared(deviation[0]), squared(deviation[1]), squared(deviation[2])}));
    const double upper = attained + own + pad_;
    if (settle(upper)) return;
    std::array<Vec3d, 3> inner;  // S - L in the middle of edge k
    for (int k = 0; k < 3; ++k) {
        inner[k] = edge[k].middle_deviation(k);
        const Vec3d there = 0.5 * (deviation[k] + deviation[next3(k)]) + inner[k];
        if (k == 1)
            attain((1.0 / 3) * (deviation[0] + deviation[1] + deviation[2]) + centroid_deviation(h, at, inner[1]));
        inner[k] = there;
        attain(there);
    }
    if (rejected_ || settle(upper)) return;
    if (depth == 0) {
        upper_ = std::max(upper_, upper);
        return;
    }
    std::array<Bary, 3> mid;
    for (int k = 0; k < 3; ++k) mid[k] = middle(at[k], at[next3(k)]);
    bound_regular(h, {mid[1], mid[2], mid[0]}, {inner[1], inner[2], inner[0]}, depth - 1);
    bound_regular(h, {at[0], mid[0], mid[2]}, {deviation[0], inner[0], inner[2]}, depth - 1);
    bound_regular(h, {mid[0], at[1], mid[1]}, {inner[0], deviation[1], inner[1]}, depth - 1);
    bound_regular(h, {mid[2], mid[1], at[2]}, {inner[2], inner[1], deviation[2]}, depth - 1);
}

void LoopBounder::bound_quarter(const LoopCell& cell, int quarter, const Piece& piece, int depth) {
    if (rejected_) return;
    const LoopCell child = patches_.child(cell, quarter);
    Piece part = piece;
    for (Bary& b : part.at) b = detail::turned(detail::in_quarter(b, quarter), child.turn);
    if (child.kind == LoopCell::Kind::regular)
        bound_regular(BoxSplineHessian(child.net), part.at, part.deviation, depth - 1);
    else
        bound_irregular(child, part, depth - 1);
}

void LoopBounder::bound_irregular(const LoopCell& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    double upper = std::numeric_limits<double>::infinity();
    if (cell.kind != LoopCell::Kind::split) {
        // S - L lies in the hull of all differences between the cell's points and L's corners.
        double far = 0;
        const auto look = [&](const Vec3d& p) {
            for (const Vec3d& l : piece.linear) far = std::max(far, squared(p - l));
        };
        if (cell.kind == LoopCell::Kind::star) {
            for (int i = 0; i < detail::loop_star_size(cell.star->valence()); ++i) look(cell.star->points()[i]);
        } else {
            for (const detail::LoopRing& ring : cell.node->rings().corner) {
                look(ring.centre);
                for (const detail::LoopRing::Spoke& spoke : ring.spokes) look(spoke.point);
            }
        }
        upper = std::sqrt(far) + pad_;
        if (settle(upper)) return;
        if (depth <= 0) {
            upper_ = std::max(upper_, upper);
            return;
        }
    }
    const auto deviate = [&](const Vec3d& s, const Vec3d& linear) {
        const Vec3d d = s - linear;
        attain(d);
        return d;
    };

    int corners = 0;
    for (const Bary& b : piece.at) corners += is_corner(b) ? 1 : 0;
    if (corners == 3) {
        Piece p;  // in the order of the cell's corners
        for (int i = 0; i < 3; ++i) {
            const int k = corner_of(piece.at[i]);
            p.at[k] = piece.at[i], p.linear[k] = piece.linear[i], p.deviation[k] = piece.deviation[i];
        }
        Piece m;  // m[k]: middle of edge k
        const LoopCell centre = patches_.child(cell, 3);
        for (int k = 0; k < 3; ++k) {
            m.at[k] = middle(p.at[k], p.at[next3(k)]);
            m.linear[k] = 0.5 * (p.linear[k] + p.linear[next3(k)]);
            // Corner i of the centre is the middle of the edge opposite corner i.
            const Vec3d s = centre.kind == LoopCell::Kind::regular ? detail::box_spline_corner(centre.net, prev3(k))
                                                                   : patches_.position(cell, m.at[k]);
            m.deviation[k] = deviate(s, m.linear[k]);
        }
        for (int k = 2; k >= -1; --k) {
            const int quarter = k < 0 ? 0 : k == 0 ? 3 : k;  // the irregular one of a star last
            Piece part;
            for (int i = 0; i < 3; ++i) {
                const bool own = i == quarter;
                const int edge = quarter == 3 ? next3(i) : i == next3(quarter) ? quarter : prev3(quarter);
                part.at[i] = own ? p.at[i] : m.at[edge];
                part.linear[i] = own ? p.linear[i] : m.linear[edge];
                part.deviation[i] = own ? p.deviation[i] : m.deviation[edge];
            }
            bound_quarter(cell, quarter, part, depth);
        }
        return;
    }

    // Green triangles. Corner k of the cell; a second corner j or the middle of the edge from k to j; the middle of the
    // edge from j to the third corner. They fall into half the quarter at k, half the centre and, for a half, the
    // quarter at j.
    const auto find = [&](const auto& wanted) {
        int found = -1;
        for (int i = 0; i < 3; ++i)
            if (wanted(piece.at[i])) found = i;
        return found;
    };
    int ik, ij, im;  // positions in the piece
    if (corners == 2) {
        im = find([](const Bary& b) { return !is_corner(b); });
        // The corner that is not an end of the middle's edge.
        ik = find([&](const Bary& b) { return is_corner(b) && piece.at[im][corner_of(b)] == 0; });
        ij = 3 - im - ik;
    } else {
        ik = find([](const Bary& b) { return is_corner(b); });
        const int k = corner_of(piece.at[ik]);
        ij = find([&](const Bary& b) { return b[k] == 0.5; });
        im = 3 - ik - ij;
    }
    assert(ik >= 0 && ij >= 0 && im >= 0 && ik != ij);
    const int k = corner_of(piece.at[ik]);
    const auto point = [&](const Bary& at, const Vec3d& linear, Piece& out, int i) {
        out.at[i] = at;
        out.linear[i] = linear;
        out.deviation[i] = deviate(patches_.position(cell, at), linear);
    };
    const auto copy = [](const Piece& from, int i, Piece& to, int j) {
        to.at[j] = from.at[i], to.linear[j] = from.linear[i], to.deviation[j] = from.deviation[i];
    };
    // The middle of the edge k j, and the point x of the line from k to the other middle that is on the centre's side.
    Piece extra;
    if (corners == 2)
        point(middle(piece.at[ik], piece.at[ij]), 0.5 * (piece.linear[ik] + piece.linear[ij]), extra, 0);
    else
        copy(piece, ij, extra, 0);
    point(middle(piece.at[ik], piece.at[im]), 0.5 * (piece.linear[ik] + piece.linear[im]), extra, 1);
    Piece part;
    copy(extra, 0, part, 0);
    copy(piece, im, part, 1);
    copy(extra, 1, part, 2);
    bound_quarter(cell, 3, part, depth);
    copy(piece, ik, part, 1);
    bound_quarter(cell, k, part, depth);
    if (corners == 2) {
        copy(piece, ij, part, 1);
        copy(piece, im, part, 2);
        bound_quarter(cell, corner_of(piece.at[ij]), part, depth);
    }
}

LeafError LoopBounder::parametric_error(const CellTriangle& leaf, double decide_at) {
    decide_at_ = decide_at;
    lower_ = upper_ = 0;
    rejected_ = false;
    Corners at;
    Level& level = locate(leaf, at);
    if (level.cell.kind == LoopCell::Kind::regular) {
        bound_regular(hessian(level), at, {Vec3d(0), Vec3d(0), Vec3d(0)}, k_max_refinement);
    } else {
        Piece piece;
        piece.at = at;
        for (int i = 0; i < 3; ++i) {
            piece.linear[i] = patches_.position(level.cell, at[i]);
            piece.deviation[i] = Vec3d(0);
        }
        bound_irregular(level.cell, piece, k_max_refinement);
    }
    if (rejected_) upper_ = std::numeric_limits<double>::infinity();
    return {lower_, std::max(upper_, lower_)};
}

void LoopBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals) {
    Corners at;
    const Level& level = locate(leaf, at);
    const LoopCell& cell = level.cell;
    const bool is_regular = cell.kind == LoopCell::Kind::regular;
    const double unit = std::ldexp(1.0, -leaf.level), step = 1.0 / n;
    std::size_t out = 0;
    for (int row = 0; row <= n; ++row)  // distance from corner 2
        for (int i = 0; i <= row; ++i, ++out) {
            const double b0 = (row - i) * step, b1 = i * step, b2 = (n - row) * step;
            if (is_regular) {
                Bary b;
                for (int c = 0; c < 3; ++c) b[c] = b0 * at[0][c] + b1 * at[1][c] + b2 * at[2][c];
                if (normals.empty()) {
                    positions[out] = detail::box_spline_position(cell.net, b);
                } else {
                    const detail::BoxSplinePoint p = detail::box_spline_point(cell.net, b);
                    positions[out] = p.position;
                    normals[out] = glm::cross(p.dx, p.dy);  // turned cells keep the sign: both axes change theirs
                }
                continue;
            }
            const double x = (b0 * leaf.corner[0].x + b1 * leaf.corner[1].x + b2 * leaf.corner[2].x) * unit;
            const double y = (b0 * leaf.corner[0].y + b1 * leaf.corner[1].y + b2 * leaf.corner[2].y) * unit;
            const SurfacePoint p = patches_.evaluate(leaf.root, x, y);
            positions[out] = p.position;
            if (!normals.empty()) normals[out] = glm::cross(p.du, p.dv);
        }
}

}  // namespace tetrakis
