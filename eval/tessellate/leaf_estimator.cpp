#include "leaf_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../bounds/plane_measure.hpp"
#include "../distance/local_maximum.hpp"
#include "patch_batches.hpp"
#include "sample_sheet.hpp"
#include "strip_samples.hpp"

#include <array>
#include <limits>
#include <optional>

namespace tetrakis {

namespace {

/// Intervals a side of a leaf's sample lattice: 15 points, three of them the corners.
constexpr int k_lattice = 4;
constexpr int k_samples = (k_lattice + 1) * (k_lattice + 2) / 2;

/// How far the surface is off the mesh of a leaf's samples, in units of how far it is off the leaf: a sixteenth where
/// its second derivatives are constant; twice that for where they are not.
constexpr double k_sheet_error = 1.0 / 8;

/// Share of the tolerance from which the largest sample is a start for one that is larger still.
constexpr double k_near = 0.8;

/// Lattice of a mapped leaf (target, displacement): nothing smooth can be assumed.
constexpr int k_mapped_bits = 3;
constexpr int k_mapped_lattice = 1 << k_mapped_bits;

/// Leaves of a mapped surface below this share of the tolerance are not split: there the map jumps.
constexpr double k_least_leaf = 1.0 / 32;

constexpr std::uint32_t k_estimator_grain = 2;  // one leaf may take as long as a hundred others

/// Number and barycentrics of lattice points: rows from corner 2 towards the edge corner 0 - corner 1.
template <class Visit>
void for_each_lattice_point(int n, Visit&& visit) {
    int index = 0;
    for (int row = 0; row <= n; ++row)
        for (int i = 0; i <= row; ++i, ++index)
            visit(index, static_cast<double>(row - i) / n, static_cast<double>(i) / n,
                  static_cast<double>(n - row) / n);
}

}  // namespace

template <class Family>
LeafEstimator<Family>::LeafEstimator(const SurfaceMap<Family>& map, const typename Family::Closest& closest,
                                     EstimatorKind kind, double tolerance)
    : map_(map), closest_(closest), kind_(kind), tolerance_(tolerance), bounders_([patches = map.patches] {
          return typename Family::Bounder(*patches);
      }) {}

template <class Family>
void LeafEstimator<Family>::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    detail::for_each_batch(map_.patches, static_cast<std::uint32_t>(triangles.size()), k_estimator_grain, {}, {}, 0, 1,
                           [&](std::uint32_t i) {
                               const CellTriangle& leaf = triangles[i];
                               if (!map_.plain()) {
                                   errors[i] = mapped(leaf);
                               } else if (kind_ == EstimatorKind::certified) {
                                   const LeafError e = bounder().leaf_error(leaf, tolerance_);
                                   errors[i] = e.lower > tolerance_ ? e.lower : e.upper;
                               } else {
                                   errors[i] = measured(leaf, bounder());
                               }
                           });
}

template <class Family>
std::array<bool, 3> LeafEstimator<Family>::soft_edges(const CellTriangle& leaf) const {
    const ControlMesh& mesh = map_.patches->mesh();
    return {!is_hard_edge<Family>(mesh, leaf, 0), !is_hard_edge<Family>(mesh, leaf, 1),
            !is_hard_edge<Family>(mesh, leaf, 2)};
}

template <class Family>
double LeafEstimator<Family>::measured(const CellTriangle& leaf, typename Family::Bounder& bounder) const {
    const QuickError quick = bounder.quick_error(leaf);
    const detail::PlaneMeasure plane(quick.corners);
    // The middle of the longest edge decides most leaves that must be split, and the bound most of those that need not.
    const double middle = plane.flat() ? std::abs(glm::dot(plane.normal(), quick.middle)) : glm::length(quick.middle);
    if (middle > tolerance_ && tolerance_ > 0) return middle;
    const LeafError bound = bounder.leaf_error(leaf, tolerance_);
    if (bound.upper <= tolerance_) return bound.upper;
    return -sampled(leaf, bounder, quick.corners, middle);
}

