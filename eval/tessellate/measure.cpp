#include "measure.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../distance/limit_samples.hpp"
#include "../distance/local_maximum.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../surface/site_limits.hpp"
#include "../triangles/point_triangle.hpp"
#include "patch_batches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
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
constexpr std::uint32_t k_block = 64;  // triangles; fixed, so that sums do not depend on the number of threads

struct Sums {
    double forward = 0, backward = 0;
    double weighted = 0, squared = 0, weight = 0;
    std::uint64_t samples = 0;
    double largest() const { return std::max(forward, backward); }
    Sums& operator+=(const Sums& other) {
        forward = std::max(forward, other.forward);
        backward = std::max(backward, other.backward);
        weighted += other.weighted;
        squared += other.squared;
        weight += other.weight;
        samples += other.samples;
        return *this;
    }
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
        CoherentClosest walker(bvh);
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
    for (const Sums& sum : sums) total += sum;
    return total;
}

/// Barycentrics from weights of the second and third corner.
std::array<double, 3> barycentrics(const Vec2d& uv) { return {std::max(1 - uv.x - uv.y, 0.0), uv.x, uv.y}; }

/// Distances at one pair of points: of the surface to the mesh, and of the mesh to the surface.
struct Distances {
    double forward = 0, backward = 0;
};

/// One triangle of the mesh beside the part of the surface that it stands for.
template <class Family>
class MeasuredTriangle {
  public:
    MeasuredTriangle(const TriangleMesh& mesh, std::uint32_t t, const OutputTriangle& from,
                     const SurfaceMap<Family>& map, const TriangleBvh& bvh, const typename Family::Closest& closest,
                     double exact_from, double search_from)
        : from_(from),
          a_(mesh.positions[mesh.triangles[t][0]]),
          b_(mesh.positions[mesh.triangles[t][1]]),
          c_(mesh.positions[mesh.triangles[t][2]]),
          map_(map),
          bvh_(bvh),
          closest_(closest),
          exact_from_(exact_from),
          search_from_(search_from) {}

    double area() const { return 0.5 * glm::length(glm::cross(b_ - a_, c_ - a_)); }

    /// What is not above `exact_from` may be stated too large: as the distance of a point of the surface to this very
    /// triangle, which is one of a point of the triangle to the surface, too.
    Distances at(const Vec2d& uv) const {
        const auto b = barycentrics(uv);
        const SurfaceParameter at = from_.parameter<Family>(map_.patches->mesh(), b[0], b[1], b[2]);
        const Vec3d q = b[0] * a_ + b[1] * b_ + b[2] * c_;
        const bool displaced_alone = map_.displacement && !map_.target;
        SurfacePoint point;
        if (displaced_alone) point = displaced(map_, at);
        const Vec3d s = displaced_alone ? point.position : map_(at);
        const double own = std::sqrt(detail::nearest_on_triangle(s, a_, b_, c_).squared_distance);
        const double parametric = glm::length(s - q);
        Distances result{own, own};
        if (own > exact_from_) result.forward = std::min(own, bvh_.closest(s, own * (1 + 1e-9)).distance);
        if (map_.target)
            result.backward = map_.target->closest(q).distance;
        else if (displaced_alone)
            result.backward = mapped_distance(map_, q, at, point, parametric);
        else if (parametric > exact_from_) {
            result.backward = closest_.local(q, at);
            if (result.backward > search_from_) result.backward = closest_.global(q, result.backward);
        }
        return result;
    }

  private:
    const OutputTriangle& from_;
    Vec3d a_, b_, c_;
    const SurfaceMap<Family>& map_;
    const TriangleBvh& bvh_;
    const typename Family::Closest& closest_;
    double exact_from_, search_from_;
};

/// The samples of a triangle on a lattice with n intervals a side, rows from corner 0 on.
class SampleLattice {
  public:
    explicit SampleLattice(int n) : n_(n), at_(static_cast<std::size_t>((n + 1) * (n + 1))) {}

