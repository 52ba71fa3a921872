#include "../kit/random_mesh.hpp"

#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

// On regular meshes most schemes are box splines. The directions of a box spline define it: its values follow from
// splines with one direction less.

using namespace tetrakis;

namespace {

/// Multiplicities of the directions e1, e2, e1 + e2 and e1 - e2.
using SplineDirections = std::array<int, 4>;
constexpr std::array<std::array<int, 2>, 4> k_spline_direction{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

struct RegularSpline {
    std::string_view scheme;
    SplineDirections times;
    RuleOptions rules{};
};

std::vector<RegularSpline> regular_splines() {
    std::vector<RegularSpline> result = {
        {"loop", {2, 2, 2, 0}},
        {"loop", {2, 2, 2, 0}, {.loop_weights = LoopWeights::warren}},
        {"tuned-loop", {2, 2, 2, 0}},
        {"midpoint", {1, 1, 1, 0}},
        {"catmull-clark", {4, 4, 0, 0}},
        {"bilinear", {2, 2, 0, 0}},
        {"4-8", {2, 2, 2, 2}},
        {"doo-sabin", {3, 3, 0, 0}},
        {"doo-sabin-cc", {3, 3, 0, 0}},
        {"midedge", {1, 1, 1, 1}},
        {"midedge-simplest", {1, 1, 1, 1}},
        {"biquartic", {5, 5, 0, 0}},
    };
    for (int m = 0; m <= 4; ++m) result.push_back({"averaging", {m + 2, m + 2, 0, 0}, {.averaging_steps = m}});
    return result;
}

/// Values of the box spline of these directions whose support starts at the origin, at dyadic points. Where a spline
/// with few directions is discontinuous, the value is the limit from one side, always the same side.
class BoxSplineValues {
  public:
    double at(const SplineDirections& times, double x, double y) {
        // Outside the support. Only the last direction extends below y = 0.
        if (x < 0 || x > times[0] + times[2] + times[3] || y < -times[3] || y > times[1] + times[2]) return 0;
        const auto [known, is_new] = values_.try_emplace({times, x, y}, 0.0);
        if (!is_new) return known->second;
        return values_[{times, x, y}] = computed(times, x, y);
    }

  private:
    double computed(const SplineDirections& times, double x, double y) {
        std::vector<int> found;
        int total = 0;
        for (int d = 0; d < 4; ++d) {
            total += times[d];
            if (times[d] > 0) found.push_back(d);
        }
        // Coordinates, in the first two directions, of the point and of the side from which limits are taken.
        const auto& a = k_spline_direction[found[0]];
        const auto& b = k_spline_direction[found[1]];
        const double det = a[0] * b[1] - a[1] * b[0];
        const auto share = [&](double u, double v) {
            return std::array{(u * b[1] - v * b[0]) / det, (a[0] * v - a[1] * u) / det};
        };
        const auto t = share(x, y), side = share(1, 0.618);
        if (found.size() == 2)
            return univariate(times[found[0]], t[0], side[0]) * univariate(times[found[1]], t[1], side[1]) /
                   std::abs(det);
        // De Boor, Hoellig 1982: recurrence over the splines without one copy of each direction.
        double sum = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            const int d = found[i];
            SplineDirections fewer = times;
            --fewer[d];
            const double part = i < 2 ? t[i] : 0;
            if (part != 0) sum += part * at(fewer, x, y);
            if (part != times[d])
                sum += (times[d] - part) * at(fewer, x - k_spline_direction[d][0], y - k_spline_direction[d][1]);
        }
        return sum / (total - 2);
    }

    /// B-spline of an order, on [0, order].
    static double univariate(int order, double t, double side) {
        if (order == 1) return (t > 0 || (t == 0 && side > 0)) && (t < 1 || (t == 1 && side < 0)) ? 1 : 0;
        if (t < 0 || t > order) return 0;
        return (t * univariate(order - 1, t, side) + (order - t) * univariate(order - 1, t - 1, side)) / (order - 1);
    }

    struct Key {
        SplineDirections times;
        double x, y;
        auto operator<=>(const Key&) const = default;
    };
    std::map<Key, double> values_;
};

/// Control points on a grid over [0, k_cells]^2 with random heights. All schemes reproduce planes, so x and y of a
/// refined point are its parameters. The boundary does not influence the middle.
constexpr int k_cells = 10;
constexpr double k_middle = 1;  ///< half a side

struct NetOfHeights {
    ControlMesh mesh;
    double height(int x, int y) const { return mesh.positions()[static_cast<std::size_t>(y * (k_cells + 1) + x)].z; }
};

NetOfHeights height_grid(MeshFamily family) {
    test::Random random(5);
    ControlMeshData data = test::grid(k_cells, family == MeshFamily::triangles);
    for (Vec3d& p : data.positions) p.z = random.uniform(-1, 1);
    return {ControlMesh::build(std::move(data))};
}

/// Removes rounding from a coordinate, which is a multiple of a quarter of a cell.
double nearest_place(double x) { return std::round(x * 4) / 4; }

bool in_the_middle(const Vec3d& p) {
    // Coordinates are multiples of 1/4, so rounding does not decide whether a point is in the middle.
    return std::max(std::abs(p.x - k_cells / 2.0), std::abs(p.y - k_cells / 2.0)) < k_middle + 1e-6;
}

/// Weights of control points i - 2 to i + 2 or, at an end, of the two outside and the two inside.
struct SplineRow {
    int first = 0;
    std::vector<double> value, derivative;
};

/// Rows of a quartic spline with evenly reflected control points, at control point i. Its ends are moved inwards from
/// the control points. The first derivative is zero there, so `derivative` is the second one, towards greater i.
SplineRow quartic(int i, int count) {
    if (i > 0 && i + 1 < count)
        return {i - 2,
                {1.0 / 384, 76.0 / 384, 230.0 / 384, 76.0 / 384, 1.0 / 384},
                {-1.0 / 48, -22.0 / 48, 0, 22.0 / 48, 1.0 / 48}};
    const double sign = i == 0 ? 1 : -1;
    return {
        i == 0 ? -2 : i - 1, {1.0 / 24, 11.0 / 24, 11.0 / 24, 1.0 / 24}, {sign / 2, -sign / 2, -sign / 2, sign / 2}};
}

int reflected(int i, int count) { return i < 0 ? -1 - i : i >= count ? 2 * count - 1 - i : i; }

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("regular meshes: limit points are values of the scheme's box spline") {
    for (const auto& [name, times, rules] : regular_splines()) {
        CAPTURE(name);
        CAPTURE(rules.averaging_steps);
        const NetOfHeights grid = height_grid(scheme_named(name).family);
        // The support is centred at the control point.
        const auto half_support = [&](int axis) {
            int sum = 0;
            for (int d = 0; d < 4; ++d) sum += times[d] * k_spline_direction[d][axis];
            return sum / 2.0;
        };
        BoxSplineValues spline;
        for (const int level : {0, 1}) {
            CAPTURE(level);
            double apart = 0;
            int compared = 0;
            const PolygonMesh limit = refine(grid.mesh, name, level, {.rules = rules, .limit = true});
            for (const Vec3d& p : limit.positions) {
                if (!in_the_middle(p)) continue;
                const double x = nearest_place(p.x), y = nearest_place(p.y);
                double height = 0;
                for (int j = 0; j <= k_cells; ++j)
                    for (int i = 0; i <= k_cells; ++i) {
                        if (std::max(std::abs(i - x), std::abs(j - y)) > 4) continue;
                        height +=
                            grid.height(i, j) * spline.at(times, x - i + half_support(0), y - j + half_support(1));
                    }
                apart = std::max({apart, std::abs(p.x - x), std::abs(p.y - y), std::abs(p.z - height)});
                ++compared;
            }
            CHECK(apart < 1e-12);
            CHECK(compared >= (level == 0 ? 9 : 16));
        }
    }
}

TEST_CASE("regular meshes: biquartic limits up to the boundary are the even spline's, normals included") {
    constexpr int k_side = 7;
    const ControlMeshData data = test::skewed_grid(k_side - 1);
    const ControlMesh mesh = ControlMesh::build(data);
    const PolygonMesh limit = refine(mesh, "biquartic", 0, {.limit = true, .normals = true});
    double apart = 0, tilted = 0;
    for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
            const SplineRow u = quartic(x, k_side), v = quartic(y, k_side);
            Vec3d position(0), along_u(0), along_v(0);
            for (std::size_t j = 0; j < v.value.size(); ++j)
                for (std::size_t i = 0; i < u.value.size(); ++i) {
                    const int px = reflected(u.first + static_cast<int>(i), k_side),
                              py = reflected(v.first + static_cast<int>(j), k_side);
                    const Vec3d p = data.positions[py * k_side + px];
                    position += u.value[i] * v.value[j] * p;
                    along_u += u.derivative[i] * v.value[j] * p;
                    along_v += u.value[i] * v.derivative[j] * p;
                }
            const std::size_t at = static_cast<std::size_t>(y) * k_side + x;
            apart = std::max(apart, glm::length(position - limit.positions[at]));
            tilted = std::max(tilted, glm::length(glm::normalize(glm::cross(along_u, along_v)) - limit.normals[at]));
        }
    CHECK(apart < 1e-12);
    CHECK(tilted < 1e-12);
}

TEST_CASE("regular meshes: each scheme has its box spline, or is known to have none") {
    std::set<std::string_view> known = {"butterfly", "modified-butterfly", "kobbelt", "sqrt3", "honeycomb"};
    for (const RegularSpline& spline : regular_splines()) known.insert(spline.scheme);
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        CHECK(known.contains(scheme.name));
    }
}

TEST_SUITE_END();
