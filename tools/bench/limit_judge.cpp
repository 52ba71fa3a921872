#include "limit_judge.hpp"

#include "../../tests/kit/osd_refiner.hpp"
#include "../../tests/kit/random_mesh.hpp"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace tetrakis::bench {

namespace {

namespace Bfr = OpenSubdiv::Bfr;

constexpr std::size_t k_block = 4096;  // samples between two checks of the largest distance so far

/// Calls body(i) for all i until `stop` is set. The first calls are already spread over the whole range.
template <class Body>
void for_each_spread(std::size_t count, const std::atomic<bool>& stop, const Body& body) {
    const std::size_t stride = std::max<std::size_t>(1, count / k_block);
    oneapi::tbb::parallel_for(std::size_t{0}, stride, [&](std::size_t first) {
        for (std::size_t i = first; i < count && !stop.load(std::memory_order_relaxed); i += stride) body(i);
    });
}

void raise(std::atomic<double>& largest, double value) {
    double old = largest.load(std::memory_order_relaxed);
    while (value > old && !largest.compare_exchange_weak(old, value)) {
    }
}

}  // namespace

/// Patches of the limit surface: one for each face, or for each corner of a face that Bfr splits.
struct LimitJudge::Surfaces {
    struct Patch {
        std::uint32_t surface;
        int sub;  ///< -1: the whole face
    };
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    std::unique_ptr<Bfr::RefinerSurfaceFactory<>> factory;  // its cache is shared by the surfaces
    std::vector<Bfr::Surface<double>> surfaces;
    std::vector<std::vector<double>> points;
    std::vector<Patch> patches;

    Surfaces(const ControlMeshData& data, SchemeKind scheme, BfrLevels levels)
        : refiner(test::osd_refiner(data, scheme, false)),
          factory(std::make_unique<Bfr::RefinerSurfaceFactory<>>(*refiner, bfr_options(levels))) {
        std::vector<double> control;
        for (const Vec3d& p : data.positions) control.insert(control.end(), {p.x, p.y, p.z});
        for (int f = 0; f < refiner->GetLevel(0).GetNumFaces(); ++f) {
            Bfr::Surface<double> surface;
            if (!factory->InitVertexSurface(f, &surface)) continue;
            const auto index = static_cast<std::uint32_t>(surfaces.size());
            const bool split = surface.GetParameterization().HasSubFaces();
            for (int sub = 0; sub < (split ? surface.GetFaceSize() : 1); ++sub)
                patches.push_back({index, split ? sub : -1});
            points.emplace_back(3 * static_cast<std::size_t>(surface.GetNumPatchPoints()));
            surface.PreparePatchPoints(control.data(), 3, points.back().data(), 3);
            surfaces.push_back(std::move(surface));
        }
    }
    bool is_triangle(const Patch& patch) const {
        return surfaces[patch.surface].GetParameterization().GetType() == Bfr::Parameterization::TRI;
    }
    void evaluate(const Patch& patch, double u, double v, Vec3d& p, Vec3d* du = nullptr, Vec3d* dv = nullptr) const {
        const auto& surface = surfaces[patch.surface];
        const double local[2] = {u, v};
        double uv[2] = {u, v};
        // The parameters of a quarter run half as fast as the face's. Derivatives only serve as directions of steps in
        // the quarter's parameters, so they are scaled here.
        if (patch.sub >= 0) surface.GetParameterization().ConvertNormalizedSubFaceToCoord(patch.sub, local, uv);
        const double* control = points[patch.surface].data();
        if (du == nullptr) {
            surface.Evaluate(uv, control, 3, &p.x);
            return;
        }
        surface.Evaluate(uv, control, 3, &p.x, &du->x, &dv->x);
        if (patch.sub >= 0) {
            *du *= 0.5;
            *dv *= 0.5;
        }
    }
};

