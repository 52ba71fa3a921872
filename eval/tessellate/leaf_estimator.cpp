#include "leaf_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../distance/limit_samples.hpp"
#include "../triangles/point_triangle.hpp"
#include "measure.hpp"

#include <array>
#include <limits>
#include <vector>

namespace tetrakis::detail {

namespace {

/// Intervals a side of a leaf's sample lattice: 15 points, three of them the corners.
constexpr int k_lattice = 4;
constexpr int k_samples = lattice_points(k_lattice);

/// Finer sample lattice of a leaf with target or displacement, which need not be smooth.
constexpr int k_mapped_bits = 3;
constexpr int k_mapped_lattice = 1 << k_mapped_bits;

/// Leaves of a mapped surface below this share of the tolerance are not split: there the map jumps.
constexpr double k_least_leaf = 1.0 / 32;

/// Intervals a side of a root's sample lattice.
constexpr int k_fan_lattice = 6;

constexpr std::uint32_t k_estimator_grain = 2;  // one leaf may take as long as a hundred others

}  // namespace

template <class Family>
LeafEstimator<Family>::LeafEstimator(const SurfaceMap<Family>& map, EstimatorKind kind, double tolerance, bool compares)
    : map_(map), kind_(kind), tolerance_(tolerance), compares_(compares), bounders_([patches = map.patches] {
          return typename Family::Bounder(*patches);
      }) {}

template <class Family>
void LeafEstimator<Family>::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    std::vector<ErrorBasis> basis(triangles.size());
    estimate(triangles, errors, basis);
}

template <class Family>
void LeafEstimator<Family>::estimate(std::span<const CellTriangle> triangles, std::span<double> errors,
                                     std::span<ErrorBasis> basis) const {
    for_each_batch(map_.patches, static_cast<std::uint32_t>(triangles.size()), k_estimator_grain, {}, {}, 0, 1,
                   [&](std::uint32_t i) {
                       const CellTriangle& leaf = triangles[i];
                       basis[i] = ErrorBasis::bound;
                       if (!map_.plain()) {
                           errors[i] = mapped(leaf);
                           return;
                       }
                       const bool by_samples = kind_ == EstimatorKind::measured;
                       const LeafError bound = bounder().leaf_error(leaf, tolerance_, {}, by_samples || !compares_);
                       errors[i] = bound.upper;
                       if (bound.upper <= tolerance_) return;
                       if (by_samples) {
                           basis[i] = ErrorBasis::samples;
                           errors[i] = sampled(leaf);
                       } else if (!compares_ && bound.lower > tolerance_) {
                           errors[i] = bound.lower;
                       }
                   });
}

template <class Family>
double LeafEstimator<Family>::sampled(const CellTriangle& leaf) const {
    const ControlMesh& mesh = map_.patches->mesh();
    const auto at = [&](double b0, double b1, double b2) { return map_(Family::parameter(mesh, leaf, b0, b1, b2)); };
    const Vec3d c0 = at(1, 0, 0), c1 = at(0, 1, 0), c2 = at(0, 0, 1);
    const PlaneMeasure plane({c0, c1, c2});
    // Most leaves that must be split show it at these samples.
    constexpr std::array<Vec3d, 4> k_first{Vec3d(0.5, 0.5, 0), {0.5, 0.25, 0.25}, {0.25, 0.5, 0.25}, {0.25, 0.25, 0.5}};
    for (std::size_t i = 0; i < k_first.size() && !compares_; ++i) {
        const Vec3d &b = k_first[i], p = at(b.x, b.y, b.z);
        const double distance = std::min(glm::length(p - (b.x * c0 + b.y * c1 + b.z * c2)), plane(p));
        if (distance > tolerance_) return distance;
    }
    std::array<Vec3d, k_samples> s;
    for_each_lattice_point(
        k_lattice, [&](int i, double b0, double b1, double b2) { s[static_cast<std::size_t>(i)] = at(b0, b1, b2); });
    const Maximum top = farthest_sample(s, k_lattice, plane, hard_edges<Family>(mesh, leaf));
    double error = top.value;
    if (error > tolerance_) return error;
    if (top.value > k_climb_from * tolerance_) {
        // Between the samples the distance may be larger.
        const auto distance = [&](const Vec2d& uv) {
            const double b0 = std::max(1 - uv.x - uv.y, 0.0);
            const Vec3d p = at(b0, uv.x, uv.y);
            return std::min(glm::length(p - (b0 * c0 + uv.x * c1 + uv.y * c2)), plane(p));
        };
        error = std::max(error, local_maximum(distance, top, 0.5 / k_lattice).value);
        if (error > tolerance_) return error;
    }
    // Distances back to the surface, from points of the triangle that are far from their own sample. They are never
    // above the distance to that sample, which refining reduces; so refinement ends.
    const auto look_back = [&](double b0, double b1, double b2, const Vec3d& sample) {
        const Vec3d q = b0 * c0 + b1 * c1 + b2 * c2;
        if (error <= tolerance_ && glm::length(sample - q) > tolerance_)
            error = std::max(error, map_.nearby_distance(q, Family::parameter(mesh, leaf, b0, b1, b2)));
    };
    for_each_lattice_point(k_lattice, [&](int i, double b0, double b1, double b2) {
        look_back(b0, b1, b2, s[static_cast<std::size_t>(i)]);
    });
    // Distances in both directions near creases of finite sharpness, which the surface rounds off.
    for_each_strip_point<Family>(mesh, leaf, [&](double b0, double b1, double b2) {
        if (error > tolerance_) return;
        const Vec3d p = at(b0, b1, b2);
        error = std::max(error, std::min(glm::length(p - (b0 * c0 + b1 * c1 + b2 * c2)), plane(p)));
        look_back(b0, b1, b2, p);
    });
    return error;
}

