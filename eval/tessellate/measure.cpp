#include "measure.hpp"

#include "../../hier/base/parallel.hpp"
#include "../bounds/point_triangle.hpp"
#include "../surface/local_frame.hpp"
#include "patch_batches.hpp"
#include "strip_samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrakis {

namespace {

constexpr int k_least_intervals = 3, k_most_intervals = 24;
constexpr std::uint32_t k_block = 64;  // triangles; fixed, so that sums do not depend on the number of threads

struct Sums {
    double forward = 0, backward = 0;
    double weighted = 0, squared = 0, weight = 0;
    std::uint64_t samples = 0;
};

/// Intervals a side of a triangle's lattice of samples, `least` or more, for so many samples in all.
int lattice_intervals(std::uint64_t samples, std::uint32_t triangles, int least) {
    const double each = 2.0 * static_cast<double>(samples) / triangles;
    return static_cast<int>(std::ceil(std::clamp(std::sqrt(each), double(least), double(k_most_intervals))));
}

/// A point of a displaced surface with its first derivatives: those of the surface and its normal in closed form, of
/// the heights by differences.
template <class Family>
SurfacePoint displaced(const SurfaceMap<Family>& map, const SurfaceParameter& at) {
    // Differences over a thousandth of a root: displacement images are smooth at that scale or coarser than the mesh.
    constexpr double k_step = 1e-3;
    SurfacePoint s = map.patches->evaluate(at.root, at.x, at.y);
    const auto height = [&](double x, double y) {
        return map.amplitude * map.displacement->sample(map.uv->at(at.root, x, y));
    };
    const double here = height(at.x, at.y);
    const auto slope = [&](double ux, double uy) {
        for (const double h : {k_step, -k_step})
            if (const double x = at.x + h * ux, y = at.y + h * uy;
                std::min(x, y) >= 0 && std::max(x, y) <= 1 && Family::inside(x, y))
                return (height(x, y) - here) / h;
        return 0.0;  // a corner of a triangle
    };
    const double across = glm::length(glm::cross(s.du, s.dv));
    const auto turn = [&](const Vec3d& by) {  // of the normal, by the derivative of du x dv
        return s.has_second && across > 0 ? (by - glm::dot(by, s.normal) * s.normal) / across : Vec3d(0);
    };
    const Vec3d normal_u = turn(glm::cross(s.duu, s.dv) + glm::cross(s.du, s.duv));
    const Vec3d normal_v = turn(glm::cross(s.duv, s.dv) + glm::cross(s.du, s.dvv));
    s.position += here * s.normal;
    s.du += slope(1, 0) * s.normal + here * normal_u;
    s.dv += slope(0, 1) * s.normal + here * normal_v;
    return s;
}

/// Distance from q to a nearby point of a displaced surface: Gauss-Newton inside the root of the start `s`, at `at`.
/// Never more than `best`, the distance to the start.
template <class Family>
double mapped_distance(const SurfaceMap<Family>& map, const Vec3d& q, SurfaceParameter at, SurfacePoint s,
                       double best) {
    constexpr int k_steps = 4;
    constexpr double k_gain = 1e-6;  // relative; a step that gains less is the last
    for (int step = 0; step < k_steps && best > 0; ++step) {
        double dx, dy;
        if (!detail::tangent_step(s, q, dx, dy)) break;
        const double x = std::clamp(at.x + dx, 0.0, 1.0), y = std::clamp(at.y + dy, 0.0, 1.0);
        if (!Family::inside(x, y)) break;
        at = {at.root, x, y};
        s = displaced(map, at);
        const double distance = glm::length(s.position - q), before = best;
        best = std::min(best, distance);
        if (!(distance < before * (1 - k_gain))) break;
    }
    return best;
}

/// The way from a target to the mesh, sampled on the target itself: what the projection never reached counts as well.
/// @param triangle_error  raised where a point of the target is nearest to a triangle and within its size, so that
///                        splitting the triangle may help
Sums measure_from_target(const TriangleMesh& target, const TriangleMesh& mesh, const TriangleBvh& bvh,
                         std::uint64_t samples, std::vector<double>& triangle_error, const RunContext& context) {
    const auto count = static_cast<std::uint32_t>(target.triangles.size());
    const auto area = [&](std::uint32_t t) {
        const auto& tri = target.triangles[t];
        const Vec3d& a = target.positions[tri[0]];
        return 0.5 * glm::length(glm::cross(target.positions[tri[1]] - a, target.positions[tri[2]] - a));
    };
    double whole = 0;
    for (std::uint32_t t = 0; t < count; ++t) whole += area(t);
    const double spacing = std::sqrt(whole / static_cast<double>(samples));
    const std::uint32_t blocks = (count + k_block - 1) / k_block;
    std::vector<Sums> sums(blocks);
    struct Worst {
        double distance = -1;
        std::uint32_t triangle = ClosestPoint::k_none;
    };
    std::vector<Worst> worst(count);
    for_each_reported(blocks, 1, context, "measure", 0.9, 1, [&](std::uint32_t block) {
        Sums& sum = sums[block];
        ClosestPointWalker walker(bvh);
        for (std::uint32_t t = block * k_block; t < std::min(count, (block + 1) * k_block); ++t) {
            const auto& tri = target.triangles[t];
            const Vec3d a = target.positions[tri[0]], b = target.positions[tri[1]], c = target.positions[tri[2]];
            // By its share of the area: a target may have few large triangles, or both large and small ones. Long thin
            // ones, which have little area, get points along them.
            const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
            const double along = std::min<double>(k_most_intervals, spacing > 0 ? longest / spacing : 0.0);
            const double within = spacing > 0 ? std::sqrt(2 * area(t)) / spacing : 0.0;
            const int n = std::max(1, static_cast<int>(std::ceil(std::max(along, within))));
            const double weight = area(t) / (0.5 * (n + 1.0) * (n + 2.0));
            for (int i = 0; i <= n; ++i)
                for (int j = 0; i + j <= n; ++j) {
                    const double b0 = static_cast<double>(n - i - j) / n, b1 = static_cast<double>(i) / n,
                                 b2 = static_cast<double>(j) / n;
                    const ClosestPoint hit = walker.closest(b0 * a + b1 * b + b2 * c);
                    if (hit.distance > worst[t].distance) worst[t] = {hit.distance, hit.triangle};
                    sum.weighted += weight * hit.distance;
                    sum.squared += weight * hit.distance * hit.distance;
                    sum.weight += weight;
                    ++sum.samples;
                }
            sum.forward = std::max(sum.forward, worst[t].distance);
        }
    });
    for (const Worst& hit : worst) {
        if (hit.triangle == ClosestPoint::k_none) continue;
        const auto& tri = mesh.triangles[hit.triangle];
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k)
            longest = std::max(longest, glm::length(mesh.positions[tri[k]] - mesh.positions[tri[(k + 1) % 3]]));
        if (hit.distance <= longest)
            triangle_error[hit.triangle] = std::max(triangle_error[hit.triangle], hit.distance);
    }
    Sums total;
    for (const Sums& sum : sums) {
        total.forward = std::max(total.forward, sum.forward);
        total.weighted += sum.weighted;
        total.squared += sum.squared;
        total.weight += sum.weight;
        total.samples += sum.samples;
    }
    return total;
}