LimitJudge::LimitJudge(const ControlMeshData& data, SchemeKind scheme, std::uint64_t samples)
    : surfaces_(std::make_unique<Surfaces>(data, scheme, k_judge_levels)) {
    const Surfaces& s = *surfaces_;
    // m intervals on each side: (m + 1)^2 points for a quad, half as many for a triangle.
    const double share = static_cast<double>(samples) / static_cast<double>(std::max<std::size_t>(1, s.patches.size()));
    const int m = std::max(2, static_cast<int>(std::ceil(std::sqrt(share * (scheme == SchemeKind::loop ? 2 : 1)))));
    intervals_ = m;
    test::Random random(0);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::uint32_t patch_number = 0; patch_number < s.patches.size(); ++patch_number) {
        const auto& patch = s.patches[patch_number];
        const bool triangle = s.is_triangle(patch);
        const auto first = static_cast<std::uint32_t>(grid_.size());
        const auto index = [&](int i, int j) {
            const int row = triangle ? j * (m + 1) - j * (j - 1) / 2 : j * (m + 1);
            return first + static_cast<std::uint32_t>(row + i);
        };
        for (int j = 0; j <= m; ++j)
            for (int i = 0; i <= (triangle ? m - j : m); ++i) {
                const double u = static_cast<double>(i) / m, v = static_cast<double>(j) / m;
                s.evaluate(patch, u, v, grid_.emplace_back());
                grid_uv_.push_back({static_cast<float>(u), static_cast<float>(v)});
            }
        const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            triangles.push_back({a, b, c});
            grid_patch_.push_back(patch_number);
        };
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < (triangle ? m - j : m); ++i) {
                const double a = random.uniform(), b = random.uniform();
                const bool corner = triangle && i + j == m - 1;  // half a cell
                const bool fold = corner && a + b > 1;
                s.evaluate(patch, (i + (fold ? 1 - a : a)) / m, (j + (fold ? 1 - b : b)) / m, jittered_.emplace_back());
                add(index(i, j), index(i + 1, j), index(i, j + 1));
                if (!corner) add(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
            }
    }
    Box3d box = bounding_box(grid_);
    box.add(bounding_box(jittered_));
    diagonal_ = box.diagonal();
    sampled_ = std::make_unique<NearestTriangle>(grid_, std::move(triangles));
    std::atomic<double> largest = 0;
    const std::atomic<bool> never = false;
    for_each_spread(jittered_.size(), never,
                    [&](std::size_t i) { raise(largest, sampled_->nearest(jittered_[i]).distance); });
    sampled_error_ = largest;
}

LimitJudge::~LimitJudge() = default;

double LimitJudge::own_error(const ControlMeshData& data, SchemeKind scheme, BfrLevels levels) const {
    // Intervals on each side of a face or quarter. Odd: Bfr is exact at dyadic parameters, from the level on that has
    // them as vertices.
    constexpr int k_grid = 11;
    const Surfaces tried(data, scheme, levels);
    double largest = 0;
    for (const Surfaces::Patch& patch : surfaces_->patches)
        for (int j = 0; j <= k_grid; ++j)
            for (int i = 0; i <= (surfaces_->is_triangle(patch) ? k_grid - j : k_grid); ++i) {
                const double u = static_cast<double>(i) / k_grid, v = static_cast<double>(j) / k_grid;
                Vec3d p, du, dv, q;
                surfaces_->evaluate(patch, u, v, p, &du, &dv);
                tried.evaluate(patch, u, v, q);
                const Vec3d normal = glm::cross(du, dv);
                const double length = glm::length(normal);
                if (length > 0) largest = std::max(largest, std::abs(glm::dot(q - p, normal)) / length);
            }
    return largest;
}

double LimitJudge::limit_to_mesh(const NearestTriangle& mesh, double enough) const {
    std::atomic<double> largest = 0;
    std::atomic<bool> stop = false;
    const auto measure = [&](const std::vector<Vec3d>& points) {
        for_each_spread(points.size(), stop, [&](std::size_t i) {
            const double distance = mesh.nearest(points[i]).distance;
            raise(largest, distance);
            if (distance > enough) stop = true;
        });
    };
    measure(grid_);
    measure(jittered_);
    return largest;
}

/// A point of the limit surface that descends to the nearest point.
struct LimitJudge::Foot {
    const Surfaces::Patch* patch = nullptr;
    bool triangle = false;
    double u = 0, v = 0;
    double distance = 0;

    void clamp(double& x, double& y) const {
        if (triangle && x + y > 1) {
            const double over = (x + y - 1) / 2;
            x -= over, y -= over;
        }
        x = std::clamp(x, 0.0, 1.0);
        y = std::clamp(y, 0.0, triangle ? 1 - x : 1.0);
    }
};

LimitJudge::Foot LimitJudge::start_at(const NearestTriangle::Hit& hit, const Vec3d& point) const {
    Foot foot;
    foot.patch = &surfaces_->patches[grid_patch_[hit.triangle]];
    foot.triangle = surfaces_->is_triangle(*foot.patch);
    const auto& corners = sampled_->triangle(hit.triangle);
    for (int c = 0; c < 3; ++c) {
        foot.u += hit.weights[c] * grid_uv_[corners[c]][0];
        foot.v += hit.weights[c] * grid_uv_[corners[c]][1];
    }
    foot.clamp(foot.u, foot.v);
    Vec3d p;
    surfaces_->evaluate(*foot.patch, foot.u, foot.v, p);
    foot.distance = glm::length(p - point);
    return foot;
}

