#include "loop_bounder.hpp"

#include "box_spline_error.hpp"
#include "box_spline_lattice.hpp"
#include "triangle_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tetrakis {

using detail::Bary;
using detail::BoxSplineHessian;
using detail::corner_of;
using detail::EdgeSecond;
using detail::is_corner;
using detail::LoopCell;
using detail::middle;
using detail::next3;
using detail::squared;

namespace {

/// Rounding of one patch evaluation and one interpolation, in units of the largest coordinate: fewer than 100
/// operations on values not larger than it, each off by half an ulp at most.
constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// Pieces are split at most this many levels below the leaf; cells that are still irregular then are bounded by their
/// hull.
constexpr int k_max_refinement = 40;

/// A bound this close above an attained value is not refined any more.
constexpr double k_tight = 1.05;

constexpr std::array<Bary, 3> k_whole{Bary{1, 0, 0}, Bary{0, 1, 0}, Bary{0, 0, 1}};

}  // namespace

LoopBounder::LoopBounder(const LoopPatches& patches)
    : patches_(patches), pad_(k_rounding * patches.largest_coordinate()), way_(1) {}

LoopBounder::Level& LoopBounder::locate(const CellTriangle& leaf, Corners& at) {
    if (leaf.root != root_ || known_ == 0) {
        root_ = leaf.root;
        patches_.root_cell(leaf.root, way_[0].cell);
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
            patches_.child(way_[depth - 1].cell, quarter, level.cell);
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

LoopBounder::Point LoopBounder::halfway(const Point& a, const Point& b) {
    return {0.5 * (a.b1 + b.b1), 0.5 * (a.b2 + b.b2), 0.5 * (a.deviation + b.deviation), 0};
}

LoopBounder::Point LoopBounder::combine(const Points& c, const Bary& at) {
    return {at[0] * c[0].b1 + at[1] * c[1].b1 + at[2] * c[2].b1, at[0] * c[0].b2 + at[1] * c[1].b2 + at[2] * c[2].b2,
            at[0] * c[0].deviation + at[1] * c[1].deviation + at[2] * c[2].deviation, 0};
}

bool LoopBounder::on_one_side(const Point& a, const Point& b) {
    return (a.b1 == 0 && b.b1 == 0) || (a.b2 == 0 && b.b2 == 0) || (a.b1 + a.b2 == 1 && b.b1 + b.b2 == 1);
}

void LoopBounder::set_leaf(const std::array<Vec3d, 3>& corners, const EdgeSlack& slack) {
    corners_ = corners;
    for (std::size_t k = 0; k < 3; ++k) {
        side_[k] = corners[(k + 1) % 3] - corners[k];
        const double size = squared(side_[k]);
        inverse_squared_[k] = size > 0 ? 1 / size : 0;
    }
    has_triangle_ = false;
    if (slack.any()) set_slack(slack);
}

/// False where the triangle is too thin for any.
bool LoopBounder::set_slack(const EdgeSlack& slack) {
    triangle_ = detail::TriangleDistance(corners_);
    has_triangle_ = true;
    if (triangle_.sliver()) return false;
    triangle_.set_slack(slack);
    stretch_ = triangle_.stretch();
    decide_at_ /= stretch_ * detail::k_stretch_rounding;
    return true;
}

/// Of a point with parameters on side k.
double LoopBounder::to_side(const Point& p, std::size_t k) const {
    if (stretch_ > 1 && triangle_.slides(k))
        return triangle_.to_edge(triangle_.inside(p.b1, p.b2) + triangle_.local_vector(p.deviation), k);
    const double place = k == 0 ? p.b1 : (k == 1 ? p.b2 : 1 - p.b1 - p.b2);
    const double foot = place + glm::dot(p.deviation, side_[k]) * inverse_squared_[k];
    return std::sqrt(squared(p.deviation - (std::clamp(foot, 0.0, 1.0) - place) * side_[k]));
}

double LoopBounder::to_triangle(const Point& p) {
    if (!has_triangle_) {
        triangle_ = detail::TriangleDistance(corners_);
        has_triangle_ = true;
    }
    return triangle_.to_triangle(triangle_.inside(p.b1, p.b2) + triangle_.local_vector(p.deviation));
}

double LoopBounder::error_of(const Point& p) {
    // Parameters are dyadic: these are exact.
    const bool on0 = p.b2 == 0, on1 = p.b1 + p.b2 == 1, on2 = p.b1 == 0;
    if (!on0 && !on1 && !on2) return to_triangle(p);
    double error = 0;
    if (on0) error = to_side(p, 0);
    if (on1) error = std::max(error, to_side(p, 1));
    if (on2) error = std::max(error, to_side(p, 2));
    return error;
}

void LoopBounder::attain(Point& point) {
    point.error = error_of(point);
    lower_ = std::max(lower_, point.error);
    rejected_ |= point.error > decide_at_;
}

/// Whether a piece with this bound needs no further work.
bool LoopBounder::settle(double upper) {
    if (upper > k_tight * lower_ + pad_) return accept(upper);
    upper_ = std::max(upper_, upper);
    return true;
}

/// The same, but for pieces whose bound may still become better: how tight it is does not count.
bool LoopBounder::accept(double upper) {
    if (upper > decide_at_ && upper > upper_) return false;
    upper_ = std::max(upper_, upper);
    return true;
}

/// Takes the middles of a piece's edges. Whether that settles it: its quarters have a quarter of its own deviation.
bool LoopBounder::attain_inner(Points& inner, double attained, double own) {
    const double rest = 0.25 * own + pad_;
    double most = attained;
    for (Point& p : inner) {
        attain_where_needed(p, rest);
        if (rejected_) return true;
        most = std::max(most, p.error);
    }
    return accept(most + rest);
}

/// @param bend  S - L' there, L' the interpolant of the points
void LoopBounder::attain_centroid(const Points& p, const Vec3d& bend) {
    Point c;
    c.b1 = (1.0 / 3) * (p[0].b1 + p[1].b1 + p[2].b1);
    c.b2 = (1.0 / 3) * (p[0].b2 + p[1].b2 + p[2].b2);
    c.deviation = (1.0 / 3) * (p[0].deviation + p[1].deviation + p[2].deviation) + bend;
    if (squared(c.deviation) <= lower_ * lower_) return;
    // Inside the leaf, whatever its rounded parameters say.
    c.error = to_triangle(c);
    lower_ = std::max(lower_, c.error);
    rejected_ |= c.error > decide_at_;
}

void LoopBounder::bound_red(const BoxSplineHessian& h, const Points& point, double own, int depth) {
    if (rejected_) return;
    const double attained = largest_error(point);
    if (accept(attained + own + pad_)) return;
    own = std::min(own, detail::patch_deviation(h));
    const double upper = attained + own + pad_;
    if (settle(upper)) return;
    std::array<Vec3d, 3> bend;
    Points inner;  // in the middle of edge k; `bend` without the deviation of its ends
    for (int k = 0; k < 3; ++k) {
        bend[k] = detail::middle_deviation(h, k);
        inner[k] = halfway(point[k], point[next3(k)]);
        inner[k].deviation += bend[k];
    }
    if (attain_inner(inner, attained, own)) return;
    attain_centroid(point, detail::centroid_deviation(h, k_whole, bend[1]));
    if (rejected_ || settle(upper)) return;
    if (!may_split(depth)) {
        upper_ = std::max(upper_, upper);
        return;
    }
    const std::array<BoxSplineHessian, 4> quarter = h.quarters();
    bound_red(quarter[3], {inner[1], inner[2], inner[0]}, 0.25 * own, depth - 1);
    bound_red(quarter[0], {point[0], inner[0], inner[2]}, 0.25 * own, depth - 1);
    bound_red(quarter[1], {inner[0], point[1], inner[1]}, 0.25 * own, depth - 1);
    bound_red(quarter[2], {inner[2], inner[1], point[2]}, 0.25 * own, depth - 1);
}

void LoopBounder::bound_regular(const BoxSplineHessian& h, const Corners& at, const Points& point, double own,
                                int depth) {
    if (rejected_) return;
    if (const int parallel = detail::red_edge(at); parallel >= 0) {
        bound_red(detail::restricted(h, at, parallel), point, own, depth);
        return;
    }
    const double attained = largest_error(point);
    if (accept(attained + own + pad_)) return;
    const std::array<EdgeSecond, 3> edge = edge_seconds(h, at);
    own = std::min(own, detail::triangle_deviation(edge[0].bound, edge[1].bound, edge[2].bound));
    const double upper = attained + own + pad_;
    if (settle(upper)) return;
    std::array<Vec3d, 3> bend;
    Points inner;
    for (int k = 0; k < 3; ++k) {
        bend[k] = edge[k].middle_deviation(k);
        inner[k] = halfway(point[k], point[next3(k)]);
        inner[k].deviation += bend[k];
    }
    if (attain_inner(inner, attained, own)) return;
    attain_centroid(point, detail::centroid_deviation(h, at, bend[1]));
    if (rejected_ || settle(upper)) return;
    if (!may_split(depth)) {
        upper_ = std::max(upper_, upper);
        return;
    }
    std::array<Bary, 3> mid;
    for (int k = 0; k < 3; ++k) mid[k] = middle(at[k], at[next3(k)]);
    own *= 0.25;
    bound_regular(h, {mid[1], mid[2], mid[0]}, {inner[1], inner[2], inner[0]}, own, depth - 1);
    bound_regular(h, {at[0], mid[0], mid[2]}, {point[0], inner[0], inner[2]}, own, depth - 1);
    bound_regular(h, {mid[0], at[1], mid[1]}, {inner[0], point[1], inner[1]}, own, depth - 1);
    bound_regular(h, {mid[2], mid[1], at[2]}, {inner[2], inner[1], point[2]}, own, depth - 1);
}

Vec3d LoopBounder::corner_or_inner(const LoopCell& cell, const Bary& at) const {
    return is_corner(at) ? patches_.corner(cell, corner_of(at)) : patches_.position(cell, at);
}

/// A point of the surface with the parameters halfway between two.
LoopBounder::Point LoopBounder::surface_halfway(const Point& a, const Point& b, const Vec3d& surface) {
    Point p = halfway(a, b);
    p.deviation = surface - linear(p);
    attain(p);
    return p;
}

LeafError LoopBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSlack& slack) {
    decide_at_ = decide_at;
    stretch_ = 1;
    lower_ = upper_ = 0;
    splits_ = 0;
    rejected_ = false;
    Corners at;
    Level& level = locate(leaf, at);
    Points corner;
    corner[1].b1 = corner[2].b2 = 1;
    if (level.cell.kind == LoopCell::Kind::regular) {
        if (!level.has_hessian) {
            level.hessian = BoxSplineHessian(level.cell.net);
            level.patch_deviation = detail::patch_deviation(level.hessian);
            level.has_hessian = true;
        }
        const double size = detail::red_size(at), own = size * size * level.patch_deviation;
        if (size == 0 || !settle(own + pad_)) {
            std::array<Vec3d, 3> c;
            for (std::size_t i = 0; i < 3; ++i) c[i] = detail::BoxSplineLattice::position(level.cell.net, at[i]);
            set_leaf(c, slack);
            bound_regular(level.hessian, at, corner, size == 0 ? k_unknown : own, k_regular_refinement);
        }
    } else {
        std::array<Vec3d, 3> c;
        for (std::size_t i = 0; i < 3; ++i) c[i] = corner_or_inner(level.cell, at[i]);
        set_leaf(c, slack);
        bound_irregular(level.cell, {at, corner}, k_max_refinement);
    }
    if (rejected_) upper_ = std::numeric_limits<double>::infinity();
    return {stretch_ * lower_, stretch_ * std::max(upper_, lower_)};
}

void LoopBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals) {
    Corners at;
    const LoopCell& cell = locate(leaf, at).cell;
    const bool is_regular = cell.kind == LoopCell::Kind::regular;
    std::array<LoopCell, 4> quarters;  // of an irregular cell, as they are met
    std::array<bool, 4> is_known{};
    const auto position = [&](const Bary& b) {
        if (is_regular) return detail::BoxSplineLattice::position(cell.net, b);
        if (is_corner(b)) return patches_.corner(cell, corner_of(b));
        const int quarter = detail::quarter_of(b);
        LoopCell& child = quarters[static_cast<std::size_t>(quarter)];
        if (!std::exchange(is_known[static_cast<std::size_t>(quarter)], true)) patches_.child(cell, quarter, child);
        const Bary inside = detail::turned(detail::in_quarter(b, quarter), child.turn);
        return child.kind == LoopCell::Kind::regular ? detail::BoxSplineLattice::position(child.net, inside)
                                                     : corner_or_inner(child, inside);
    };
    const double unit = std::ldexp(1.0, -leaf.level), step = 1.0 / n;
    std::size_t out = 0;
    for (int row = 0; row <= n; ++row)  // distance from corner 2
        for (int i = 0; i <= row; ++i, ++out) {
            const double b0 = (row - i) * step, b1 = i * step, b2 = (n - row) * step;
            if (normals.empty()) {
                Bary b;
                for (std::size_t c = 0; c < 3; ++c) b[c] = b0 * at[0][c] + b1 * at[1][c] + b2 * at[2][c];
                positions[out] = position(b);
                continue;
            }
            const double x = (b0 * leaf.corner[0].x + b1 * leaf.corner[1].x + b2 * leaf.corner[2].x) * unit;
            const double y = (b0 * leaf.corner[0].y + b1 * leaf.corner[1].y + b2 * leaf.corner[2].y) * unit;
            const SurfacePoint p = patches_.tangents(leaf.root, x, y);
            positions[out] = p.position;
            normals[out] = glm::cross(p.du, p.dv);
        }
}

}  // namespace tetrakis