/// Visits the samples of a triangle: a lattice with n intervals a side without the corners; and points towards creases
/// of finite sharpness, which do not count for means.
template <class Family, class Visit>
void for_each_sample(const ControlMesh& control, const OutputTriangle& triangle, int n, Visit&& visit) {
    for (int row = 0; row <= n; ++row)
        for (int i = 0; i <= row; ++i) {
            const double b0 = static_cast<double>(row - i) / n, b1 = static_cast<double>(i) / n,
                         b2 = static_cast<double>(n - row) / n;
            if (b0 != 1 && b1 != 1 && b2 != 1) visit(b0, b1, b2, true);
        }
    if (!triangle.fan.valid())
        detail::for_each_strip_point<Family>(control, triangle.cell,
                                             [&](double b0, double b1, double b2) { visit(b0, b1, b2, false); });
}

}  // namespace

template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, const typename Family::Closest& closest, std::uint64_t samples,
                      double tolerance, std::vector<double>& triangle_error, const RunContext& context) {
    const std::uint32_t count = static_cast<std::uint32_t>(mesh.triangles.size());
    triangle_error.assign(count, 0.0);
    MeasuredError result;
    if (count == 0) return result;
    const TriangleBvh bvh(mesh, context);
    const ControlMesh& control = map.patches->mesh();
    const int n = lattice_intervals(samples, count, k_least_intervals);
    const std::uint32_t blocks = (count + k_block - 1) / k_block;
    std::vector<Sums> sums(blocks);
    // Apart, because the search below may put better distances in the place of Newton's bounds.
    struct WayBack {
        double weighted = 0, squared = 0;
    };
    std::vector<WayBack> way_back(count);
    std::vector<double> sideways(count, 0.0);  // per triangle: the largest upper bound from Newton's method alone

    // Against the limit surface itself Newton's bound is checked by a search where it counts.
    const bool search = map.plain(), by_displacement = map.displacement && !map.target;
    const auto run_block = [&](std::uint32_t block) {
        Sums& sum = sums[block];
        for (std::uint32_t t = block * k_block; t < std::min(count, (block + 1) * k_block); ++t) {
            const OutputTriangle from = origin(t);
            const auto& tri = mesh.triangles[t];
            const Vec3d a = mesh.positions[tri[0]], b = mesh.positions[tri[1]], c = mesh.positions[tri[2]];
            const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
            const double weight = area / (n * n);
            double largest = 0, local = 0;
            for_each_sample<Family>(control, from, n, [&](double b0, double b1, double b2, bool counts) {
                const double share = counts ? weight : 0;
                const SurfaceParameter at = from.parameter<Family>(control, b0, b1, b2);
                SurfacePoint point;
                if (by_displacement) point = displaced(map, at);
                const Vec3d s = by_displacement ? point.position : map(at), q = b0 * a + b1 * b + b2 * c;
                const double own = std::sqrt(detail::nearest_on_triangle(s, a, b, c).squared_distance);
                double forward = own, backward = 0;
                if (own > 0) {
                    const ClosestPoint hit = bvh.closest(s, own * (1 + 1e-9));
                    if (hit.found()) forward = std::min(own, hit.distance);
                }
                const double parametric = glm::length(s - q);
                if (map.target) {
                    backward = map.target->closest(q).distance;
                    forward = std::min(forward, bvh.closest(s, own * (1 + 1e-9)).distance);
                } else if (parametric == 0) {
                    backward = 0;
                } else if (by_displacement) {
                    backward = mapped_distance(map, q, at, point, parametric);
                } else {
                    backward = closest.local(q, at);
                    local = std::max(local, backward);
                }
                sum.forward = std::max(sum.forward, forward);
                if (!search) sum.backward = std::max(sum.backward, backward);
                largest = std::max(largest, search ? forward : std::max(forward, backward));
                sum.weighted += share * forward;
                sum.squared += share * forward * forward;
                way_back[t].weighted += share * backward;
                way_back[t].squared += share * backward * backward;
                sum.weight += 2 * share;
                ++sum.samples;
            });
            triangle_error[t] = largest;
            sideways[t] = local;
        }
    };
    detail::for_each_batch(map.patches, blocks, 1, context, "measure", 0, 0.9, run_block);

    Sums total;
    for (const Sums& sum : sums) {
        total.forward = std::max(total.forward, sum.forward);
        total.backward = std::max(total.backward, sum.backward);
        total.weighted += sum.weighted;
        total.squared += sum.squared;
        total.weight += sum.weight;
        total.samples += sum.samples;
    }
    if (search) {
        // The triangles with the largest bounds, one after the other, each sample by the exact search where its bound
        // exceeds what is known, until no bound is left that is above the largest exact distance or the tolerance.
        std::vector<std::uint32_t> order(count);
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(),
                         [&](std::uint32_t x, std::uint32_t y) { return sideways[x] > sideways[y]; });
        closest.prepare(context);
        double exact = 0;
        for (std::uint32_t t : order) {
            if (sideways[t] <= exact && sideways[t] <= tolerance) break;
            context.report("measure", 0.95);
            detail::forget_large_trees(map.patches);
            const OutputTriangle from = origin(t);
            const auto& tri = mesh.triangles[t];
            const Vec3d a = mesh.positions[tri[0]], b = mesh.positions[tri[1]], c = mesh.positions[tri[2]];
            const double weight = 0.5 * glm::length(glm::cross(b - a, c - a)) / (n * n);
            way_back[t] = {};
            double here = 0;
            for_each_sample<Family>(control, from, n, [&](double b0, double b1, double b2, bool counts) {
                const double share = counts ? weight : 0;
                const Vec3d q = b0 * a + b1 * b + b2 * c;
                const double bound = closest.local(q, from.parameter<Family>(control, b0, b1, b2));
                const double distance = bound > here ? closest.global(q, bound) : bound;
                way_back[t].weighted += share * distance;
                way_back[t].squared += share * distance * distance;
                here = std::max(here, distance);
            });
            exact = std::max(exact, here);
            sideways[t] = here;
        }
        total.backward = exact;
        for (std::uint32_t t = 0; t < count; ++t) triangle_error[t] = std::max(triangle_error[t], sideways[t]);
    }
    for (const WayBack& sum : way_back) {
        total.weighted += sum.weighted;
        total.squared += sum.squared;
    }
    Sums from_target;
    if (map.target) {
        from_target = measure_from_target(*map.target_mesh, mesh, bvh, samples, triangle_error, context);
        total.forward = std::max(total.forward, from_target.forward);
        total.weighted += from_target.weighted;
        total.squared += from_target.squared;
        total.weight += from_target.weight;
    }
    result.forward = total.forward;
    result.backward = total.backward;
    result.hausdorff = std::max(total.forward, total.backward);
    // No distance that is summed exceeds the largest by now, whatever Newton's method first made of it.
    if (total.weight > 0) {
        result.mean = total.weighted / total.weight;
        result.rms = std::sqrt(total.squared / total.weight);
    }
    result.forward_samples = result.backward_samples = total.samples;
    result.forward_samples += from_target.samples;
    return result;
}

template MeasuredError measure<QuadFamily>(const TriangleMesh&, const std::function<OutputTriangle(std::uint32_t)>&,
                                           const SurfaceMap<QuadFamily>&, const QuadClosest&, std::uint64_t, double,
                                           std::vector<double>&, const RunContext&);
template MeasuredError measure<LoopFamily>(const TriangleMesh&, const std::function<OutputTriangle(std::uint32_t)>&,
                                           const SurfaceMap<LoopFamily>&, const LoopClosest&, std::uint64_t, double,
                                           std::vector<double>&, const RunContext&);

}  // namespace tetrakis
