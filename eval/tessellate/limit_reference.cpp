#include "limit_reference.hpp"

#include "../../hier/base/parallel.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../surface/site_limits.hpp"

#include <algorithm>
#include <string>

namespace tetrakis::detail {

namespace {

constexpr std::size_t k_wanted_triangles = 60'000;
constexpr std::size_t k_many_pieces = 250'000;
constexpr int k_most_bits = 4;

/// Mesh, search hierarchy and what is needed to number the vertices, per triangle of a reference.
constexpr std::uint64_t k_reference_bytes = 120;

}  // namespace

int reference_bits(std::size_t pieces, int deepest_lattice_level) {
    int bits = pieces > k_many_pieces ? 1 : 2;
    while (bits < k_most_bits && pieces << (2 * bits) < k_wanted_triangles) ++bits;
    return std::min(bits, k_max_level - deepest_lattice_level);
}

void check_reference_memory(std::uint64_t triangles, const RunContext& context) {
    const std::uint64_t bytes = triangles * k_reference_bytes;
    if (context.max_memory_bytes == 0 || bytes <= context.max_memory_bytes) return;
    throw Error(ErrorCode::memory_limit,
                "measuring the result against a mesh of " + std::to_string(triangles) + " triangles needs about " +
                    std::to_string(bytes >> 20) + " MiB, and the limit is " +
                    std::to_string(context.max_memory_bytes >> 20) + " MiB; use a larger limit, or do not measure");
}

template <class Family>
LimitReference limit_reference(const Hierarchy& points, std::span<const CellTriangle> pieces, int bits,
                               const RunContext& context, double share) {
    const int n = 1 << bits;
    const auto per_piece = static_cast<std::size_t>(lattice_points(n));
    check_reference_memory(std::uint64_t{pieces.size()} << (2 * bits), context);
    std::vector<Site> sites(pieces.size() * per_piece);
    for_each_index(
        static_cast<std::uint32_t>(pieces.size()),
        [&](std::uint32_t p) {
            for (int row = 0; row <= n; ++row)
                for (int i = 0; i <= row; ++i)
                    sites[p * per_piece + static_cast<std::size_t>(lattice_index(row, i))] =
                        lattice_site_of<Family>(points.mesh(), pieces[p], bits, row, i);
        },
        64);
    const DistinctSites once(sites);
    LimitReference reference;
    reference.mesh.positions.resize(once.distinct().size());
    limit_positions(points, once.distinct(), reference.mesh.positions,
                    [&](double done) { context.report("measure", share * done); });
    for (std::uint32_t p = 0; p < pieces.size(); ++p) {
        const auto vertex = [&](int row, int i) {
            return once.number()[p * per_piece + static_cast<std::size_t>(lattice_index(row, i))];
        };
        for (int row = 0; row < n; ++row)
            for (int i = 0; i <= row; ++i) {
                reference.mesh.triangles.push_back({vertex(row, i), vertex(row + 1, i), vertex(row + 1, i + 1)});
                reference.owner.push_back(p);
                if (i == row) continue;
                reference.mesh.triangles.push_back({vertex(row, i), vertex(row + 1, i + 1), vertex(row, i + 1)});
                reference.owner.push_back(p);
            }
    }
    return reference;
}

ReferenceDistances measure_reference(const LimitReference& reference, std::size_t pieces, const TriangleMesh& mesh,
                                     std::uint64_t samples, const RunContext& context) {
    ReferenceDistances result;
    result.of_piece.assign(pieces, 0.0f);
    result.of_triangle.assign(mesh.triangles.size(), 0.0f);
    if (mesh.triangles.empty() || reference.mesh.triangles.empty()) return result;
    const SamplingOptions sampling{.samples = samples, .per_triangle = true};
    MeshComparison comparison = compare(reference.mesh, mesh, sampling, context);
    for (std::size_t t = 0; t < reference.owner.size(); ++t) {
        float& largest = result.of_piece[reference.owner[t]];
        largest = std::max(largest, comparison.forward.triangle_max[t]);
    }
    result.error = comparison.error;
    result.of_triangle = std::move(comparison.backward.triangle_max);
    return result;
}

template LimitReference limit_reference<QuadFamily>(const Hierarchy&, std::span<const CellTriangle>, int,
                                                    const RunContext&, double);
template LimitReference limit_reference<LoopFamily>(const Hierarchy&, std::span<const CellTriangle>, int,
                                                    const RunContext&, double);

void measure_triangles(LimitReference reference, Tessellation& result, std::uint64_t samples,
                       const RunContext& context) {
    const std::vector<Vec3d>& p = reference.mesh.positions;
    std::vector<Vec3d> centres;
    centres.reserve(reference.mesh.triangles.size());
    for (const auto& t : reference.mesh.triangles) centres.push_back((p[t[0]] + p[t[1]] + p[t[2]]) / 3.0);
    std::vector<ClosestPoint> nearest(centres.size());
    TriangleBvh(result.mesh, context).closest(centres, nearest, context);
    reference.owner.clear();
    for (const ClosestPoint& point : nearest) reference.owner.push_back(point.triangle);
    const std::size_t count = result.mesh.triangles.size();
    const ReferenceDistances distances = measure_reference(reference, count, result.mesh, samples, context);
    result.measured_error = distances.error;
    for (std::size_t t = 0; t < count; ++t)
        result.triangle_error[t] = std::max(distances.of_piece[t], distances.of_triangle[t]);
}

}  // namespace tetrakis::detail
