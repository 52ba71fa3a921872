#include "hausdorff.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"
#include "mesh_sampling.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

namespace tetrakis {

namespace {

struct Corners {
    Vec3d a, ab, ac;
    Corners(const TriangleMesh& mesh, std::uint32_t t)
        : a(mesh.positions[mesh.triangles[t][0]]),
          ab(mesh.positions[mesh.triangles[t][1]] - a),
          ac(mesh.positions[mesh.triangles[t][2]] - a) {}
    Vec3d at(const Vec2d& uv) const { return a + uv.x * ab + uv.y * ac; }
    double area() const { return 0.5 * glm::length(glm::cross(ab, ac)); }
    double side(int k) const {
        return glm::length(k == 0 ? ab : k == 1 ? ac - ab : ac);
    }  ///< from corner k to the next
};

struct Worst {
    double distance = -1;
    std::uint32_t triangle = 0;
    Vec2d uv{0.0};
    Vec3d point{0.0};
    void offer(double d, std::uint32_t t, const Vec2d& where, const Vec3d& p) {
        if (d > distance) *this = {d, t, where, p};
    }
};

struct BlockResult {
    double sum = 0, sum_of_squares = 0;  // weighted by area
    std::uint64_t samples = 0;
    Worst at_vertex, inside;  // both are starts of climbs
    void add(double weight, double distance) {
        sum += weight * distance;
        sum_of_squares += weight * distance * distance;
    }
};

// Barycentric weights of a point at fraction s of side k (corner k to corner k + 1).
Vec2d on_side(int k, double s) {
    constexpr Vec2d k_corners[4] = {{0, 0}, {1, 0}, {0, 1}, {0, 0}};
    return k_corners[k] + s * (k_corners[k + 1] - k_corners[k]);
}

/// Sample k on an edge as a fraction of it. The two sides of an edge get different ones; `lower` starts at the middle.
double edge_sample(std::uint32_t k, bool lower) {
    // 0.382 lies in that gap of the sequence from the middle which stays the largest one for longest.
    return glm::fract((lower ? 0.5 : 0.381966011250105) + k * 0.61803398874989484820);
}

class Sampler {
  public:
    Sampler(const TriangleMesh& mesh, const TriangleBvh& to, const SamplingOptions& options)
        : mesh_(mesh), to_(to), options_(options) {
        std::vector<double> areas;
        double length = 0;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const Corners corners(mesh, t);
            areas.push_back(corners.area());
            area_ += areas.back();
            length += corners.side(0) + corners.side(1) + corners.side(2);
        }
        const double samples = static_cast<double>(options.samples);
        const double density = area_ > 0 ? samples / area_ : 0.0;
        if (length > 0) along_edges_ = std::min(std::sqrt(density) / 4, samples / length);
        vertices_.resize(mesh.positions.size());
        for (std::size_t t = 0; t < areas.size(); ++t) {
            const auto rows =
                static_cast<std::uint64_t>(std::clamp(std::round(std::sqrt(areas[t] * density)), 1.0, k_most_rows));
            first_.push_back(first_.back() + rows * rows);
            for (std::size_t k = 0; k < 3; ++k) {
                Vertex& v = vertices_[mesh.triangles[t][k]];
                v.corner = std::min<std::uint64_t>(v.corner, 3 * t + k);
                v.area += areas[t] / 3;
            }
        }
    }

    DirectedDistance run(const RunContext& context) {
        DirectedDistance result;
        result.area = area_;
        if (options_.per_triangle) {
            result.triangle_max.assign(mesh_.triangles.size(), 0.0f);
            nearest_max_.assign(to_.triangle_count(), 0.0f);
        }
        std::vector<Worst> worst;
        sample(result, worst, context);
        climb(result, worst);
        if (area_ > 0) {
            result.mean /= area_;
            result.rms = std::sqrt(result.rms / area_);
        }
        result.nearest_max = std::move(nearest_max_);
        return result;
    }

  private:
    /// Data of a vertex: its first triangle corner, at which it is sampled, and a third of its triangles' area.
    struct Vertex {
        std::uint64_t corner = ~std::uint64_t{0};
        double area = 0;
        float distance = 0;
    };
    static constexpr double k_most_rows = 65535;

    /// Number of samples inside a triangle, a square that grows with its area.
    double inside_count(std::uint32_t t) const { return static_cast<double>(first_[t + std::size_t{1}] - first_[t]); }