    template <class Visit>
    void for_each(Visit&& visit) {
        for (int j = 0; j <= n_; ++j)
            for (int i = 0; i + j <= n_; ++i) {
                if ((i == 0 && j == 0) || i == n_ || j == n_) continue;  // corners are on the surface
                visit(Vec2d(i, j) / static_cast<double>(n_), (*this)(i, j));
            }
    }
    /// Visits the samples above `least` that no neighbour exceeds.
    template <class Visit>
    void for_each_maximum(double Distances::*way, double least, Visit&& visit) {
        constexpr int k_neighbours[6][2] = {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}};
        for (int j = 0; j <= n_; ++j)
            for (int i = 0; i + j <= n_; ++i) {
                const double here = (*this)(i, j).*way;
                if (!(here > least)) continue;
                const bool top = std::ranges::all_of(k_neighbours, [&](const auto& d) {
                    const int x = i + d[0], y = j + d[1];
                    return x < 0 || y < 0 || x + y > n_ || (*this)(x, y).*way <= here;
                });
                if (top) visit(detail::Maximum{Vec2d(i, j) / static_cast<double>(n_), here});
            }
    }

  private:
    Distances& operator()(int i, int j) { return at_[static_cast<std::size_t>(j * (n_ + 1) + i)]; }
    int n_;
    std::vector<Distances> at_;
};

}  // namespace

