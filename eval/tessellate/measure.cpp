#include "measure.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../distance/limit_samples.hpp"
#include "../distance/local_maximum.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../surface/site_limits.hpp"
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

/// Mesh, search hierarchy and what is needed to number the vertices, per triangle of a reference.
constexpr std::uint64_t k_reference_bytes = 120;

}  // namespace

int reference_bits(std::size_t pieces, int deepest_lattice_level) {
    int bits = pieces > k_many_pieces ? 1 : 2;
    while (bits < k_most_bits && pieces << (2 * bits) < k_wanted_triangles) ++bits;
    return std::min(bits, k_max_level - deepest_lattice_level);
}

void check_reference_memory(std::uint64_t triangles, const RunContext& context) {
    detail::check_memory("measuring the result against a mesh of " + std::to_string(triangles) + " triangles needs",
                         triangles * k_reference_bytes, context.max_memory_bytes, "allow more, or do not measure");
}

template <class Family>
TriangleMesh limit_reference(const Hierarchy& points, std::span<const CellTriangle> pieces, int bits,
                             const RunContext& context, double share) {
    const int n = 1 << bits;
    const auto per_piece = static_cast<std::size_t>(lattice_points(n));
    check_reference_memory(std::uint64_t{pieces.size()} << (2 * bits), context);
    std::vector<Site> sites(pieces.size() * per_piece);
    for_each_index(
        static_cast<std::uint32_t>(pieces.size()),
        [&](std::uint32_t p) { put_lattice_sites<Family>(points.mesh(), pieces[p], bits, &sites[p * per_piece]); }, 64);
    const DistinctSites once(sites);
    TriangleMesh reference;
    reference.positions.resize(once.distinct().size());
    limit_positions(points, once.distinct(), reference.positions,
                    [&](double done) { context.report("measure", share * done); });
    for (std::uint32_t p = 0; p < pieces.size(); ++p) {
        const auto vertex = [&](int row, int i) {
            return once.number()[p * per_piece + static_cast<std::size_t>(lattice_index(row, i))];
        };
        for (int row = 0; row < n; ++row)
            for (int i = 0; i <= row; ++i) {
                reference.triangles.push_back({vertex(row, i), vertex(row + 1, i), vertex(row + 1, i + 1)});
                if (i == row) continue;
                reference.triangles.push_back({vertex(row, i), vertex(row + 1, i + 1), vertex(row, i + 1)});
            }
    }
    return reference;
}

template TriangleMesh limit_reference<QuadFamily>(const Hierarchy&, std::span<const CellTriangle>, int,
                                                  const RunContext&, double);
template TriangleMesh limit_reference<LoopFamily>(const Hierarchy&, std::span<const CellTriangle>, int,
                                                  const RunContext&, double);

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

}  // namespace tetrakis::detail

namespace tetrakis {

namespace {

constexpr int k_least_intervals = 3, k_most_intervals = 24;
constexpr double k_exact = 0.7;        // of the largest distance: from there on others are exact
constexpr std::uint32_t k_block = 64;  // triangles; fixed, so that sums do not depend on the number of threads

/// What was found at one pair of points, at one triangle, or at several.
struct Found {
    double forward = 0, backward = 0;
    double own = 0;  ///< the largest distance of a point of the surface to its own triangle
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

/// Intervals a side of a triangle's lattice of samples, `least` or more, for so many samples in all.
int lattice_intervals(std::uint64_t samples, std::uint32_t triangles, int least) {
    const double each = 2.0 * static_cast<double>(samples) / triangles;
    return static_cast<int>(std::ceil(std::clamp(std::sqrt(each), double(least), double(k_most_intervals))));
}

/// The way from a target to the mesh, sampled on the target itself: what the projection never reached counts as well.
/// At most as many samples are aimed at as the triangles of both could have in a lattice.
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

/// What triangles are measured with, and how closely.
template <class Family>
struct Measurer {
    const TriangleMesh& mesh;
    const std::function<OutputTriangle(std::uint32_t)>& origin;
    const SurfaceMap<Family>& map;
    TriangleBvh bvh;
    double own = 0;  ///< no point of the surface was found farther from the triangle that stands for it
    /// Distances from the surface above this are exact, and those to it that are above this are searched for.
    double exact_from = 0, search_from = 0;
};

/// One triangle of the mesh beside the part of the surface that it stands for.
template <class Family>
class MeasuredTriangle {
  public:
    MeasuredTriangle(const Measurer<Family>& by, std::uint32_t t)
        : by_(by),
          from_(by.origin(t)),
          a_(by.mesh.positions[by.mesh.triangles[t][0]]),
          b_(by.mesh.positions[by.mesh.triangles[t][1]]),
          c_(by.mesh.positions[by.mesh.triangles[t][2]]) {}

    const OutputTriangle& from() const { return from_; }
    double area() const { return 0.5 * glm::length(glm::cross(b_ - a_, c_ - a_)); }

    /// What is not above `exact_from` may be stated too large: as the distance of a point of the surface to this very
    /// triangle, which is one of a point of the triangle to the surface, too.
    Found at(const Vec2d& uv) const {
        const auto b = barycentrics(uv);
        const SurfaceParameter at = parameter(from_, uv);
        const Vec3d s = by_.map(at), q = b[0] * a_ + b[1] * b_ + b[2] * c_;
        const double own = std::sqrt(detail::nearest_on_triangle(s, a_, b_, c_).squared_distance);
        Found result{.forward = own, .backward = own, .own = own};
        if (own > by_.exact_from) result.forward = std::min(own, by_.bvh.closest(s, own * (1 + 1e-9)).distance);
        if (by_.map.target) {
            result.backward = by_.map.target->closest(q).distance;
        } else if (glm::length(s - q) > by_.exact_from) {
            result.backward = by_.map.nearby_distance(q, at);
            if (result.backward > by_.search_from) result.backward = searched(q, result.backward);
        }
        return result;
    }