    double distance_of(const Vec3d& point, CoherentClosest& walker) {
        const ClosestPoint nearest = walker.closest(point);
        if (options_.per_triangle && !(options_.within_size && nearest.distance > to_.longest_side(nearest.triangle)))
            raise(nearest_max_[nearest.triangle], nearest.distance);
        return nearest.distance;
    }
    /// Sets `largest` to `distance` if that is larger. Thread-safe.
    static void raise(float& largest, double distance) {
        const std::atomic_ref shared(largest);
        const float here = detail::round_up(distance);
        for (float known = shared; known < here && !shared.compare_exchange_weak(known, here);) {
        }
    }

    void sample(DirectedDistance& result, std::vector<Worst>& worst, const RunContext& context) {
        // About two milliseconds of closest points: long for a task's overhead, short enough for an even load.
        constexpr std::uint64_t k_block_samples = 4096;
        std::vector<BlockResult> results((first_.back() + k_block_samples - 1) / k_block_samples);
        for_each_reported(
            static_cast<std::uint32_t>(results.size()), 1, context, "measure", 0, 1, [&](std::uint32_t b) {
                const std::uint64_t begin = b * k_block_samples;
                results[b] = sample_block(begin, std::min(begin + k_block_samples, first_.back()), result);
            });
        for (const BlockResult& block : results) {
            result.mean += block.sum;
            result.rms += block.sum_of_squares;
            result.samples += block.samples;
            for (const Worst& w : {block.at_vertex, block.inside})
                if (w.distance >= 0) worst.push_back(w);
        }
        for (std::size_t t = 0; t < result.triangle_max.size(); ++t)
            for (const std::uint32_t v : mesh_.triangles[t]) raise(result.triangle_max[t], vertices_[v].distance);
    }

    /// Takes the samples inside triangles with numbers in [begin, end). The first sample of a triangle brings those on
    /// its edges and at vertices whose first corner it has.
    BlockResult sample_block(std::uint64_t begin, std::uint64_t end, DirectedDistance& result) {
        BlockResult out;
        CoherentClosest walker(to_);
        auto t = static_cast<std::uint32_t>(std::ranges::upper_bound(first_, begin) - first_.begin() - 1);
        for (; begin < end; begin = first_[++t]) {
            const Corners corners(mesh_, t);
            const auto& corner = mesh_.triangles[t];
            const double count = inside_count(t), weight = corners.area() / count;
            const auto rows = static_cast<std::uint32_t>(std::lround(std::sqrt(count)));
            double largest = 0;
            const auto measure = [&](const Vec2d& uv, const Vec3d& point, Worst& worst) {
                const double distance = distance_of(point, walker);
                ++out.samples;
                largest = std::max(largest, distance);
                worst.offer(distance, t, uv, point);
                return distance;
            };
            const auto inside = [&](const Vec2d& uv) { return measure(uv, corners.at(uv), out.inside); };
            for (int k = 0; k < 3 && begin == first_[t]; ++k) {
                Vertex& v = vertices_[corner[k]];
                if (v.corner != 3 * std::uint64_t{t} + k) continue;
                const double distance = measure(on_side(k, 0), mesh_.positions[corner[k]], out.at_vertex);
                v.distance = detail::round_up(distance);
                if (options_.vertices_alone) out.add(v.area, distance);
            }
            if (!options_.vertices_alone) {
                for (std::uint64_t k = begin; k < std::min(end, first_[t + std::size_t{1}]); ++k)
                    out.add(weight, inside(detail::inside_sample(k - first_[t], rows)));
                // Along an edge as dense as inside the triangle; denser, by length, if the triangle is thin.
                for (int side = 0; side < 3 && begin == first_[t]; ++side) {
                    const double by_length = std::min(k_most_rows, along_edges_ * corners.side(side));
                    const std::uint32_t samples = 1 + std::max(rows / 2, static_cast<std::uint32_t>(by_length));
                    for (std::uint32_t k = 0; k < samples; ++k)
                        inside(on_side(side, edge_sample(k, corner[side] < corner[(side + 1) % 3])));
                }
            }
            if (options_.per_triangle) raise(result.triangle_max[t], largest);
        }
        return out;
    }