template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, const typename Family::Closest& closest, std::uint64_t samples,
                      double tolerance, std::vector<double>& triangle_error, const RunContext& context) {
    const std::uint32_t count = static_cast<std::uint32_t>(mesh.triangles.size());
    triangle_error.assign(count, 0.0);
    if (count == 0) return {};
    const TriangleBvh bvh(mesh, context);
    const ControlMesh& control = map.patches->mesh();
    const int n = lattice_intervals(samples, count, k_least_intervals);
    constexpr double k_exact = 0.7;  // of the largest distance: from there on others are exact
    if (map.plain()) closest.prepare(context);
    const auto pass = [&](std::span<const std::uint32_t> triangles, std::uint32_t per_block, double exact_from,
                          double search_from) {
        const auto size = static_cast<std::uint32_t>(triangles.size());
        std::vector<Sums> sums((size + per_block - 1) / per_block);
        const auto blocks = static_cast<std::uint32_t>(sums.size());
        detail::for_each_batch(map.patches, blocks, 1, context, "measure", 0, 0.9, [&](std::uint32_t block) {
            Sums& sum = sums[block];
            SampleLattice lattice(n);
            for (std::uint32_t i = block * per_block; i < std::min(size, (block + 1) * per_block); ++i) {
                const std::uint32_t t = triangles[i];
                const OutputTriangle from = origin(t);
                const MeasuredTriangle<Family> triangle(mesh, t, from, map, bvh, closest, map.plain() ? exact_from : 0,
                                                        search_from);
                const double weight = triangle.area() / (n * n);
                Distances largest;
                const auto count_in = [&](const Distances& d) {
                    largest.forward = std::max(largest.forward, d.forward);
                    largest.backward = std::max(largest.backward, d.backward);
                    ++sum.samples;
                };
                lattice.for_each([&](const Vec2d& uv, Distances& here) {
                    here = triangle.at(uv);
                    count_in(here);
                    sum.weighted += weight * (here.forward + here.backward);
                    sum.squared += weight * (here.forward * here.forward + here.backward * here.backward);
                    sum.weight += 2 * weight;
                });
                const auto climb = [&](double Distances::*way, const detail::Maximum& top, double step) {
                    detail::local_maximum(
                        [&](const Vec2d& uv) {
                            const Distances d = triangle.at(uv);
                            count_in(d);
                            return d.*way;
                        },
                        top, step);
                };
                // Towards creases of finite sharpness.
                if (!from.fan.valid())
                    detail::for_each_strip_point<Family>(control, from.cell, [&](double b0, double b1, double b2) {
                        const Vec2d uv(b1, b2);
                        const Distances d = triangle.at(uv);
                        count_in(d);
                        if (!map.plain()) return;
                        double step = 1;
                        for (const double b : {b0, b1, b2})
                            if (b > 0) step = std::min(step, 0.5 * b);
                        for (const auto way : {&Distances::forward, &Distances::backward})
                            if (d.*way > exact_from) climb(way, {uv, d.*way}, step);
                    });
                if (map.plain())
                    for (const auto way : {&Distances::forward, &Distances::backward})
                        lattice.for_each_maximum(way, exact_from,
                                                 [&](const detail::Maximum& top) { climb(way, top, 0.5 / n); });
                sum.forward = std::max(sum.forward, largest.forward);
                sum.backward = std::max(sum.backward, largest.backward);
                triangle_error[t] = std::max(largest.forward, largest.backward);
            }
        });
        Sums total;
        for (const Sums& sum : sums) total += sum;
        return total;
    };
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    double exact_from = detail::k_climb_from * tolerance;
    // Of closest points that were looked for near by alone, those that decide are searched for all over the surface.
    // The largest first: what is found settles those that can be no larger.
    const auto search = [&](Sums& total) {
        if (!map.plain() || total.backward <= total.forward) return;
        std::vector<std::uint32_t> order = all;
        std::ranges::stable_sort(order, std::greater{}, [&](std::uint32_t t) { return triangle_error[t]; });
        double largest = total.forward;
        total.backward = 0;
        std::size_t begin = 0;
        for (std::size_t some = 4; begin < count && triangle_error[order[begin]] > largest; begin += some, some *= 2) {
            const Sums again =
                pass(std::span(order).subspan(begin, std::min(some, count - begin)), 1, exact_from, largest);
            total.backward = std::max(total.backward, again.backward);
            largest = std::max(largest, again.backward);
            total.samples += again.samples;
        }
        if (begin < count) total.backward = std::max(total.backward, triangle_error[order[begin]]);
    };
    // The largest error has to come from exact samples.
    const auto is_exact = [&](const Sums& sums) {
        return !map.plain() || sums.largest() == 0 || sums.largest() > exact_from;
    };
    Sums total = pass(all, k_block, exact_from, tolerance);
    while (!is_exact(total)) {
        exact_from = k_exact * total.largest();
        total = pass(all, k_block, exact_from, tolerance);
    }
    search(total);
    while (!is_exact(total)) {
        const double largest = total.largest();
        exact_from = k_exact * largest;
        total = pass(all, k_block, exact_from, std::min(tolerance, largest));
        search(total);
    }
    const std::uint64_t pairs = total.samples;
    if (map.target) total += measure_from_target(*map.target_mesh, mesh, bvh, samples, triangle_error, context);
    MeasuredError result;
    result.forward = total.forward;
    result.backward = total.backward;
    result.hausdorff = total.largest();
    if (total.weight > 0) {
        result.mean = total.weighted / total.weight;
        result.rms = std::sqrt(total.squared / total.weight);
    }
    result.forward_samples = total.samples;
    result.backward_samples = pairs;
    return result;
}

template MeasuredError measure<QuadFamily>(const TriangleMesh&, const std::function<OutputTriangle(std::uint32_t)>&,
                                           const SurfaceMap<QuadFamily>&, const QuadClosest&, std::uint64_t, double,
                                           std::vector<double>&, const RunContext&);
template MeasuredError measure<LoopFamily>(const TriangleMesh&, const std::function<OutputTriangle(std::uint32_t)>&,
                                           const SurfaceMap<LoopFamily>&, const LoopClosest&, std::uint64_t, double,
                                           std::vector<double>&, const RunContext&);

}  // namespace tetrakis
