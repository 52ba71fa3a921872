#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_kind.hpp"

#include <cstdint>
#include <vector>

// Which sites the face corners of a uniformly refined mesh are, from the documented order of its faces.
namespace tetrakis::test {

/// Sites of all face corners of refine_uniform(mesh, scheme, levels), in the order of `face_vertices`; holes left out.
/// Catmull-Clark: levels >= 1.
inline std::vector<Site> uniform_sites(const ControlMesh& mesh, SchemeKind scheme, int levels) {
    const bool quads = scheme == SchemeKind::catmull_clark;
    const int depth = quads ? levels - 1 : levels;
    const std::uint32_t cell = 1u << depth;  // side of a site's root
    std::vector<Site> sites;
    const auto emit = [&](HalfedgeId first, bool four_cells, std::uint32_t x, std::uint32_t y) {
        if (!four_cells) {
            sites.push_back({first, {x, y}, static_cast<std::uint8_t>(depth)});
            return;
        }
        // Four corner cells make a face, each turned by a quarter.
        const std::uint32_t n = 2 * cell;
        for (std::uint32_t corner = 0; corner < 4; ++corner) {
            if (x <= cell && y <= cell) {
                sites.push_back({HalfedgeId(first.value + corner), {x, y}, static_cast<std::uint8_t>(depth)});
                return;
            }
            const std::uint32_t turned = n - x;
            x = y;
            y = turned;
        }
    };
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        if (mesh.is_hole(FaceId(f))) continue;
        const HalfedgeId first = mesh.face_halfedge(FaceId(f));
        const bool whole = quads && mesh.face_size(FaceId(f)) == 4;  // else quads are at its corners
        const std::uint32_t roots = quads && !whole ? mesh.face_size(FaceId(f)) : 1, n = whole ? 2 * cell : cell;
        for (std::uint32_t i = 0; i < roots; ++i)
            for (std::uint32_t y = 0; y < n; ++y)
                for (std::uint32_t x = 0; x < (quads ? n : n - y); ++x) {
                    const HalfedgeId root(first.value + i);
                    emit(root, whole, x, y);
                    emit(root, whole, x + 1, y);
                    if (quads) emit(root, whole, x + 1, y + 1);
                    emit(root, whole, x, y + 1);
                    if (quads || x + y + 1 == n) continue;
                    emit(root, whole, x + 1, y);
                    emit(root, whole, x + 1, y + 1);
                    emit(root, whole, x, y + 1);
                }
    }
    return sites;
}

}  // namespace tetrakis::test