    // Climbs in the plane of the triangle, from the worst sample of each of the worst blocks.
    void climb(DirectedDistance& result, std::vector<Worst>& worst) {
        std::stable_sort(worst.begin(), worst.end(),
                         [](const Worst& l, const Worst& r) { return l.distance > r.distance; });
        const std::size_t climbs = std::min<std::size_t>(options_.climbs, worst.size());
        std::vector<std::uint64_t> tried(climbs, 0);
        for_each_index(
            static_cast<std::uint32_t>(climbs), [&](std::uint32_t i) { tried[i] = climb_from(worst[i]); }, 1);
        result.samples += std::accumulate(tried.begin(), tried.end(), std::uint64_t{0});
        Worst top;
        for (const Worst& w : worst) top.offer(w.distance, w.triangle, w.uv, w.point);
        result.max = std::max(top.distance, 0.0);
        result.worst_point = top.point;
        result.worst_triangle = top.triangle;
        if (options_.per_triangle)
            for (std::size_t i = 0; i < climbs; ++i) raise(result.triangle_max[worst[i].triangle], worst[i].distance);
    }

    /// Returns the number of points that it has tried.
    std::uint64_t climb_from(Worst& worst) {
        const Corners corners(mesh_, worst.triangle);
        CoherentClosest walker(to_);
        std::uint64_t tried = 0;
        constexpr int k_sweeps = 6;  // the last step is below a thousandth of the sample spacing
        const double step = 1 / std::sqrt(inside_count(worst.triangle) + 1);
        const auto distance = [&](const Vec2d& uv) {
            ++tried;
            return distance_of(corners.at(uv), walker);
        };
        const detail::Maximum top = detail::local_maximum(distance, {worst.uv, worst.distance}, step, k_sweeps);
        worst.offer(top.value, worst.triangle, top.at, corners.at(top.at));
        return tried;
    }

    const TriangleMesh& mesh_;
    const TriangleBvh& to_;
    SamplingOptions options_;
    double area_ = 0;
    double along_edges_ = 0;               ///< least number of samples per unit of an edge's length
    std::vector<std::uint64_t> first_{0};  ///< per triangle: number of inside samples of all triangles before it
    std::vector<Vertex> vertices_;
    std::vector<float> nearest_max_;
};

void check_mesh(const TriangleMesh& mesh, const char* which) {
    if (mesh.triangles.empty()) throw Error(ErrorCode::invalid_input, std::string(which) + " has no triangles");
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) {
            if (v >= mesh.positions.size())
                throw Error(ErrorCode::invalid_input, "triangle " + std::to_string(t) + " uses vertex " +
                                                          std::to_string(v) + ", but there are " +
                                                          std::to_string(mesh.positions.size()) + " vertices");
            const Vec3d& p = mesh.positions[v];
            constexpr double k_farthest = 1e60;  // squares and their products stay finite
            for (int axis = 0; axis < 3; ++axis)
                if (!(std::abs(p[axis]) <= k_farthest))
                    throw Error(ErrorCode::invalid_input,
                                "vertex " + std::to_string(v) + " is not finite or beyond 1e+60; scale the mesh down");
        }
}

}  // namespace

MeasuredError measured_error(const DirectedDistance& forward, const DirectedDistance& backward) {
    MeasuredError error;
    error.forward = forward.max;
    error.backward = backward.max;
    error.hausdorff = std::max(forward.max, backward.max);
    error.forward_samples = forward.samples;
    error.backward_samples = backward.samples;
    const double area = forward.area + backward.area;
    if (area > 0) {
        error.mean = (forward.mean * forward.area + backward.mean * backward.area) / area;
        error.rms =
            std::sqrt((forward.rms * forward.rms * forward.area + backward.rms * backward.rms * backward.area) / area);
    }
    return error;
}

DirectedDistance directed_distance(const TriangleMesh& mesh, const TriangleBvh& to, const SamplingOptions& options,
                                   const RunContext& context) {
    check_mesh(mesh, "the sampled mesh");
    if (to.triangle_count() == 0) throw Error(ErrorCode::invalid_input, "the mesh measured against has no triangles");
    return with_threads(context, [&] { return Sampler(mesh, to, options).run(context); });
}

MeshComparison compare(const TriangleMesh& reference, const TriangleMesh& mesh, const SamplingOptions& options,
                       const RunContext& context) {
    check_mesh(reference, "the reference mesh");
    check_mesh(mesh, "the mesh");
    MeshComparison result;
    {
        const TriangleBvh to_mesh(mesh, context);
        result.bvh_bytes += to_mesh.memory_bytes();
        result.forward = directed_distance(reference, to_mesh, options, context);
    }
    const TriangleBvh to_reference(reference, context);
    result.bvh_bytes = std::max(result.bvh_bytes, to_reference.memory_bytes());
    result.backward = directed_distance(mesh, to_reference, options, context);
    result.error = measured_error(result.forward, result.backward);
    return result;
}

}  // namespace tetrakis
