#include "star_pieces.hpp"

#include "bezier_pieces.hpp"

#include <glm/matrix.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <initializer_list>
#include <numbers>

namespace tetrakis::detail {

namespace {

constexpr double k_rounding_of_sums = 1 + 1e-12;  // of some dozens of points
constexpr int k_steps = 7;                        // to the innermost star

using Corners = std::array<Vec2d, 3>;

struct ControlPoint {
    Vec3d point;
    Vec2d at;  ///< its parameters in the whole cell
};

const Net16& net_in(const QuadShape::Patch& patch) { return patch.net; }
const Net12& net_in(const Net12& net) { return net; }

/// Calls take(p, q) with control points p of the surface over a part of a cell, and their parameters q: those of its
/// polynomials, and of the hulls of the innermost stars. For any affine function f, the convex hull of all p - f(q)
/// contains the surface minus f.
/// @param origin, scale  parameters of the point at p in the cell: origin + scale p
template <class Shape, class Take>
void take_cell(const PatchNode<Shape>& cell, const LabelledPolygon& part, const Vec2d& origin, double scale, int step,
               const Take& take) {
    constexpr int n = Shape::k_corners, k_degree = StarPieces<Shape>::k_degree;
    const auto parameters = [&](const Vec2d& p) { return origin + scale * p; };
    if (cell.kind == PatchNode<Shape>::Kind::regular) {
        part.for_each_triangle([&](const LabelledTriangle& t) {
            const auto polynomial = polynomial_over(net_in(cell.patch), t.at);
            for (int j = 0; j <= k_degree; ++j)
                for (int i = 0; i + j <= k_degree; ++i)
                    take(polynomial(i, j),
                         parameters((double(k_degree - i - j) * t.at[0] + double(i) * t.at[1] + double(j) * t.at[2]) /
                                    double(k_degree)));
        });
    } else if (step == k_steps) {
        for (const Vec3d& p : cell.star->points)
            for (std::size_t i = 0; i < part.size(); ++i) take(p, parameters(part.corner(i)));
    } else {
        for (int k = 0; k < 4; ++k)
            if (const LabelledPolygon below = in_quarter(part, k, n); !below.empty())
                take_cell(cell.grown()[k], below, parameters(0.5 * (k < n ? cell_corner(k, n) : Vec2d(1))),
                          scale * (k < n ? 0.5 : -0.5), step + 1, take);
    }
}

Vec2d polar(double radius, double angle) { return radius * Vec2d(std::cos(angle), std::sin(angle)); }

/// A flat star with equal angles at the extraordinary vertex; the outer faces continue the faces there.
template <int Corners>
std::vector<Vec2d> reference_star(int valence) {
    const double angle = 2 * std::numbers::pi / valence;
    std::vector<Vec2d> points = {Vec2d(0)};
    for (int i = 0; i < valence; ++i) {
        points.push_back(polar(1, i * angle));
        if (Corners == 4) points.push_back(polar(std::cos(angle / 2) + std::sin(angle / 2), (i + 0.5) * angle));
    }
    const auto add = [&](std::initializer_list<Vec2d> beyond) { points.insert(points.end(), beyond); };
    const Vec2d before = points.back(), a = points[1], b = points[2], c = points[3];
    if (Corners == 4)
        add({a + before, 2.0 * a, a + b, 2.0 * b, b + c, 2.0 * c, c + Vec2d(points[4])});
    else
        add({a + before, 2.0 * a, a + b, 2.0 * b, b + c});
    return points;
}

}  // namespace

template <class Shape>
StarPieces<Shape>::StarPieces(int valence, const Corners& at)
    : at_(at), reference_(reference_star<Shape::k_corners>(valence)) {
    constexpr int n = Shape::k_corners;
    const std::size_t count = reference_.size();
    // The affine map fits the reference star to a star by least squares.
    glm::dmat3 normal(0);
    for (const Vec2d& p : reference_) normal += glm::outerProduct(Vec3d(1, p.x, p.y), Vec3d(1, p.x, p.y));
    for (const Vec2d& p : reference_) fit_.push_back(glm::inverse(normal) * Vec3d(1, p.x, p.y));

    // The last star is the reference. In those before, the three coordinates are the weights of three points.
    for (std::size_t first = 0; first < count + 3; first += 3) {
        const bool is_reference = first >= count;
        Star<n> star;
        star.resize(star.with_first(valence));
        for (std::size_t i = 0; i < count; ++i)
            star.points[i] = is_reference ? Vec3d(reference_[i], 0) : Vec3d(i == first, i == first + 1, i == first + 2);
        std::atomic<std::uint64_t> bytes;
        PatchNode<Shape> cell;
        cell.bytes = &bytes;
        cell.become(std::move(star), 0);
        // Notes the weights in a polynomial's control points.
        const auto note_weights = [&](auto& weights, const auto& polynomial) {
            weights.resize(count);
            for (std::size_t k = 0; k < 3 && first + k < count; ++k) weights[first + k] = polynomial.c[k];
        };
        const auto linear = [](const PatchNode<Shape>& of, const Corners& corners) {
            BezierTriangle<1> result;
            result.set(0, 0, PatchTree<Shape>::position(of, corners[0]));
            result.set(1, 0, PatchTree<Shape>::position(of, corners[1]));
            result.set(0, 1, PatchTree<Shape>::position(of, corners[2]));
            return result;
        };
        // Raises norms of S - L over the triangle of these parameters.
        const auto raise = [&](Norms& norms, const Corners& corners, const BezierTriangle<1>& l,
                               std::span<const ControlPoint> of) {
            const glm::dmat2 to_bary = glm::inverse(glm::dmat2(corners[1] - corners[0], corners[2] - corners[0]));
            const auto note = [](double& most, double size) { most = std::max(most, size * k_rounding_of_sums); };
            norms.of_point.resize(count);
            for (const auto& [p, q] : of) {
                const Vec2d b = to_bary * (q - corners[0]);
                const Vec3d d = p - (l[0] + b.x * (l[1] - l[0]) + b.y * (l[2] - l[0]));
                if (is_reference) note(norms.of_reference, glm::length(d));
                for (std::size_t k = 0; k < 3 && first + k < count; ++k)
                    note(norms.of_point[first + k], std::abs(d[static_cast<int>(k)]));
            }
        };
        std::vector<ControlPoint> all;
        std::size_t regulars = 0, inners = 0;
        for (int k = 0; k < 4; ++k)
            in_quarter(LabelledTriangle{at, {0, 1, 2}}, k, n).for_each_triangle([&](const LabelledTriangle& t) {
                const PatchNode<Shape>& quarter = cell.grown()[k];
                const std::size_t before = all.size();
                take_cell(quarter, LabelledPolygon(t), 0.5 * (k < n ? cell_corner(k, n) : Vec2d(1)), k < n ? 0.5 : -0.5,
                          1, [&](const Vec3d& p, const Vec2d& q) {
                              all.push_back({p, q});
                          });
                if (quarter.kind == PatchNode<Shape>::Kind::regular) {
                    if (first == 0) regular.push_back({t.edge, {}});
                    note_weights(regular[regulars++].weights, polynomial_over(net_in(quarter.patch), t.at));
                } else {
                    if (first == 0) inner.push_back({t, {}, {}});
                    InnerPart& part = inner[inners++];
                    const BezierTriangle<1> corners = linear(quarter, t.at);
                    note_weights(part.corners, corners);
                    raise(part.norms, {0.5 * t.at[0], 0.5 * t.at[1], 0.5 * t.at[2]}, corners,
                          std::span(all).subspan(before));
                }
            });
        raise(whole, at, linear(cell, at), all);
    }
}

template <class Shape>
auto StarPieces<Shape>::of(const Star<Shape::k_corners>& star, const Corners& at) -> const StarPieces* {
    static std::array<std::atomic<const StarPieces*>, k_most_valence + 1> known;
    const int valence = star.valence[0];
    const bool known_kind = star.valence == star.with_first(valence) && !star.regular() && valence <= k_most_valence;
    if (!known_kind || !is_common(at)) return nullptr;
    std::atomic<const StarPieces*>& first = known[static_cast<std::size_t>(valence)];
    for (const StarPieces* pieces = first.load(std::memory_order_acquire); pieces; pieces = pieces->next_)
        if (pieces->at_ == at) return pieces;
    // If two threads come here at once, both results are kept; they are the same.
    auto* const pieces = new StarPieces(valence, at);
    pieces->next_ = first.load(std::memory_order_acquire);
    while (!first.compare_exchange_weak(pieces->next_, pieces, std::memory_order_acq_rel)) {
    }
    return pieces;
}

template <class Shape>
auto StarPieces<Shape>::fit(Points points) const -> Fit {
    Vec3d at(0), x(0), y(0);
    for (std::size_t i = 0; i < fit_.size(); ++i) {
        at += fit_[i].x * points[i];
        x += fit_[i].y * points[i];
        y += fit_[i].z * points[i];
    }
    // The affine map stretches lengths at most by the larger singular value of its matrix.
    const double xx = glm::dot(x, x), yy = glm::dot(y, y), xy = glm::dot(x, y);
    Fit result;
    result.stretch = std::sqrt(0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy));
    for (std::size_t i = 0; i < fit_.size(); ++i)
        result.remainder[i] = glm::length(points[i] - (at + reference_[i].x * x + reference_[i].y * y));
    return result;
}

template <class Shape>
double StarPieces<Shape>::Norms::deviation(const Fit& of) const {
    double sum = of.stretch * of_reference;
    for (std::size_t i = 0; i < of_point.size(); ++i) sum += of_point[i] * of.remainder[i];
    return sum * k_rounding_of_sums;
}

template class StarPieces<QuadShape>;
template class StarPieces<LoopShape>;

}  // namespace tetrakis::detail