template <class Family>
double LeafEstimator<Family>::mapped(const CellTriangle& leaf) const {
    constexpr int n = k_mapped_lattice;
    constexpr int count = lattice_points(n);
    const ControlMesh& mesh = map_.patches->mesh();
    std::array<Vec3d, count> s;
    std::array<DisplacedSample, count> samples;
    for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        const auto at = static_cast<std::size_t>(i);
        samples[at] = map_.sample(Family::parameter(mesh, leaf, b0, b1, b2));
        s[at] = samples[at].position;
    });
    // On control edges the displacement may jump (UV seams, hard creases): samples there take the vertices' value.
    if (map_.heights) {
        const bool edge[3] = {Family::control_edge(mesh, leaf, 0).valid(), Family::control_edge(mesh, leaf, 1).valid(),
                              Family::control_edge(mesh, leaf, 2).valid()};
        for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
            const bool corner = b0 == 1 || b1 == 1 || b2 == 1;
            if (!corner && !(edge[0] && b2 == 0) && !(edge[1] && b0 == 0) && !(edge[2] && b1 == 0)) return;
            if (!corner && leaf.level + k_mapped_bits > k_max_level) return;
            const Site site = corner
                                  ? Family::canonical_site(mesh, Family::corner_site(mesh, leaf,
                                                                                     b0 == 1   ? 0
                                                                                     : b1 == 1 ? 1
                                                                                               : 2))
                                  : lattice_site_of<Family>(mesh, leaf, k_mapped_bits, static_cast<int>(n * (b0 + b1)),
                                                            static_cast<int>(n * b1));
            s[static_cast<std::size_t>(i)] = map_.vertex(site);
        });
    }
    const Vec3d c2 = s[0], c0 = s[count - 1 - n], c1 = s[count - 1];
    const PlaneMeasure plane({c0, c1, c2});
    std::array<Vec3d, 3> unmapped;
    for (std::size_t k = 0; k < 3; ++k) {
        const Site site = Family::corner_site(mesh, leaf, k);
        unmapped[k] = map_.patches->limit(site.root, site.at, site.level);
    }
    const double size = std::max({glm::length(unmapped[1] - unmapped[0]), glm::length(unmapped[2] - unmapped[1]),
                                  glm::length(unmapped[0] - unmapped[2])});
    double error = farthest_sample(s, n, plane, hard_edges<Family>(mesh, leaf)).value;
    for_each_lattice_point(n, [&](int, double b0, double b1, double b2) {
        if (!map_.target || error > tolerance_) return;
        const Vec3d q = b0 * c0 + b1 * c1 + b2 * c2;
        error = std::max(error, map_.target->closest(q).distance);
        if (!plane.flat()) return;
        // Rays along the normal find grooves or spikes under the triangle, which closest points miss. Of both rays the
        // nearest hit counts: hits farther away may be on the other face of a thin part.
        const double reach = 4 * tolerance_;
        double along = std::numeric_limits<double>::infinity();
        for (const Vec3d& way : {plane.normal(), -plane.normal()})
            if (const RayHit hit = map_.target->intersect(q, way, 0, std::min(reach, along)); hit.found())
                along = std::min(along, hit.t);
        if (along <= reach) error = std::max(error, along);
    });
    if (map_.has_detail() && (error <= tolerance_ || tolerance_ <= 0))
        error = with_hidden_detail(*map_.ranges, map_.amplitude, n, samples, error, tolerance_,
                                   [&](const Vec3d& p) { return plane(p); });
    if (error > tolerance_ && size < k_least_leaf * tolerance_) {
        gave_up_.store(true, std::memory_order_relaxed);
        return tolerance_;
    }
    return error;
}