template <class Family>
double LeafEstimator<Family>::sampled(const CellTriangle& leaf, typename Family::Bounder& bounder,
                                      const std::array<Vec3d, 3>& corners, double middle) const {
    const detail::PlaneMeasure plane(corners);
    std::array<Vec3d, k_samples> s;
    bounder.sample(leaf, k_lattice, s, {});
    const Vec3d c2 = s[0], c0 = s[k_samples - 1 - k_lattice], c1 = s[k_samples - 1];
    double most_parametric = 0;
    detail::Maximum top;
    std::array<int, k_samples> doubtful;
    int doubtful_count = 0;
    for_each_lattice_point(k_lattice, [&](int i, double b0, double b1, double b2) {
        const Vec3d d = s[static_cast<std::size_t>(i)] - (b0 * c0 + b1 * c1 + b2 * c2);
        const double parametric = glm::length(d);
        if (parametric <= top.value) return;
        most_parametric = std::max(most_parametric, parametric);
        top.offer({b1, b2}, std::min(parametric, plane(s[static_cast<std::size_t>(i)])));
        if (parametric > tolerance_) doubtful[static_cast<std::size_t>(doubtful_count++)] = i;
    });
    double error = std::max(middle, top.value);
    for (std::size_t k = 0; k < 3; ++k) {
        if (!is_hard_edge<Family>(map_.patches->mesh(), leaf, k)) continue;
        const Vec3d ends[4] = {c0, c1, c2, c0};
        for_each_lattice_point(k_lattice, [&](int i, double b0, double b1, double b2) {
            const double across = k == 0 ? b2 : (k == 1 ? b0 : b1);
            if (across == 0)
                error = std::max(error, detail::segment_distance(s[static_cast<std::size_t>(i)], ends[k], ends[k + 1]));
        });
    }
    if (error > tolerance_) return error;
    const ControlMesh& mesh = map_.patches->mesh();
    if (top.value > k_near * tolerance_) {
        // Between the samples it may be farther.
        const auto distance = [&](const Vec2d& uv) {
            const double b0 = std::max(1 - uv.x - uv.y, 0.0);
            const Vec3d at = map_(Family::parameter(mesh, leaf, b0, uv.x, uv.y));
            return std::min(glm::length(at - (b0 * c0 + uv.x * c1 + uv.y * c2)), plane(at));
        };
        error = std::max(error, detail::local_maximum(distance, top, 0.5 / k_lattice).value);
        if (error > tolerance_) return error;
    }
    // The way back: from points of the triangle whose own sample has drifted away sideways.
    if (doubtful_count == 0) return std::max(error, measured_in_strips(leaf, corners, plane));
    std::optional<detail::SampleSheet<k_lattice>> sheet;
    if (plane.flat()) sheet.emplace(plane, s);
    const double bend = k_sheet_error * most_parametric;
    int next = 0;
    for_each_lattice_point(k_lattice, [&](int i, double b0, double b1, double b2) {
        if (next == doubtful_count || doubtful[static_cast<std::size_t>(next)] != i || error > tolerance_) return;
        ++next;
        // Most of the time other samples stand over and below it.
        if (sheet)
            if (const std::optional<double> height = sheet->height(b1, b2); height && *height + bend <= tolerance_) {
                error = std::max(error, *height);
                return;
            }
        const Vec3d q = b0 * c0 + b1 * c1 + b2 * c2;
        // Never above the deviation at q, so that refining ends it.
        const double back = closest_.local(q, Family::parameter(mesh, leaf, b0, b1, b2));
        error = std::max(error, back);
    });
    if (error > tolerance_) return error;
    return std::max(error, measured_in_strips(leaf, corners, plane));
}

template <class Family>
double LeafEstimator<Family>::measured_in_strips(const CellTriangle& leaf, const std::array<Vec3d, 3>& corners,
                                                 const detail::PlaneMeasure& plane) const {
    const ControlMesh& mesh = map_.patches->mesh();
    double error = 0;
    detail::for_each_strip_point<Family>(mesh, leaf, [&](double b0, double b1, double b2) {
        if (error > tolerance_) return;
        const SurfaceParameter at = Family::parameter(mesh, leaf, b0, b1, b2);
        const Vec3d s = map_(at), q = b0 * corners[0] + b1 * corners[1] + b2 * corners[2];
        const double parametric = glm::length(s - q);
        if (parametric <= error) return;
        error = std::max(error, std::min(parametric, plane(s)));
        if (parametric > tolerance_ && error <= tolerance_) error = std::max(error, closest_.local(q, at));
    });
    return error;
}

