#include "measure.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../distance/mesh_sampling.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../triangles/point_triangle.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

constexpr std::size_t k_wanted_triangles = 60'000;
constexpr std::size_t k_many_pieces = 250'000;
constexpr int k_most_bits = 4;

/// Bytes per triangle of a reference: mesh, search hierarchy, and scratch memory for numbering the vertices.
constexpr std::uint64_t k_reference_bytes = 120;

}  // namespace

int reference_bits(std::size_t pieces, int deepest_lattice_level) {
    int bits = pieces > k_many_pieces ? 1 : 2;
    while (bits < k_most_bits && pieces << (2 * bits) < k_wanted_triangles) ++bits;
    return std::min(bits, k_max_level - deepest_lattice_level);
}

void check_reference_memory(std::uint64_t triangles, const RunContext& context) {
    check_memory("measuring the result against a mesh of " + std::to_string(triangles) + " triangles needs",
                 triangles * k_reference_bytes, context.max_memory_bytes, "allow more, or do not measure");
}

void measure_triangles(const TriangleMesh& reference, Tessellation& result, std::uint64_t samples,
                       const RunContext& context) {
    result.measured_error.emplace();
    if (result.mesh.triangles.empty() || reference.triangles.empty()) return;
    SamplingOptions sampling{.samples = samples, .per_triangle = true};
    const DirectedDistance backward =
        directed_distance(result.mesh, TriangleBvh(reference, context), sampling, context);
    sampling.vertices_alone = true;
    const DirectedDistance forward = directed_distance(reference, TriangleBvh(result.mesh, context), sampling, context);
    result.measured_error = measured_error(forward, backward);
    result.triangle_error.resize(result.mesh.triangles.size());
    for (std::size_t t = 0; t < result.triangle_error.size(); ++t)
        result.triangle_error[t] = std::max(backward.triangle_max[t], forward.nearest_max[t]);
}

namespace {

constexpr int k_least_intervals = 3, k_most_intervals = 24;
constexpr int k_search_intervals = 8, k_search_sweeps = 4;
constexpr double k_exact = 0.7;        // distances above this share of the largest one are exact
constexpr std::uint32_t k_block = 64;  // triangles; fixed, so that sums do not depend on the number of threads

/// Distances found at one pair of points, or the largest ones and sums over several.
struct Found {
    double forward = 0, backward = 0;
    double own = 0;  ///< largest distance of a surface point to its own triangle
    double weighted = 0, squared = 0, weight = 0;
    double largest() const { return std::max(forward, backward); }
    Found& operator+=(const Found& other) {
        forward = std::max(forward, other.forward);
        backward = std::max(backward, other.backward);
        own = std::max(own, other.own);
        weighted += other.weighted;
        squared += other.squared;
        weight += other.weight;
        return *this;
    }
};

/// Distances from a target to the mesh, sampled on the target itself, so that parts that the projection never reached
/// count. There are at most as many samples as lattices of k_most_intervals on the triangles of both would have.
DirectedDistance measure_from_target(const TriangleMesh& target, const TriangleBvh& bvh, std::uint64_t samples,
                                     const RunContext& context) {
    RunContext last_tenth = context;
    if (context.progress)
        last_tenth.progress = [&](std::string_view stage, double done) {
            return context.progress(stage, 0.9 + 0.1 * done);
        };
    constexpr std::uint64_t k_most_each = k_most_intervals * k_most_intervals / 2;
    samples = std::min(samples, k_most_each * (target.triangles.size() + bvh.triangle_count()));
    return directed_distance(target, bvh, {.samples = samples, .per_triangle = true, .within_size = true}, last_tenth);
}

/// Barycentrics from weights of the second and third corner.
std::array<double, 3> barycentrics(const Vec2d& uv) { return {std::max(1 - uv.x - uv.y, 0.0), uv.x, uv.y}; }

}  // namespace