template class LeafEstimator<QuadFamily>;
template class LeafEstimator<LoopFamily>;

double FanError::certified(FaceId face, double decide_at, bool may_reject) const {
    const ControlMesh& mesh = map_.patches->mesh();
    const std::uint32_t n = mesh.face_size(face), h0 = mesh.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return positions_[mesh.origin(HalfedgeId(h0 + i)).value]; };
    const auto corner = [n](std::uint32_t i) { return polygon_corner(n, i); };
    // The point of the fan over the polygon's centre.
    Vec3d centre(0);
    double least = -std::numeric_limits<double>::infinity();
    for (const auto& t : fans_.of(face)) {
        const Vec2d a = corner(t[0]), b = corner(t[1]), c = corner(t[2]);
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
            const Vec2d p = corner(i), d = corner(j) - p;
            for (std::uint32_t s = 0; s < n; ++s) {
                const Vec2d spoke = corner(s);
                const double det = cross2(d, spoke);
                if (std::abs(det) < 1e-12) continue;
                const double along = cross2(spoke, p) / det, out = cross2(d, p) / det;  // p + along d = out spoke
                if (along < 0 || along > 1 || out < 0 || out > 1) continue;
                const Vec3d on_fan = (1 - along) * at(i) + along * at(j), on_star = (1 - out) * centre + out * at(s);
                departure = std::max(departure, glm::length(on_fan - on_star));
            }
        }
    const double left = std::max(decide_at - departure, 0.0);
    double error = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        error = std::max(error, estimator_.bounder().root_error(HalfedgeId(h0 + i), centre, left, may_reject).upper);
        // Other roots may have larger errors, so this one is no bound for the fan.
        if (may_reject && error > left) return std::numeric_limits<double>::infinity();
    }
    return error + departure;
}

double FanError::measured(FaceId face, double tolerance) const {
    const ControlMesh& mesh = map_.patches->mesh();
    const std::uint32_t n = mesh.face_size(face), h0 = mesh.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return positions_[mesh.origin(HalfedgeId(h0 + i)).value]; };
    if (map_.plain()) {
        const double bound = certified(face, tolerance, true);
        if (bound <= tolerance) return bound;
    }
    std::vector<PlaneMeasure> planes;
    for (const auto& t : fans_.of(face)) planes.emplace_back(std::array<Vec3d, 3>{at(t[0]), at(t[1]), at(t[2])});
    const auto to_fan = [&](const Vec3d& s) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& plane : planes) nearest = std::min(nearest, plane(s));
        return nearest;
    };
    double error = 0;
    // If errors are compared with each other, all samples of the fan are needed.
    const double enough = estimator_.compares() ? std::numeric_limits<double>::infinity() : tolerance;
    // The centre and the middles of the edges reject most fans that are above the tolerance.
    error = to_fan(map_({HalfedgeId(h0), 1, 1}));
    for (std::uint32_t r = 0; r < n && error <= enough; ++r)
        error = std::max(error, to_fan(map_({HalfedgeId(h0 + r), 1, 0})));
    for (std::uint32_t r = 0; r < n && error <= enough; ++r) {
        const HalfedgeId h(h0 + r);
        const CellTriangle root = root_triangle(h);
        const bool hard = is_hard_edge<QuadFamily>(mesh, root, 0);
        const Vec3d a = at(r), b = at((r + 1) % n);
        std::array<DisplacedSample, lattice_points(k_fan_lattice)> samples;
        for_each_lattice_point(k_fan_lattice, [&](int i, double b0, double b1, double b2) {
            auto& sample = samples[static_cast<std::size_t>(i)];
            sample = map_.sample(QuadFamily::parameter(mesh, root, b0, b1, b2));
            error = std::max(error, to_fan(sample.position));
            if (b2 == 0 && hard) error = std::max(error, segment_distance(sample.position, a, b));
        });
        if (map_.has_detail() && error <= enough)
            error = with_hidden_detail(*map_.ranges, map_.amplitude, k_fan_lattice, samples, error, tolerance, to_fan);
    }
    if (error <= enough && map_.target) {
        for (const auto& t : fans_.of(face))
            for_each_lattice_point(k_fan_lattice, [&](int, double b0, double b1, double b2) {
                const Vec3d q = b0 * at(t[0]) + b1 * at(t[1]) + b2 * at(t[2]);
                error = std::max(error, map_.target->closest(q).distance);
            });
    }
    return error;
}

}  // namespace tetrakis::detail