template <class Family>
double LeafEstimator<Family>::mapped(const CellTriangle& leaf) const {
    constexpr int n = k_mapped_lattice;
    constexpr int count = (n + 1) * (n + 2) / 2;
    const ControlMesh& mesh = map_.patches->mesh();
    std::array<Vec3d, count> s;
    std::array<detail::DisplacedSample, count> samples;
    for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        const auto at = static_cast<std::size_t>(i);
        samples[at] = map_.sample(Family::parameter(mesh, leaf, b0, b1, b2));
        s[at] = samples[at].position;
    });
    // On control edges the displacement may jump (UV seams, hard creases): there the one value that vertices get.
    if (map_.displacement) {
        const int level = leaf.level + k_mapped_bits;
        const auto& c = leaf.corner;
        const bool edge[3] = {Family::control_edge(mesh, leaf, 0).valid(), Family::control_edge(mesh, leaf, 1).valid(),
                              Family::control_edge(mesh, leaf, 2).valid()};
        for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
            const bool corner = b0 == 1 || b1 == 1 || b2 == 1;
            if (!corner && !(edge[0] && b2 == 0) && !(edge[1] && b0 == 0) && !(edge[2] && b1 == 0)) return;
            Site site;
            if (corner) {
                site = Family::corner_site(mesh, leaf, b0 == 1 ? 0 : (b1 == 1 ? 1 : 2));
            } else {
                if (level > k_max_level) return;
                const auto at = [&](std::uint32_t p0, std::uint32_t p1, std::uint32_t p2) {
                    return static_cast<std::uint32_t>(n * (b0 * p0 + b1 * p1 + b2 * p2));
                };
                site = Family::lattice_site(mesh, leaf.root, {at(c[0].x, c[1].x, c[2].x), at(c[0].y, c[1].y, c[2].y)},
                                            level);
            }
            s[static_cast<std::size_t>(i)] = map_.vertex(Family::canonical_site(mesh, site), nullptr);
        });
    }
    const Vec3d c2 = s[0], c0 = s[count - 1 - n], c1 = s[count - 1];
    const detail::PlaneMeasure plane({c0, c1, c2});
    std::array<Vec3d, 3> unmapped;
    for (std::size_t k = 0; k < 3; ++k) {
        const Site site = Family::corner_site(mesh, leaf, k);
        unmapped[k] = map_.patches->limit(site.root, site.at, site.level);
    }
    const double size = std::max({glm::length(unmapped[1] - unmapped[0]), glm::length(unmapped[2] - unmapped[1]),
                                  glm::length(unmapped[0] - unmapped[2])});
    double error = 0;
    for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        const Vec3d q = b0 * c0 + b1 * c1 + b2 * c2;
        const double parametric = glm::length(s[static_cast<std::size_t>(i)] - q);
        if (parametric > error) error = std::max(error, std::min(parametric, plane(s[static_cast<std::size_t>(i)])));
        if (map_.target && error <= tolerance_) {
            error = std::max(error, map_.target->closest(q).distance);
            if (plane.flat()) {
                // Rays along the normal see what the closest point misses: a groove or a spike right under the
                // triangle. The nearest hit counts, of either side: behind a thin part lies its other face.
                const double reach = 4 * tolerance_;
                double along = std::numeric_limits<double>::infinity();
                for (const Vec3d& way : {plane.normal(), -plane.normal()})
                    if (const RayHit hit = map_.target->intersect(q, way, 0, std::min(reach, along)); hit.found())
                        along = std::min(along, hit.t);
                if (along <= reach) error = std::max(error, along);
            }
        }
    });
    for (std::size_t k = 0; k < 3; ++k) {
        if (!is_hard_edge<Family>(map_.patches->mesh(), leaf, k)) continue;
        const Vec3d ends[4] = {c0, c1, c2, c0};
        for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
            const double across = k == 0 ? b2 : (k == 1 ? b0 : b1);
            if (across == 0)
                error = std::max(error, detail::segment_distance(s[static_cast<std::size_t>(i)], ends[k], ends[k + 1]));
        });
    }
    if (map_.has_detail() && (error <= tolerance_ || tolerance_ <= 0))
        error = detail::with_hidden_detail(*map_.heights, map_.amplitude, n, samples, error, tolerance_,
                                           [&](const Vec3d& p) { return plane(p); });
    if (error > tolerance_ && size < k_least_leaf * tolerance_) {
        gave_up_.store(true, std::memory_order_relaxed);
        return tolerance_;
    }
    return error;
}

template class LeafEstimator<QuadFamily>;
template class LeafEstimator<LoopFamily>;

}  // namespace tetrakis
