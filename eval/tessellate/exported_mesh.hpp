#pragma once

#include "../../hier/forest/exported_triangles.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../distance/surface_family.hpp"
#include "../surface/local_frame.hpp"
#include "shading_normals.hpp"
#include "tessellate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <type_traits>
#include <vector>

namespace tetrakis {

/// Where a triangle of the output comes from: a triangle of the hierarchy, or one of a face's fan (eval/README.md).
struct OutputTriangle {
    CellTriangle cell;                          ///< unless it belongs to a fan
    FaceId fan;                                 ///< the face; invalid for triangles of the hierarchy
    std::array<std::uint32_t, 3> fan_corner{};  ///< corners of the face, by number in it

    /// The surface point that belongs to barycentrics (b0, b1, b2). A fan's triangles lie in the regular polygon whose
    /// corners are the face's, each root over its sector of it.
    template <class Family>
    SurfaceParameter parameter(const ControlMesh& mesh, double b0, double b1, double b2) const {
        if (!fan.valid()) return Family::parameter(mesh, cell, b0, b1, b2);
        const std::uint32_t n = mesh.face_size(fan);
        const double turn = 2 * std::numbers::pi / n;
        const double b[3] = {b0, b1, b2};
        double x = 0, y = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            x += b[k] * std::cos(turn * fan_corner[k]);
            y += b[k] * std::sin(turn * fan_corner[k]);
        }
        double angle = std::atan2(y, x);
        if (angle < 0) angle += 2 * std::numbers::pi;
        const std::uint32_t sector = std::min(n - 1, static_cast<std::uint32_t>(angle / turn));
        const double c0 = std::cos(turn * sector), s0 = std::sin(turn * sector);
        const double c1 = std::cos(turn * (sector + 1)), s1 = std::sin(turn * (sector + 1));
        const double det = c0 * s1 - c1 * s0;
        // Corners and sides are met exactly: trees would grow down to the last bits beside them.
        const auto rounded = [](double value) { return std::round(std::max(0.0, value) * 0x1p40) * 0x1p-40; };
        const double v = rounded((x * s1 - y * c1) / det), w = rounded((y * c0 - x * s0) / det);
        const double sum = std::max(1.0, v + w);
        const CellTriangle root = root_triangle(HalfedgeId(mesh.face_halfedge(fan).value + sector));
        return Family::parameter(mesh, root, v / sum, w / sum, 1 - (v + w) / sum);
    }
    /// An address of corner k inside one root.
    template <class Family>
    Site corner_site(const ControlMesh& mesh, std::size_t k) const {
        if (!fan.valid()) return Family::corner_site(mesh, cell, k);
        return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]), {0, 0}, 0};
    }
    /// An address of a point inside the triangle near corner k: `steps` of 2^finer from the corner towards each of the
    /// two others. Of a fan's triangle, in the corner's own root. @param finer  levels below the triangle's
    template <class Family>
    Site inner_site(const ControlMesh& mesh, std::size_t k, int finer, std::uint32_t steps) const {
        if (fan.valid())
            return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]),
                    {steps, steps},
                    static_cast<std::uint8_t>(finer)};
        const LatticePoint a = cell.corner[k], b = cell.corner[(k + 1) % 3], c = cell.corner[(k + 2) % 3];
        const std::uint32_t rest = (1u << finer) - 2 * steps;
        const LatticePoint p{rest * a.x + steps * (b.x + c.x), rest * a.y + steps * (b.y + c.y)};
        return Family::lattice_site(mesh, cell.root, p, cell.level + finer);
    }
};

namespace detail {

/// What a refined hierarchy looks like from outside, and where each of its triangles comes from.
template <class Family>
struct ExportedMesh : ExportedTriangles {
    using Hierarchy = typename Family::Hierarchy;

    std::vector<std::uint8_t> part;  ///< which of its leaf's or fan's triangles each is

    ExportedMesh() = default;
    /// @param fans  of which the hierarchy has accepted some; empty where it has none
    ExportedMesh(const Hierarchy& hierarchy, const FanChoice& fans)
        : ExportedTriangles(triangles_of(hierarchy, fans)), part(triangles.size(), 0) {
        // A fan's or a green leaf's triangles stand next to each other.
        for (std::size_t t = 1; t < part.size(); ++t)
            if (leaves[t - 1] == leaves[t] && (leaves[t].valid() || faces[t - 1] == faces[t]))
                part[t] = static_cast<std::uint8_t>(part[t - 1] + 1);
    }

    OutputTriangle origin(const Hierarchy& hierarchy, const FanChoice& fans, std::uint32_t t) const {
        OutputTriangle from;
        if (leaves[t].valid()) {
            std::array<CellTriangle, 3> parts;
            hierarchy.triangles(leaves[t], parts);
            from.cell = parts[part[t]];
            return from;
        }
        from.fan = faces[t];
        const auto corners = fans.of(from.fan)[part[t]];
        for (std::size_t k = 0; k < 3; ++k) from.fan_corner[k] = corners[k];
        return from;
    }

    /// Tells the result the face and the error of each triangle, and the deepest level.
    template <class Refinement>
    void describe(const Hierarchy& hierarchy, const Refinement& refinement, Tessellation& result) const {
        const std::size_t count = leaves.size();
        result.triangle_face.resize(count);
        result.triangle_error.resize(count);
        result.deepest_level = 0;
        for (std::size_t t = 0; t < count; ++t) {
            const LeafId leaf = leaves[t];
            result.triangle_face[t] = faces[t].value;
            result.triangle_error[t] = round_up(leaf.valid() ? refinement.error(leaf) : hierarchy.fan_error(faces[t]));
            if (leaf.valid()) result.deepest_level = std::max(result.deepest_level, hierarchy.level(leaf));
        }
    }

  private:
    static ExportedTriangles triangles_of(const Hierarchy& hierarchy, const FanChoice& fans) {
        if constexpr (std::is_same_v<Family, QuadFamily>)
            if (!fans.offsets.empty()) return hierarchy.forest().exported(fans, hierarchy.fans());
        return hierarchy.forest().exported();
    }
};

/// Limit normals at the corners of triangles, each seen from inside its triangle: continued linearly from two points
/// near by.
/// @param origin   (triangle) its OutputTriangle
/// @param normals  (canonical sites, receives their limit normals)
template <class Family, class Origin, class Normals>
SideNormals normals_from_inside(const ControlMesh& mesh, Origin&& origin, Normals&& normals) {
    return [&mesh, origin, normals](std::span<const std::uint64_t> corners, std::span<Vec3d> out) {
        // 2^-8 of a triangle: what is left of its bend after continuing is below a thousandth of it.
        constexpr int k_finer = 8, k_least = 3;
        std::vector<Site> sites;
        std::vector<std::size_t> place;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const OutputTriangle from = origin(static_cast<std::uint32_t>(corners[i] / 3));
            const int finer = std::min(k_finer, k_max_level - (from.fan.valid() ? 0 : from.cell.level));
            if (finer < k_least) continue;
            for (const std::uint32_t steps : {1u, 2u})
                sites.push_back(
                    Family::canonical_site(mesh, from.template inner_site<Family>(mesh, corners[i] % 3, finer, steps)));
            place.push_back(i);
        }
        std::vector<Vec3d> found(sites.size());
        normals(std::span<const Site>(sites), std::span<Vec3d>(found));
        for (std::size_t j = 0; j < place.size(); ++j)
            out[place[j]] = unit_or_zero(2.0 * found[2 * j] - found[2 * j + 1]);
    };
}

}  // namespace detail

}  // namespace tetrakis
