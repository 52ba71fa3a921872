#include "vertex_links.hpp"

#include "../../hier/base/disjoint_sets.hpp"
#include "../../hier/base/error.hpp"
#include "../lattices/root_lattices.hpp"
#include "../rules/rule_refiner.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// Why a vertex does not have four children on each side of its creases; nullptr if it has.
const char* fault(const RuleMesh& mesh, int v) {
    const RuleMesh::Ring ring = mesh.ring(v);
    int sharp = 0;
    for (int i = 0; i < ring.edges(); ++i)
        if (is_sharp(ring.sharpness[i])) ++sharp;
    constexpr const char* other = "has another number of faces";
    if (sharp == 0 && ring.closed && ring.faces() == 3) return "comes from a vertex where only two faces meet";
    if (sharp == 0) return ring.faces() == 4 ? nullptr : other;
    if (sharp == 1) return ring.faces() == 3 ? nullptr : other;
    const int sides = ring.closed ? sharp : sharp - 1;
    const bool corner = is_sharp(mesh.vertex_sharpness(v));
    if (sharp == 2 && ring.faces() == 2 * sides) return corner ? "is a corner between two faces" : nullptr;
    if (ring.faces() != sides) return other;
    return sharp > 2 || corner ? nullptr : "is a corner that does not stay one";
}

}  // namespace
}  // namespace tetrakis::detail

namespace tetrakis {

VertexRoots vertex_roots(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules) {
    using namespace detail;
    if (fan_lattice(scheme, rules) != FanLattice::dual)
        throw Error(ErrorCode::invalid_input, "only dual schemes have vertex quadtrees");
    if (boundary_recedes(scheme, rules))
        throw Error(ErrorCode::unsupported, "a boundary that recedes has no vertex quadtrees; replicate it");
    if (control.face_count() == 0) return {};
    const RuleMesh surface = rule_mesh(control, scheme, rules);
    RuleStep step;
    try {
        step = scheme.step(surface, rules);
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::invalid_input, e.what(), control.data().source);
    }
    const auto vertices = static_cast<std::uint32_t>(step.mesh.vertex_count()), corners = control.halfedge_count();
    for (std::uint32_t v = 0; v < vertices; ++v)
        if (const char* what = fault(step.mesh, static_cast<int>(v)))
            throw Error(ErrorCode::unsupported,
                        "vertex quadtrees need four children of every vertex; vertex " + std::to_string(v) +
                            " of level 1 " + what + "; refine the mesh once with the same scheme and start from there",
                        control.data().source);
    std::vector<std::uint32_t> face(corners);
    for (std::uint32_t h = 0; h < corners; ++h) face[h] = control.face(HalfedgeId(h)).value;
    const RootLattices net = RootLattices::of_corners(surface, !ignores_creases(scheme, rules), std::move(face));
    const std::vector<int> vertex = net.vertices(net.layout(1), step.mesh, step.child_halfedge).value();
    const RuleMesh& base = net.base();
    const std::uint32_t count = net.root_count();
    // A vertex on a crease has a root of the net on each side. The root to the left of its first sharp edge gets the
    // number of the vertex.
    const auto is_other_side = [&](std::uint32_t r) {
        const RuleMesh::Ring ring = step.mesh.ring(vertex[r]);
        const auto sharp = std::find_if(ring.sharpness.begin(), ring.sharpness.end(), is_sharp);
        if (sharp == ring.sharpness.end()) return false;
        const int above = step.mesh.prev(ring.halfedge[static_cast<int>(sharp - ring.sharpness.begin())]);
        return vertex[base.twin(4 * r) / 4] != step.mesh.origin(above);
    };
    std::vector<std::uint32_t> number(vertex.begin(), vertex.end()), others;
    for (std::uint32_t r = corners; r < count; ++r)
        if (is_other_side(r)) others.push_back(r);
    std::ranges::stable_sort(others, {}, [&](std::uint32_t r) { return vertex[r]; });
    for (std::size_t i = 0; i < others.size(); ++i) number[others[i]] = vertices + static_cast<std::uint32_t>(i);
    // Roots at face corners keep the sides of the net. For roots beyond a boundary or crease the net's side 0 is the
    // inner one; the cell is turned by half a turn.
    const auto turned = [&](std::uint32_t h) { return h < 4 * corners ? h : h ^ 2; };
    const auto place = [&](std::uint32_t h) { return 4 * number[h / 4] + turned(h) % 4; };
    VertexRoots roots;
    roots.link.assign(net.halfedge_count(), VertexRoots::outside);
    roots.net_halfedge.resize(count);
    roots.crease.resize(count, 0);
    roots.face.resize(count);
    roots.hole.resize(count);
    for (std::uint32_t h = 0; h < net.halfedge_count(); ++h)
        if (base.twin(h) != RuleMesh::none) roots.link[place(h)] = place(base.twin(h));
    for (const auto& [g, h] : net.glued())
        for (const auto& [here, there] : {std::pair(place(g), place(h)), std::pair(place(h), place(g))}) {
            roots.link[here] = there;
            roots.crease[here / 4] = static_cast<std::uint8_t>(roots.crease[here / 4] | 1u << here % 4);
        }
    for (std::uint32_t r = 0; r < count; ++r) {
        roots.net_halfedge[number[r]] = turned(4 * r);
        roots.face[number[r]] = FaceId(net.control_face(r));
        roots.hole[number[r]] = control.is_hole(FaceId(net.control_face(r))) ? 1 : 0;
    }
    return roots;
}

ControlMeshData cell_mesh(const VertexRoots& roots) {
    const std::uint32_t count = 4 * roots.count();
    detail::DisjointSets corners(count);  // a set for each vertex: corners that linked sides share
    const auto next = [](std::uint32_t c) { return c / 4 * 4 + (c + 1) % 4; };
    for (std::uint32_t side = 0; side < count; ++side)
        if (roots.link[side] != VertexRoots::outside) corners.unite(next(side), roots.link[side]);
    ControlMeshData data;
    data.face_offsets.push_back(0);
    for (std::uint32_t c = 0; c < count; ++c) {
        if (corners.find(c) == c) data.positions.emplace_back(0);
        data.face_vertices.push_back(corners.find(c) == c ? static_cast<std::uint32_t>(data.positions.size() - 1)
                                                          : data.face_vertices[corners.find(c)]);
        if (c % 4 == 3) data.face_offsets.push_back(c + 1);
    }
    return data;
}

}  // namespace tetrakis