  private:
    SurfaceParameter parameter(const OutputTriangle& of, const Vec2d& uv) const {
        const auto b = barycentrics(uv);
        return of.template parameter<Family>(by_.map.patches->mesh(), b[0], b[1], b[2]);
    }
    /// The least distance that Newton's method finds from the feet on all triangles that may stand for a nearer point.
    double searched(const Vec3d& q, double best) const {
        struct Foot {
            double distance;
            std::uint32_t triangle;
            Vec2d uv;
        };
        std::vector<Foot> feet;
        for (const std::uint32_t t : by_.bvh.within(q, best + by_.own)) {
            const auto& [a, b, c] = by_.mesh.triangles[t];
            const auto& p = by_.mesh.positions;
            const detail::TrianglePoint foot = detail::nearest_on_triangle(q, p[a], p[b], p[c]);
            feet.push_back({std::sqrt(foot.squared_distance), t, {foot.u, foot.v}});
        }
        std::ranges::sort(feet, {}, [](const Foot& foot) { return std::pair(foot.distance, foot.triangle); });
        for (const Foot& foot : feet) {
            if (foot.distance - by_.own > best) break;
            best = std::min(best, by_.map.nearby_distance(q, parameter(by_.origin(foot.triangle), foot.uv)));
        }
        return best;
    }

    const Measurer<Family>& by_;
    OutputTriangle from_;
    Vec3d a_, b_, c_;
};

}  // namespace

template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, std::uint64_t samples, double tolerance,
                      std::vector<double>& triangle_error, const RunContext& context) {
    const std::uint32_t count = static_cast<std::uint32_t>(mesh.triangles.size());
    triangle_error.clear();
    if (count == 0) return {};
    constexpr double k_none = std::numeric_limits<double>::infinity();
    Measurer<Family> by{mesh, origin, map, TriangleBvh(mesh, context)};
    const ControlMesh& control = map.patches->mesh();
    const int n = lattice_intervals(samples, count, k_least_intervals);
    std::vector<Found> each(count);
    std::atomic<std::uint64_t> taken = 0;
    const auto pass = [&](std::span<const std::uint32_t> triangles, std::uint32_t per_block, double search_from) {
        by.search_from = search_from;
        const auto size = static_cast<std::uint32_t>(triangles.size());
        const std::uint32_t blocks = (size + per_block - 1) / per_block;
        detail::for_each_batch(map.patches, blocks, 1, context, "measure", 0, 0.9, [&](std::uint32_t block) {
            std::uint64_t samples_here = 0;
            for (std::uint32_t i = block * per_block; i < std::min(size, (block + 1) * per_block); ++i) {
                const MeasuredTriangle<Family> triangle(by, triangles[i]);
                const double weight = triangle.area() / (n * n);
                Found& found = each[triangles[i]] = {};
                const auto measured = [&](const Vec2d& uv) {
                    const Found d = triangle.at(uv);
                    found += d;
                    ++samples_here;
                    return d;
                };
                // The farthest samples, each way; `step` is about half the distance of samples there.
                struct Top {
                    double Found::*way;
                    detail::Maximum at{};
                    double step = 0;
                };
                std::array<Top, 2> tops{{{&Found::forward}, {&Found::backward}}};
                const auto offer = [&](const Vec2d& uv, const Found& d, double step) {
                    for (Top& top : tops)
                        if (d.*top.way > top.at.value) top = {top.way, {uv, d.*top.way}, step};
                };
                detail::for_each_lattice_point(n, [&](int, double b0, double b1, double b2) {
                    if (b0 == 1 || b1 == 1 || b2 == 1) return;  // corners are on the surface
                    const Found here = measured({b1, b2});
                    offer({b1, b2}, here, 0.5 / n);
                    found.weighted += weight * (here.forward + here.backward);
                    found.squared += weight * (here.forward * here.forward + here.backward * here.backward);
                    found.weight += 2 * weight;
                });
                // Towards creases of finite sharpness.
                if (const OutputTriangle& from = triangle.from(); !from.fan.valid())
                    detail::for_each_strip_point<Family>(control, from.cell, [&](double b0, double b1, double b2) {
                        double step = 1;
                        for (const double b : {b0, b1, b2})
                            if (b > 0) step = std::min(step, 0.5 * b);
                        offer({b1, b2}, measured({b1, b2}), step);
                    });
                if (!map.plain()) continue;
                for (const Top& top : tops)
                    if (top.at.value > by.exact_from)
                        detail::local_maximum([&](const Vec2d& uv) { return measured(uv).*top.way; }, top.at, top.step);
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
    // Of closest points that were looked for near by alone, those above the tolerance and those that decide are
    // searched for. The largest first: what is found settles those that can be no larger.
    const auto search = [&](const Found& total) {
        constexpr double k_between = 1.25;  // samples
        by.own = k_between * total.own;
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
    by.exact_from = map.plain() ? detail::k_climb_from * tolerance : 0;
    Found total;
    // The largest error has to come from exact samples.
    for (bool exact = false; !exact; by.exact_from = k_exact * total.largest()) {
        taken = 0;
        pass(all, k_block, k_none);
        total = total_of(all);
        if (map.plain() && total.backward > std::min(total.forward, tolerance)) {
            search(total);
            total = total_of(all);
        }
        exact = !map.plain() || total.largest() == 0 || total.largest() > by.exact_from;
    }
    MeasuredError result;
    result.forward_samples = result.backward_samples = taken;
    if (map.target) {
        const DirectedDistance target = measure_from_target(*map.target_mesh, by.bvh, samples, context);
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

}  // namespace tetrakis