/// Pattern search: steps in eight directions, halved if none reduces the distance. It needs no derivatives, which do
/// not help at extraordinary corners and at folds of the surface.
void LimitJudge::descend(Foot& foot, const Vec3d& point, double enough) const {
    constexpr int k_halvings = 30, k_most_moves = 16;
    double size = 1.0 / intervals_;
    for (int halving = 0; halving < k_halvings && foot.distance > enough; ++halving, size /= 2)
        for (int move = 0; move < k_most_moves; ++move) {
            const double u = foot.u, v = foot.v, before = foot.distance;
            for (int i = -1; i <= 1; ++i)
                for (int j = -1; j <= 1; ++j) {
                    double x = u + i * size, y = v + j * size;
                    foot.clamp(x, y);
                    if (x == u && y == v) continue;
                    Vec3d p;
                    surfaces_->evaluate(*foot.patch, x, y, p);
                    const double distance = glm::length(p - point);
                    if (distance < foot.distance) foot.distance = distance, foot.u = x, foot.v = y;
                }
            if (foot.distance == before) break;
        }
}

/// Descends first from the nearest sampled triangle. If the distance is still above `enough`, it descends in every
/// patch that can contain the nearest point: the patch that is nearest in the grid may be another one.
double LimitJudge::distance_to_limit(const Vec3d& point, const NearestTriangle::Hit& nearest, double enough) const {
    constexpr std::size_t k_starts = 4;  // in each patch
    Foot best = start_at(nearest, point);
    descend(best, point, enough);
    if (best.distance <= enough) return best.distance;
    std::vector<std::pair<const Surfaces::Patch*, std::vector<Foot>>> starts;
    for (const auto& hit : sampled_->within(point, nearest.distance + 2 * sampled_error_)) {
        const Foot foot = start_at(hit, point);
        auto of_patch =
            std::find_if(starts.begin(), starts.end(), [&](const auto& s) { return s.first == foot.patch; });
        if (of_patch == starts.end()) of_patch = starts.insert(starts.end(), {foot.patch, {}});
        auto& feet = of_patch->second;
        const double apart = 2.0 / intervals_;
        const bool new_place = std::none_of(feet.begin(), feet.end(), [&](const Foot& other) {
            return std::abs(other.u - foot.u) < apart && std::abs(other.v - foot.v) < apart;
        });
        if (feet.size() >= k_starts || !new_place) continue;
        feet.push_back(foot);
    }
    for (auto& [patch, feet] : starts)
        for (Foot& foot : feet) {
            descend(foot, point, enough);
            if (foot.distance < best.distance) best = foot;
            if (best.distance <= enough) return best.distance;
        }
    return best.distance;
}

double LimitJudge::mesh_to_limit(const std::vector<Vec3d>& points,
                                 const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                 std::uint64_t samples) const {
    double area = 0;
    const auto area_of = [&](const std::array<std::uint32_t, 3>& t) {
        return 0.5 * glm::length(glm::cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]));
    };
    for (const auto& t : triangles) area += area_of(t);
    std::vector<Vec3d> spread;
    for (const auto& t : triangles) {
        // m intervals on each side; m is even, so that edge midpoints are samples.
        const double wanted = static_cast<double>(samples) * (area > 0 ? area_of(t) / area : 0);
        const int m = 2 * std::clamp(static_cast<int>(std::ceil(std::sqrt(wanted * 2) / 2)), 1, 500);
        for (int j = 0; j <= m; ++j)
            for (int i = 0; i + j <= m; ++i) {
                const double u = static_cast<double>(i) / m, v = static_cast<double>(j) / m;
                spread.push_back((1 - u - v) * points[t[0]] + u * points[t[1]] + v * points[t[2]]);
            }
        spread.push_back((points[t[0]] + points[t[1]] + points[t[2]]) / 3.0);
    }

    std::vector<NearestTriangle::Hit> hits(spread.size());
    const std::atomic<bool> never = false;
    for_each_spread(spread.size(), never, [&](std::size_t i) { hits[i] = sampled_->nearest(spread[i]); });
    std::vector<std::uint32_t> order(spread.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return hits[a].distance != hits[b].distance ? hits[a].distance > hits[b].distance : a < b;
    });
    // A point cannot have the largest distance if its distance to the sampled surface plus that surface's error is
    // below the largest distance so far.
    std::atomic<double> largest = 0;
    for_each_spread(order.size(), never, [&](std::size_t at) {
        const std::uint32_t i = order[at];
        const double known = largest.load(std::memory_order_relaxed);
        if (hits[i].distance + sampled_error_ > known) raise(largest, distance_to_limit(spread[i], hits[i], known));
    });
    return largest;
}

}  // namespace tetrakis::bench
