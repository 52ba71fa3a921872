#include "fan_error.hpp"

#include "../distance/limit_samples.hpp"
#include "../triangles/point_triangle.hpp"

#include <limits>
#include <numbers>

namespace tetrakis {

namespace {

/// Intervals a side of a root's sample lattice.
constexpr int k_fan_lattice = 6;

struct Polygon {
    std::uint32_t n;
    Vec2d corner(std::uint32_t i) const {
        const double angle = 2 * std::numbers::pi * (i % n) / n;
        return {std::cos(angle), std::sin(angle)};
    }
};

double cross2(const Vec2d& a, const Vec2d& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

double FanError::certified(FaceId face, double decide_at, bool may_reject) const {
    const ControlMesh& mesh = map_.patches->mesh();
    const std::uint32_t n = mesh.face_size(face), h0 = mesh.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return positions_[mesh.origin(HalfedgeId(h0 + i)).value]; };
    const Polygon polygon{n};
    // The fan's point over the polygon's centre.
    Vec3d centre(0);
    double least = -std::numeric_limits<double>::infinity();
    for (const auto& t : fans_.of(face)) {
        const Vec2d a = polygon.corner(t[0]), b = polygon.corner(t[1]), c = polygon.corner(t[2]);
        const double det = cross2(b - a, c - a);
        const double wb = cross2(-a, c - a) / det, wc = cross2(b - a, -a) / det, wa = 1 - wb - wc;
        if (std::min({wa, wb, wc}) > least) {
            least = std::min({wa, wb, wc});
            centre = wa * at(t[0]) + wb * at(t[1]) + wc * at(t[2]);
        }
    }
    // Star against fan: both are piecewise linear over the polygon, so the difference is largest where a spoke meets a
    // diagonal.
    double departure = 0;
    for (const auto& t : fans_.of(face))
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t i = t[k], j = t[(k + 1) % 3];
            if ((i + 1) % n == j || (j + 1) % n == i) continue;
            const Vec2d p = polygon.corner(i), d = polygon.corner(j) - p;
            for (std::uint32_t s = 0; s < n; ++s) {
                const Vec2d spoke = polygon.corner(s);
                const double det = cross2(d, spoke);
                if (std::abs(det) < 1e-12) continue;
                const double along = cross2(spoke, p) / det, out = cross2(d, p) / det;  // p + along d = out spoke
                if (along < 0 || along > 1 || out < 0 || out > 1) continue;
                const Vec3d on_fan = (1 - along) * at(i) + along * at(j), on_star = (1 - out) * centre + out * at(s);
                departure = std::max(departure, glm::length(on_fan - on_star));
            }
        }
    const double left = std::max(decide_at - departure, 0.0);
    constexpr double k_rejected = std::numeric_limits<double>::infinity();
    if (may_reject) {
        // The face's centre decides most fans that do not hold, its edges' middles most others.
        const HalfedgeId first(h0);
        if (departure > decide_at || glm::length(map_.patches->limit(first, {1, 1}, 0) - centre) > left)
            return k_rejected;
        for (std::uint32_t i = 0; i < n; ++i)
            if (glm::length(map_.patches->limit(HalfedgeId(h0 + i), {1, 0}, 0) - 0.5 * (at(i) + at((i + 1) % n))) >
                left)
                return k_rejected;
    }
    double error = 0;
    for (std::uint32_t i = 0; i < n && (error <= left || !may_reject); ++i)
        error = std::max(error, estimator_.bounder().root_error(HalfedgeId(h0 + i), centre, left, may_reject).upper);
    return error + departure;
}

FanError::Estimate FanError::measured(FaceId face, double tolerance) const {
    const ControlMesh& mesh = map_.patches->mesh();
    const std::uint32_t n = mesh.face_size(face), h0 = mesh.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return positions_[mesh.origin(HalfedgeId(h0 + i)).value]; };
    if (map_.plain()) {
        // The centre of the face decides most fans that do not hold.
        const double bound = certified(face, tolerance, true);
        if (bound <= tolerance) return {bound, ErrorBasis::bound};
    }
    std::vector<detail::PlaneMeasure> planes;
    for (const auto& t : fans_.of(face)) planes.emplace_back(std::array<Vec3d, 3>{at(t[0]), at(t[1]), at(t[2])});
    const auto to_fan = [&](const Vec3d& s) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& plane : planes) nearest = std::min(nearest, plane(s));
        return nearest;
    };
    double error = 0;
    // Without a tolerance (a budget alone) errors are compared with each other: all of the fan counts.
    const double enough = tolerance > 0 ? tolerance : std::numeric_limits<double>::infinity();
    // The centre and the middles of the edges decide most fans that do not hold.
    error = to_fan(map_({HalfedgeId(h0), 1, 1}));
    for (std::uint32_t r = 0; r < n && error <= enough; ++r)
        error = std::max(error, to_fan(map_({HalfedgeId(h0 + r), 1, 0})));
    for (std::uint32_t r = 0; r < n && error <= enough; ++r) {
        const HalfedgeId h(h0 + r);
        const CellTriangle root = root_triangle(h);
        const bool hard = is_hard_edge<QuadFamily>(mesh, root, 0);
        const Vec3d a = at(r), b = at((r + 1) % n);
        std::array<detail::DisplacedSample, detail::lattice_points(k_fan_lattice)> samples;
        detail::for_each_lattice_point(k_fan_lattice, [&](int i, double b0, double b1, double b2) {
            auto& sample = samples[static_cast<std::size_t>(i)];
            sample = map_.sample(QuadFamily::parameter(mesh, root, b0, b1, b2));
            error = std::max(error, to_fan(sample.position));
            if (b2 == 0 && hard) error = std::max(error, detail::segment_distance(sample.position, a, b));
        });
        if (map_.has_detail() && error <= enough)
            error = detail::with_hidden_detail(*map_.heights, map_.amplitude, k_fan_lattice, samples, error, tolerance,
                                               to_fan);
    }
    if (error <= enough && map_.target) {
        for (const auto& t : fans_.of(face))
            detail::for_each_lattice_point(k_fan_lattice, [&](int, double b0, double b1, double b2) {
                const Vec3d q = b0 * at(t[0]) + b1 * at(t[1]) + b2 * at(t[2]);
                error = std::max(error, map_.target->closest(q).distance);
            });
    }
    return {error, ErrorBasis::samples};
}

}  // namespace tetrakis
