#pragma once

#include "../../hier/forest/exported_triangles.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../surface/local_frame.hpp"
#include "output_triangle.hpp"
#include "shading_normals.hpp"
#include "tessellate.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace tetrakis::detail {

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

}  // namespace tetrakis::detail
