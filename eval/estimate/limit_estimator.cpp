#include "limit_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/site_limits.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

using detail::distance_to_samples;
using detail::farthest_sample;
using detail::for_each_lattice_point;
using detail::k_limit_lattice;
using detail::k_limit_lattice_bits;
using detail::k_limit_samples;
using detail::lattice_index;
using detail::limit_positions_once;
using detail::LimitSamples;
using detail::PlaneMeasure;
using detail::segment_distance;

namespace {

constexpr std::uint32_t k_grain = 64;

/// Error that a rounding too small for the triangle's lattice may cause. An edge or vertex of finite sharpness s is
/// rounded within 2^-s of the width of the control faces there. 0 if the lattice has points in the rounding, and for
/// schemes that do not round.
template <class Family>
double unseen_rounding(const Hierarchy& points, const CellTriangle& triangle, const std::array<Vec3d, 3>& corner) {
    constexpr double k_off = 0.25;  // error as a share of the rounded width: a cubic B-spline at a right angle
    double most = 0, longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        most = std::max(most, detail::finite_sharpness_at<Family>(points.mesh(), triangle, k));
        longest = std::max(longest, glm::length(corner[k] - corner[(k + 1) % 3]));
    }
    const bool is_seen = triangle.level + detail::k_limit_lattice_bits >= most + 1;
    return is_seen || points.scheme().is_linear() ? 0 : k_off * longest * std::exp2(triangle.level - most);
}

/// The limit points over triangles.
template <class Family>
std::vector<LimitSamples> samples_of(const Hierarchy& points, std::span<const CellTriangle> triangles) {
    std::vector<Site> sites(k_limit_samples * triangles.size());
    for_each_index(
        static_cast<std::uint32_t>(triangles.size()),
        [&](std::uint32_t t) {
            Site* out = &sites[std::size_t{k_limit_samples} * t];
            for (int row = 0; row <= k_limit_lattice; ++row)
                for (int i = 0; i <= row; ++i)
                    *out++ = detail::lattice_site_of<Family>(points.mesh(), triangles[t], k_limit_lattice_bits, row, i);
        },
        k_grain);
    std::vector<LimitSamples> samples(triangles.size());
    if (!samples.empty()) limit_positions_once(points, sites, {samples.front().data(), sites.size()});
    return samples;
}

double fan_error(const Hierarchy& points, FaceId face, std::span<const std::array<std::uint8_t, 3>> fan,
                 std::span<const Vec3d> corner_positions, std::span<const LimitSamples> roots) {
    const ControlMesh& mesh = points.mesh();
    const std::uint32_t size = mesh.face_size(face), h0 = mesh.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return corner_positions[mesh.origin(HalfedgeId(h0 + i)).value]; };
    std::vector<PlaneMeasure> planes;
    for (const auto& t : fan) planes.emplace_back(std::array<Vec3d, 3>{at(t[0]), at(t[1]), at(t[2])});
    // The search for a point's nearest triangle stops early once its distance is within the error so far.
    double error = 0;
    for (std::uint32_t r = 0; r < size; ++r) {
        const CellTriangle root = root_triangle(HalfedgeId(h0 + r));
        const bool hard = is_hard_edge<QuadFamily>(mesh, root, 0);
        error = std::max(error, unseen_rounding<QuadFamily>(points, root, detail::corners_of(roots[r])));
        for (std::size_t i = 0; i < roots[r].size(); ++i) {
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < planes.size() && nearest > error; ++k)
                nearest = std::min(nearest, planes[k](roots[r][i]));
            error = std::max(error, nearest);
            if (hard && i >= static_cast<std::size_t>(lattice_index(k_limit_lattice, 0)))
                error = std::max(error, segment_distance(roots[r][i], at(r), at((r + 1) % size)));
        }
    }
    // Back from the middles of the fan's edges and triangles.
    for (const auto& t : fan) {
        const Vec3d a = at(t[0]), b = at(t[1]), c = at(t[2]);
        for (const Vec3d& q : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0}) {
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < roots.size() && nearest > error; ++k)
                nearest = std::min(nearest, distance_to_samples(q, roots[k], 0));
            error = std::max(error, nearest);
        }
    }
    return error;
}

}  // namespace

template <class Family>
double LimitEstimator<Family>::of_samples(const CellTriangle& triangle, const LimitSamples& s) const {
    const std::array<Vec3d, 3> corner = detail::corners_of(s);
    const double most =
        farthest_sample(s, k_limit_lattice, PlaneMeasure(corner), hard_edges<Family>(points_.mesh(), triangle)).value;
    double error = std::max(most, unseen_rounding<Family>(points_, triangle, corner));
    if (tolerance_ > 0 && error > tolerance_) return error;
    // Distances back; they are never above the distance to the sample, so that refinement ends.
    for_each_lattice_point(k_limit_lattice, [&](int i, double b0, double b1, double b2) {
        const Vec3d q = b0 * corner[0] + b1 * corner[1] + b2 * corner[2];
        const double parametric = glm::length(s[static_cast<std::size_t>(i)] - q);
        if (parametric > std::max(error, tolerance_))
            error = std::max(error, std::min(parametric, distance_to_samples(q, s, most)));
    });
    return error;
}

template <class Family>
void LimitEstimator<Family>::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    const std::vector<LimitSamples> samples = samples_of<Family>(points_, triangles);
    for_each_index(
        static_cast<std::uint32_t>(triangles.size()),
        [&](std::uint32_t t) { errors[t] = of_samples(triangles[t], samples[t]); }, k_grain);
}

void detail::fan_limit_errors(const Hierarchy& points, const FanChoice& fans, std::span<const FaceId> faces,
                              std::span<const Vec3d> corners, std::span<double> errors) {
    const ControlMesh& mesh = points.mesh();
    std::vector<std::size_t> first;  // per face: the number of its first root
    std::vector<CellTriangle> roots;
    for (const FaceId face : faces) {
        first.push_back(roots.size());
        for (std::uint32_t r = 0; r < mesh.face_size(face); ++r)
            roots.push_back(root_triangle(HalfedgeId(mesh.face_halfedge(face).value + r)));
    }
    const std::vector<LimitSamples> samples = samples_of<QuadFamily>(points, roots);
    for_each_index(
        static_cast<std::uint32_t>(faces.size()),
        [&](std::uint32_t i) {
            errors[i] = fan_error(points, faces[i], fans.of(faces[i]), corners,
                                  std::span(samples).subspan(first[i], mesh.face_size(faces[i])));
        },
        16);
}

template class LimitEstimator<QuadFamily>;
template class LimitEstimator<LoopFamily>;

}  // namespace tetrakis
