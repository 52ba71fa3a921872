#include "triangle_cell.hpp"

#include "../forest/corner_cell.hpp"

#include <array>

namespace tetrakis {

Site triangle_vertex_site(const ControlMesh& mesh, VertexId v) {
    const HalfedgeId h = mesh.vertex_halfedge(v);
    if (!h.valid()) return {};
    const std::uint32_t corner = h.value % 3;
    return {HalfedgeId(h.value - corner), {corner == 1 ? 1u : 0u, corner == 2 ? 1u : 0u}, 0};
}

Site canonical_triangle_site(const ControlMesh& mesh, const Site& site) {
    const Site minimal = minimal_level(site);
    const auto [root, at, level] = minimal;
    const std::uint32_t end = 1u << level;
    if (level == 0)
        return triangle_vertex_site(mesh, mesh.origin(HalfedgeId(root.value + (at.x != 0 ? 1 : at.y != 0 ? 2 : 0))));
    if (at.x != 0 && at.y != 0 && at.x + at.y != end) return minimal;
    const std::uint32_t side = at.y == 0 ? 0 : at.x == 0 ? 2 : 1;
    const HalfedgeId twin = mesh.twin(HalfedgeId(root.value + side));
    if (!twin.valid() || twin > root) return minimal;
    // Barycentric weights: the twin runs the other way.
    const std::array<std::uint32_t, 3> weight = {end - at.x - at.y, at.x, at.y};
    const std::uint32_t other = twin.value % 3;
    std::array<std::uint32_t, 3> there{};
    there[other] = weight[(side + 1) % 3];
    there[(other + 1) % 3] = weight[side];
    return {HalfedgeId(twin.value - other), {there[1], there[2]}, level};
}

}  // namespace tetrakis
