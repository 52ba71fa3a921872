#include "fan_limit_error.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/site_limits.hpp"
#include "limit_estimator.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

CellTriangle root_triangle(HalfedgeId h) { return {h, 0, {LatticePoint{0, 0}, {2, 0}, {1, 1}}}; }

double fan_error(const ControlMesh& mesh, FaceId face, std::span<const std::array<std::uint8_t, 3>> fan,
                 std::span<const Vec3d> corner_positions, std::span<const LimitSamples> roots) {
    const std::uint32_t size = mesh.face_size(face), h0 = mesh.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return corner_positions[mesh.origin(HalfedgeId(h0 + i)).value]; };
    std::vector<PlaneMeasure> planes;
    for (const auto& t : fan) planes.emplace_back(std::array<Vec3d, 3>{at(t[0]), at(t[1]), at(t[2])});
    double error = 0;
    for (std::uint32_t r = 0; r < size; ++r) {
        const bool hard = is_hard_edge<QuadFamily>(mesh, root_triangle(HalfedgeId(h0 + r)), 0);
        for (std::size_t i = 0; i < roots[r].size(); ++i) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const PlaneMeasure& plane : planes) nearest = std::min(nearest, plane(roots[r][i]));
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
            for (const LimitSamples& s : roots) nearest = std::min(nearest, distance_to_samples(q, s, 0));
            error = std::max(error, nearest);
        }
    }
    return error;
}

}  // namespace

std::vector<double> fan_limit_errors(const Hierarchy& points, const FanChoice& fans,
                                     std::span<const Vec3d> corner_positions, const RunContext& context) {
    const ControlMesh& mesh = points.mesh();
    std::vector<double> errors(mesh.face_count(), 0.0);
    constexpr std::size_t k_roots = 8192;  // evaluated together
    std::vector<FaceId> faces;
    std::vector<std::uint32_t> first;  // per face: its first root's number in `sites`
    std::vector<Site> sites;
    std::vector<Vec3d> positions;
    for (std::uint32_t f = 0; f < mesh.face_count();) {
        context.report("coarsest", static_cast<double>(f) / mesh.face_count());
        faces.clear();
        first.clear();
        sites.clear();
        for (; f < mesh.face_count() && sites.size() < k_roots * k_limit_samples; ++f) {
            if (!fans.has(FaceId(f))) continue;
            faces.push_back(FaceId(f));
            first.push_back(static_cast<std::uint32_t>(sites.size() / k_limit_samples));
            const std::uint32_t h0 = mesh.face_halfedge(FaceId(f)).value;
            for (std::uint32_t r = 0; r < mesh.face_size(FaceId(f)); ++r)
                for (int row = 0; row <= k_limit_lattice; ++row)
                    for (int i = 0; i <= row; ++i)
                        sites.push_back(lattice_site_of<QuadFamily>(mesh, root_triangle(HalfedgeId(h0 + r)),
                                                                    k_limit_lattice_bits, row, i));
        }
        positions.resize(sites.size());
        limit_positions_once(points, sites, positions, [](double) {});
        for_each_index(
            static_cast<std::uint32_t>(faces.size()),
            [&](std::uint32_t k) {
                std::vector<LimitSamples> roots(mesh.face_size(faces[k]));
                for (std::size_t r = 0; r < roots.size(); ++r)
                    std::copy_n(positions.begin() + static_cast<std::ptrdiff_t>((first[k] + r) * k_limit_samples),
                                k_limit_samples, roots[r].begin());
                errors[faces[k].value] = fan_error(mesh, faces[k], fans.of(faces[k]), corner_positions, roots);
            },
            16);
    }
    return errors;
}

}  // namespace tetrakis::detail
