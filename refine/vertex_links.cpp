#include "tetrakis/refine/vertex_links.hpp"

#include "tetrakis/hier/error.hpp"

#include <array>
#include <string>
#include <vector>

namespace tetrakis::detail {

VertexRoots vertex_roots(const ControlMesh& control, const RuleMesh& mesh, std::span<const CellFrame> frames,
                         std::span<const FaceId> root_face) {
    const auto refuse = [&](int v, const char* what) {
        throw Error(
            ErrorCode::unsupported,
            "vertex quadtrees need four children of every vertex; vertex " + std::to_string(v) + " of level 1 " + what,
            control.data().source);
    };
    VertexRoots roots;
    const std::size_t count = static_cast<std::size_t>(mesh.vertex_count());
    std::vector<std::array<int, 4>> corners(count);
    std::vector<signed char> corner_of(mesh.halfedge_count(), 0);
    roots.link.assign(4 * count, VertexRoots::outside);
    roots.face.resize(count);
    roots.hole.resize(count);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        corners[v] = vertex_corners(mesh, frames[v]);
        int faces = 0;
        for (int c = 0; c < 4; ++c) {
            const int h = corners[v][c];
            if (h == RuleMesh::none) continue;
            ++faces;
            corner_of[h] = static_cast<signed char>(c);
            if (mesh.sharp(h) && mesh.twin(h) != RuleMesh::none) refuse(v, "lies on a crease inside the mesh");
        }
        const RuleMesh::Ring ring = mesh.ring(v);
        const bool tip = faces == 1 && !ring.closed, side = faces == 2 && !ring.closed;
        if (faces != ring.faces() || (ring.closed ? faces != 4 : !tip && !side))
            refuse(v, "has another number of faces");
        const float sharpness = mesh.vertex_sharpness(v);
        if (side && is_sharp(sharpness)) refuse(v, "is a corner between two faces");
        if (tip && !(is_sharp(sharpness) && !is_semi_sharp(sharpness))) refuse(v, "is a corner that does not stay one");
    }
    for (std::size_t v = 0; v < count; ++v)
        for (int s = 0; s < 4; ++s) {
            const int after = corners[v][(s + 1) % 4], before = corners[v][s];
            int other = RuleMesh::none, side = 0;
            if (after != RuleMesh::none) {
                other = mesh.next(after);
                side = corner_of[other];
            } else if (before != RuleMesh::none) {
                other = mesh.prev(before);
                side = (corner_of[other] + 3) % 4;
            }
            if (other == RuleMesh::none) continue;
            roots.link[4 * v + s] =
                4 * static_cast<std::uint32_t>(mesh.origin(other)) + static_cast<std::uint32_t>(side);
        }
    // A corner's child belongs to its face, a point of the boundary to that of the point above it; a corner of the
    // boundary, which has nothing on its left, goes with the point on its right.
    const auto beyond = [&](std::uint32_t v, std::size_t side) { return roots.link[4 * std::size_t{v} + side]; };
    for (std::uint32_t v = 0; v < count; ++v) {
        std::uint32_t inside = beyond(v, 3) == VertexRoots::outside ? beyond(v, 1) / 4 : v;
        if (!root_face[inside].valid()) inside = beyond(inside, 2) / 4;
        roots.face[v] = root_face[inside];
        roots.hole[v] = control.is_hole(roots.face[v]) ? 1 : 0;
    }
    return roots;
}

}  // namespace tetrakis::detail
