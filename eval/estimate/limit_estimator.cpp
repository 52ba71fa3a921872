#include "limit_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../distance/limit_samples.hpp"
#include "../surface/site_limits.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

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
        most = std::max(most, finite_sharpness_at<Family>(points.mesh(), triangle, k));
        longest = std::max(longest, glm::length(corner[k] - corner[(k + 1) % 3]));
    }
    const bool is_seen = triangle.level + k_limit_lattice_bits >= most + 1;
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
                    *out++ = lattice_site_of<Family>(points.mesh(), triangles[t], k_limit_lattice_bits, row, i);
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
        error = std::max(error, unseen_rounding<QuadFamily>(points, root, corners_of(roots[r])));
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

constexpr std::size_t k_leaves_at_once = 1u << 14;  // their sites take some 20 MB
constexpr std::size_t k_sqrt3_samples = 22, k_on_side = 4, k_inside = 15, k_edges = 16;

/// Sample points of a sqrt(3) cell, two lattice levels below its own: ninths of its corners. First the corners, then
/// four points a side. From k_inside on: the middle. From k_edges on: two points on each of three inner edges, from the
/// middle to the corners.
constexpr std::array<std::array<int, 3>, k_sqrt3_samples> k_ninths{
    {{9, 0, 0}, {0, 9, 0}, {0, 0, 9}, {6, 3, 0}, {5, 4, 0}, {4, 5, 0}, {3, 6, 0}, {0, 6, 3},
     {0, 5, 4}, {0, 4, 5}, {0, 3, 6}, {3, 0, 6}, {4, 0, 5}, {5, 0, 4}, {6, 0, 3}, {3, 3, 3},
     {7, 1, 1}, {5, 2, 2}, {1, 7, 1}, {2, 5, 2}, {1, 1, 7}, {2, 2, 5}}};
/// Those on inner edges of a cell whose first edge is cut: from the cut's points to the opposite corner.
constexpr std::array<std::array<int, 3>, 4> k_ninths_at_cut{{{2, 1, 6}, {4, 2, 3}, {1, 2, 6}, {2, 4, 3}}};

template <class Family>
double triangle_error(const Hierarchy& points, double tolerance, const CellTriangle& triangle, const LimitSamples& s) {
    const std::array<Vec3d, 3> corner = corners_of(s);
    const double most =
        farthest_sample(s, k_limit_lattice, PlaneMeasure(corner), hard_edges<Family>(points.mesh(), triangle)).value;
    double error = std::max(most, unseen_rounding<Family>(points, triangle, corner));
    if (tolerance > 0 && error > tolerance) return error;
    // Distances back; they are never above the distance to the sample, so that refinement ends.
    for_each_lattice_point(k_limit_lattice, [&](int i, double b0, double b1, double b2) {
        const Vec3d q = b0 * corner[0] + b1 * corner[1] + b2 * corner[2];
        const double parametric = glm::length(s[static_cast<std::size_t>(i)] - q);
        if (parametric > std::max(error, tolerance))
            error = std::max(error, std::min(parametric, distance_to_samples(q, s, most)));
    });
    return error;
}

template <class Family>
void triangle_errors(const Hierarchy& points, double tolerance, std::span<const CellTriangle> triangles,
                     std::span<double> errors) {
    const std::vector<LimitSamples> samples = samples_of<Family>(points, triangles);
    for_each_index(
        static_cast<std::uint32_t>(triangles.size()),
        [&](std::uint32_t t) { errors[t] = triangle_error<Family>(points, tolerance, triangles[t], samples[t]); },
        k_grain);
}

}  // namespace

void LimitEstimator::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    if (points_.family() == "triangles")
        triangle_errors<LoopFamily>(points_, tolerance_, triangles, errors);
    else
        triangle_errors<QuadFamily>(points_, tolerance_, triangles, errors);
}

void LimitEstimator::estimate_sqrt3(std::span<const Sqrt3Triangle> leaves, std::span<double> errors) const {
    std::vector<Sqrt3Cell> cells;
    std::vector<Site> sites;
    std::vector<Vec3d> limits;
    for (std::size_t begin = 0; begin < leaves.size(); begin += k_leaves_at_once) {
        const auto count = static_cast<std::uint32_t>(std::min(k_leaves_at_once, leaves.size() - begin));
        cells.resize(count);
        sites.resize(k_sqrt3_samples * count);
        limits.resize(sites.size());
        for_each_index(count, [&](std::uint32_t i) {
            cells[i] = lattice_->cell(leaves[begin + i]);
            const auto& [a, b, c] = cells[i].corner;
            for (std::size_t k = 0; k < k_sqrt3_samples; ++k) {
                // Half triangles have no samples on inner edges: the whole triangle that they become has them.
                const auto& w = k < k_edges              ? k_ninths[k]
                                : leaves[begin + i].half ? k_ninths[0]
                                : cells[i].cut           ? k_ninths_at_cut[k % 4]
                                                         : k_ninths[k];
                sites[k_sqrt3_samples * i + k] =
                    sqrt3_site(points_.mesh(), cells[i].root, w[0] * a + w[1] * b + w[2] * c, cells[i].lattice() + 2);
            }
        });
        limit_positions_once(points_, sites, limits);
        for_each_index(
            count,
            [&](std::uint32_t i) {
                const Sqrt3Triangle& leaf = leaves[begin + i];
                const Vec3d* const s = &limits[k_sqrt3_samples * i];
                const PlaneMeasure plane({s[0], s[1], s[2]});
                double error = 0;
                for (std::size_t side = 0; side < 3; ++side) {
                    const bool sharp =
                        lattice_->is_line(cells[i], side, cells[i].level - (leaf.half && side == 0 ? 1 : 0));
                    for (std::size_t k = 3 + k_on_side * side; k < 3 + k_on_side * (side + 1); ++k)
                        error =
                            std::max(error, sharp ? segment_distance(s[k], s[side], s[(side + 1) % 3]) : plane(s[k]));
                }
                for (std::size_t k = k_inside; k < k_sqrt3_samples; ++k) error = std::max(error, plane(s[k]));
                errors[begin + i] = error;
            },
            k_grain);
    }
}

void fan_limit_errors(const Hierarchy& points, const FanChoice& fans, std::span<const FaceId> faces,
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

}  // namespace tetrakis::detail
