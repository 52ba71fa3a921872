#pragma once

#include "../../hier/forest/corner_cell.hpp"
#include "../../refine/adaptive/family_addresses.hpp"
#include "../../refine/adaptive/hierarchy_view.hpp"
#include "../bounds/cell_bounder.hpp"
#include "../patches/quad_patches.hpp"
#include "../surface/surface_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis {

/// The root parameters of a triangle's point with barycentrics (b0, b1, b2); the root's sides have length 1.
inline std::array<double, 2> point_of(const CellTriangle& t, double b0, double b1, double b2) {
    const double unit = std::ldexp(1.0, -t.level);
    return {(b0 * t.corner[0].x + b1 * t.corner[1].x + b2 * t.corner[2].x) * unit,
            (b0 * t.corner[0].y + b1 * t.corner[1].y + b2 * t.corner[2].y) * unit};
}

/// Types and functions of the quad family for tessellation: Catmull-Clark on the 4-8 bisection forest.
struct QuadFamily : QuadAddresses {
    using Patches = QuadPatches;
    using Bounder = QuadBounder;
    using Hierarchy = BisectionHierarchy;

    /// The point of a leaf with barycentrics (b0, b1, b2).
    static SurfaceParameter parameter(const ControlMesh& mesh, const CellTriangle& t, double b0, double b1, double b2) {
        const auto [x, y] = point_of(t, b0, b1, b2);
        if (x > 1 && t.corner[1].x == 2 && t.level == 0)
            return {mesh.next(t.root), std::min(y, 1.0), std::clamp(2 - x, 0.0, 1.0)};
        return {t.root, std::clamp(x, 0.0, 1.0), std::clamp(y, 0.0, 1.0)};
    }
    /// Moves parameters outside a root into the root beyond that side; on boundaries, onto the side.
    static void cross_sides(const ControlMesh& mesh, SurfaceParameter& at) {
        for (int crossing = 0; crossing < 3; ++crossing) {
            const bool below = std::min(at.x, at.y) < 0;
            if (!below && std::max(at.x, at.y) <= 1) break;
            const bool by_x = below ? at.x < 0 : at.x > 1;
            const CellSide side = by_x ? (below ? CellSide::prev_edge : CellSide::next_cell)
                                       : (below ? CellSide::edge : CellSide::prev_cell);
            const HalfedgeId beyond = across(mesh, at.root, side);
            if (!beyond.valid() || mesh.is_hole(mesh.face(beyond))) break;
            // The roots' frames differ by a quarter turn about their common corner (0, 0) or (1, 1).
            const double twice = below ? 0 : 2;
            at = by_x ? SurfaceParameter{beyond, at.y, twice - at.x} : SurfaceParameter{beyond, twice - at.y, at.x};
        }
        at.x = std::clamp(at.x, 0.0, 1.0);
        at.y = std::clamp(at.y, 0.0, 1.0);
    }
};

/// The triangle family: Loop on red-green triangle quadtrees.
struct LoopFamily : TriangleAddresses {
    using Patches = LoopPatches;
    using Bounder = LoopBounder;
    using Hierarchy = TriangleHierarchy;

    static SurfaceParameter parameter(const ControlMesh&, const CellTriangle& t, double b0, double b1, double b2) {
        const auto [x, y] = point_of(t, b0, b1, b2);
        return {t.root, std::clamp(x, 0.0, 1.0), std::clamp(y, 0.0, 1.0 - std::clamp(x, 0.0, 1.0))};
    }
    static void cross_sides(const ControlMesh& mesh, SurfaceParameter& at) {
        std::array<double, 3> b{1 - at.x - at.y, at.x, at.y};
        for (int crossing = 0; crossing < 3; ++crossing) {
            const std::size_t out = static_cast<std::size_t>(std::min_element(b.begin(), b.end()) - b.begin());
            if (b[out] >= 0) break;
            // Beyond the edge (a, b) opposite corner `out` the lattice continues: its corner there is a + b - out.
            const std::uint32_t h0 = mesh.face_halfedge(mesh.face(at.root)).value;
            const std::size_t from = (out + 1) % 3;
            const HalfedgeId t = mesh.twin(HalfedgeId(h0 + static_cast<std::uint32_t>(from)));
            if (!t.valid() || mesh.is_hole(mesh.face(t))) break;
            const double d = -b[out], start = b[from] - d, end = b[(from + 1) % 3] - d;
            const HalfedgeId root = mesh.face_halfedge(mesh.face(t));
            const std::size_t k = t.value - root.value;  // t starts at our edge's end
            b[k] = end, b[(k + 1) % 3] = start, b[(k + 2) % 3] = d;
            at.root = root;
        }
        double sum = 0;
        for (double& w : b) sum += w = std::max(w, 0.0);
        at.x = b[1] / sum, at.y = b[2] / sum;
    }
};

/// Distance from q to a nearby point of a surface: Gauss-Newton from `at`, across roots but not across the boundary.
/// The result is at most the distance to the start, and at least the distance to the surface.
/// @param evaluate  (SurfaceParameter) gives a SurfacePoint
template <class Family, class Evaluate>
double nearby_distance(const ControlMesh& mesh, const Vec3d& q, SurfaceParameter at, Evaluate&& evaluate) {
    // Four steps reach rounding from a start near the solution; the others are for slow convergence.
    constexpr int k_steps = 8, k_halvings = 4;
    // The iteration ends if the line from q to the surface point is nearly normal: the squared sine of their angle is
    // below this. A further step would change the distance by half of that share.
    constexpr double k_square = 1e-8;
    SurfacePoint s = evaluate(at);
    double best = glm::length(q - s.position);
    for (int step = 0; step < k_steps; ++step) {
        if (!s.has_derivatives) {
            // Extraordinary points have no derivatives: those of a point a little further inside replace them.
            constexpr double k_inside = 1e-3;
            const Vec3d position = s.position;
            s = evaluate(
                {at.root, at.x + k_inside * (Family::k_middle - at.x), at.y + k_inside * (Family::k_middle - at.y)});
            s.position = position;
        }
        Vec2d newton(0);
        if (detail::tangent_step(s, q, newton.x, newton.y)) {
            const Vec3d way = newton.x * s.du + newton.y * s.dv;
            if (glm::dot(way, way) < k_square * best * best) return best;
        }
        // If the Newton step comes no nearer, as on boundaries, or fails: steps along the root's sides.
        const auto along = [&](const Vec3d& side) {
            const double square = glm::dot(side, side);
            return square > 0 ? glm::dot(side, q - s.position) / square : 0.0;
        };
        const std::array<Vec2d, 4> moves = {newton, Vec2d(along(s.du), 0), Vec2d(0, along(s.dv)),
                                            along(s.dv - s.du) * Vec2d(-1, 1)};
        const SurfaceParameter from = at;
        const double before = best;
        for (Vec2d move : moves) {
            // Steps are at most half a root: the linearisation is of no use farther away.
            const double length = std::max(std::abs(move.x), std::abs(move.y));
            if (length > 0.5) move *= 0.5 / length;
            for (int halving = 0; halving < k_halvings && best == before && length > 0; ++halving, move *= 0.5) {
                at = {from.root, from.x + move.x, from.y + move.y};
                Family::cross_sides(mesh, at);
                s = evaluate(at);
                best = std::min(best, glm::length(q - s.position));
            }
        }
        if (best >= before * (1 - 1e-9)) return best;
    }
    return best;
}

}  // namespace tetrakis