template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, std::uint64_t samples, double tolerance,
                      std::vector<double>& triangle_error, const RunContext& context) {
    const std::uint32_t count = static_cast<std::uint32_t>(mesh.triangles.size());
    triangle_error.clear();
    if (count == 0) return {};
    constexpr double k_none = std::numeric_limits<double>::infinity();
    const TriangleBvh bvh(mesh, context);
    const ControlMesh& control = map.patches->mesh();
    const auto corners_of = [&](std::uint32_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        return std::array{mesh.positions[a], mesh.positions[b], mesh.positions[c]};
    };
    const auto parameter = [&](const OutputTriangle& of, const Vec2d& uv) {
        const auto b = barycentrics(uv);
        return of.template parameter<Family>(control, b[0], b[1], b[2]);
    };
    double most_own = 0;  // estimated largest distance of a surface point to its own triangle
    // Forward distances above `exact_from` are exact; backward distances above `search_from` get a wider search.
    double exact_from = 0, search_from = 0;
    // The least distance to the parts of the surface of all triangles near enough to be closer. Newton's method alone
    // may go over to another part, so it starts at the nearest point of each part, as samples and a climb find it.
    const auto searched = [&](const Vec3d& q, double best) {
        struct Foot {
            double distance;
            std::uint32_t triangle;
            Vec2d uv;
        };
        std::vector<Foot> feet;
        for (const std::uint32_t t : bvh.within(q, best + most_own)) {
            const auto [a, b, c] = corners_of(t);
            const TrianglePoint foot = nearest_on_triangle(q, a, b, c);
            feet.push_back({std::sqrt(foot.squared_distance), t, {foot.u, foot.v}});
        }
        std::ranges::sort(feet, {}, [](const Foot& foot) { return std::pair(foot.distance, foot.triangle); });
        for (const Foot& foot : feet) {
            if (foot.distance - most_own > best) break;
            const OutputTriangle of = origin(foot.triangle);
            const auto nearness = [&](const Vec2d& uv) { return -glm::length(q - map(parameter(of, uv))); };
            Maximum nearest{foot.uv, nearness(foot.uv)};
            for_each_lattice_point(k_search_intervals, [&](int, double, double b1, double b2) {
                nearest.offer({b1, b2}, nearness({b1, b2}));
            });
            nearest = local_maximum(nearness, nearest, 0.5 / k_search_intervals, k_search_sweeps);
            best = std::min(best, map.nearby_distance(q, parameter(of, nearest.at)));
        }
        return best;
    };
    // Distances between a triangle and its own part of the surface. Those up to `exact_from` may be too large: they are
    // the distance of the surface point to this triangle only. It counts in both directions, as the
    // triangle's nearest point is at most that far from the surface.
    const auto distances = [&](const OutputTriangle& from, const std::array<Vec3d, 3>& corner, const Vec2d& uv) {
        const auto b = barycentrics(uv);
        const SurfaceParameter at = parameter(from, uv);
        const Vec3d s = map(at), q = b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2];
        const double own = std::sqrt(nearest_on_triangle(s, corner[0], corner[1], corner[2]).squared_distance);
        Found result{.forward = own, .backward = own, .own = own};
        if (own > exact_from) result.forward = std::min(own, bvh.closest(s, own * (1 + 1e-9)).distance);
        if (map.target) {
            result.backward = map.target->closest(q).distance;
        } else if (glm::length(s - q) > exact_from) {
            result.backward = map.nearby_distance(q, at);
            if (result.backward > search_from) result.backward = searched(q, result.backward);
        }
        return result;
    };
    // Intervals a side of a triangle's lattice.
    const double wanted = std::sqrt(2.0 * static_cast<double>(samples) / count);
    const int n = static_cast<int>(std::ceil(std::clamp<double>(wanted, k_least_intervals, k_most_intervals)));
    std::vector<Found> each(count);
    std::atomic<std::uint64_t> taken = 0;
    const auto pass = [&](std::span<const std::uint32_t> triangles, std::uint32_t per_block, double search_above) {
        search_from = search_above;
        const auto size = static_cast<std::uint32_t>(triangles.size());
        const std::uint32_t blocks = (size + per_block - 1) / per_block;
        for_each_batch(map.patches, blocks, 1, context, "measure", 0, 0.9, [&](std::uint32_t block) {
            std::uint64_t samples_here = 0;
            for (std::uint32_t i = block * per_block; i < std::min(size, (block + 1) * per_block); ++i) {
                const OutputTriangle from = origin(triangles[i]);
                const std::array<Vec3d, 3> corner = corners_of(triangles[i]);
                const double area = 0.5 * glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
                const double weight = area / (n * n);
                Found& found = each[triangles[i]] = {};
                const auto measured = [&](const Vec2d& uv) {
                    const Found d = distances(from, corner, uv);
                    found += d;
                    ++samples_here;
                    return d;
                };
                // The farthest sample in each direction; `step` is about half the spacing of samples there.
                struct Top {
                    double Found::*way;
                    Maximum at{};
                    double step = 0;
                };
                std::array<Top, 2> tops{{{&Found::forward}, {&Found::backward}}};
                const auto offer = [&](const Vec2d& uv, const Found& d, double step) {
                    for (Top& top : tops)
                        if (d.*top.way > top.at.value) top = {top.way, {uv, d.*top.way}, step};
                };
                for_each_lattice_point(n, [&](int, double b0, double b1, double b2) {
                    if (b0 == 1 || b1 == 1 || b2 == 1) return;  // corners are on the surface
                    const Found here = measured({b1, b2});
                    offer({b1, b2}, here, 0.5 / n);
                    found.weighted += weight * (here.forward + here.backward);
                    found.squared += weight * (here.forward * here.forward + here.backward * here.backward);
                    found.weight += 2 * weight;
                });
                // Denser samples near creases of finite sharpness.
                if (!from.fan.valid())
                    for_each_strip_point<Family>(control, from.cell, [&](double b0, double b1, double b2) {
                        double step = 1;
                        for (const double b : {b0, b1, b2})
                            if (b > 0) step = std::min(step, 0.5 * b);
                        offer({b1, b2}, measured({b1, b2}), step);
                    });
                if (!map.plain()) continue;
                for (const Top& top : tops)
                    if (top.at.value > exact_from)
                        local_maximum([&](const Vec2d& uv) { return measured(uv).*top.way; }, top.at, top.step);
            }
            taken += samples_here;
        });
    };
    const auto total_of = [&](std::span<const std::uint32_t> triangles) {
        Found total;
        for (const std::uint32_t t : triangles) total += each[t];
        return total;
    };
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    // Backward distances come from a local search only. The wider search is for those above the tolerance or above the
    // largest distance. The largest come first: a distance found limits which others must be searched for.
    const auto search = [&](const Found& total) {
        constexpr double k_between = 1.25;  // margin for larger distances between the samples
        most_own = k_between * total.own;
        std::vector<std::uint32_t> order = all;
        std::ranges::stable_sort(order, std::greater{}, [&](std::uint32_t t) { return each[t].backward; });
        double largest = total.forward;
        const auto is_open = [&](std::size_t i) {
            return i < count && each[order[i]].backward > std::min(largest, tolerance);
        };
        std::size_t begin = 0;
        for (std::size_t some = 4; is_open(begin); begin += some, some *= 2) {
            const auto next = std::span(order).subspan(begin, std::min(some, count - begin));
            pass(next, 1, std::min(largest, tolerance));
            largest = std::max(largest, total_of(next).backward);
        }
    };
    exact_from = map.plain() ? k_climb_from * tolerance : 0;
    Found total;
    // The largest error has to come from exact samples.
    for (bool exact = false; !exact; exact_from = k_exact * total.largest()) {
        taken = 0;
        pass(all, k_block, k_none);
        total = total_of(all);
        if (map.plain() && total.backward > std::min(total.forward, tolerance)) {
            search(total);
            total = total_of(all);
        }
        exact = !map.plain() || total.largest() == 0 || total.largest() > exact_from;
    }
    MeasuredError result;
    result.forward_samples = result.backward_samples = taken;
    if (map.target) {
        const DirectedDistance target = measure_from_target(*map.target_mesh, bvh, samples, context);
        total += {.forward = target.max,
                  .weighted = target.mean * target.area,
                  .squared = target.rms * target.rms * target.area,
                  .weight = target.area};
        result.forward_samples += target.samples;
        for (std::uint32_t t = 0; t < count; ++t) each[t] += {.forward = target.nearest_max[t]};
    }
    result.forward = total.forward;
    result.backward = total.backward;
    result.hausdorff = total.largest();
    if (total.weight > 0) {
        result.mean = total.weighted / total.weight;
        result.rms = std::sqrt(total.squared / total.weight);
    }
    for (const Found& found : each) triangle_error.push_back(found.largest());
    return result;
}

template MeasuredError measure<QuadFamily>(const TriangleMesh&, const std::function<OutputTriangle(std::uint32_t)>&,
                                           const SurfaceMap<QuadFamily>&, std::uint64_t, double, std::vector<double>&,
                                           const RunContext&);
template MeasuredError measure<LoopFamily>(const TriangleMesh&, const std::function<OutputTriangle(std::uint32_t)>&,
                                           const SurfaceMap<LoopFamily>&, std::uint64_t, double, std::vector<double>&,
                                           const RunContext&);

}  // namespace tetrakis::detail
