#include "vertex_links.hpp"

#include "../../hier/base/error.hpp"
#include "../rules/rule_refiner.hpp"

#include <array>
#include <stdexcept>
#include <string>
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

/// The half-edges that leave a vertex of level 1, by the corners of its cell; none where the cell ends the surface, or
/// its side of a crease.
/// @param first  that of corner 2
std::array<int, 4> vertex_corners(const RuleMesh& mesh, int first) {
    const auto across = [&](int h) { return mesh.sharp(h) ? RuleMesh::none : mesh.twin(h); };
    std::array<int, 4> at{RuleMesh::none, RuleMesh::none, RuleMesh::none, RuleMesh::none};
    const auto corner = [&](int steps) -> int& { return at[static_cast<std::size_t>((2 + steps) % 4)]; };
    int h = first;
    for (int k = 0; k < 4 && h != RuleMesh::none; ++k) {
        corner(k) = h;
        h = across(mesh.prev(h));
        if (h == first) return at;
    }
    h = across(first);
    for (int k = 3; k > 0 && h != RuleMesh::none && corner(k) == RuleMesh::none; --k) {
        corner(k) = mesh.next(h);
        h = across(corner(k));
    }
    return at;
}

/// The cells of level 1, by their first half-edges counter-clockwise: one for each vertex, then for each vertex on
/// creases those of its other sides.
std::vector<int> cells_of(const RuleMesh& level) {
    std::vector<int> cells(level.vertex_count()), others;
    for (int v = 0; v < level.vertex_count(); ++v) {
        cells[v] = level.first(v);
        const RuleMesh::Ring ring = level.ring(v);
        int sides = 0;
        for (int i = 0; i < ring.faces(); ++i)
            if (is_sharp(ring.sharpness[i])) (sides++ == 0 ? cells[v] : others.emplace_back()) = ring.halfedge[i];
    }
    cells.insert(cells.end(), others.begin(), others.end());
    return cells;
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
    RuleStep first_step;
    try {
        first_step = scheme.step(rule_mesh(control, rules), rules);
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::invalid_input, e.what(), control.data().source);
    }
    const RuleMesh& mesh = first_step.mesh;
    std::vector<int> cells = cells_of(mesh);
    const std::size_t count = cells.size();
    // A corner's child has the corner's face at its far corner; at the end of the surface, and on a crease, the faces
    // of a point lie above it.
    std::vector<FaceId> root_face(count);
    for (std::uint32_t h = 0; h < control.halfedge_count(); ++h) {
        const int child = first_step.child_halfedge[h], v = mesh.origin(child);
        cells[v] = child;
        root_face[v] = control.face(HalfedgeId(h));
    }
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (const char* what = fault(mesh, v))
            throw Error(ErrorCode::unsupported,
                        "vertex quadtrees need four children of every vertex; vertex " + std::to_string(v) +
                            " of level 1 " + what + "; refine the mesh once with the same scheme and start from there",
                        control.data().source);
    VertexRoots roots;
    std::vector<std::array<int, 4>> corners(count);
    std::vector<std::uint32_t> place(mesh.halfedge_count(), 0);  // 4 * root + corner
    for (std::uint32_t r = 0; r < count; ++r) {
        corners[r] = vertex_corners(mesh, cells[r]);
        for (std::uint32_t c = 0; c < 4; ++c)
            if (corners[r][c] != RuleMesh::none) place[corners[r][c]] = 4 * r + c;
    }
    roots.link.assign(4 * count, VertexRoots::outside);
    roots.crease.resize(count, 0);
    roots.face.resize(count);
    roots.hole.resize(count);
    const auto side_before = [](std::uint32_t corner) { return corner / 4 * 4 + (corner + 3) % 4; };
    for (std::uint32_t r = 0; r < count; ++r)
        for (std::uint32_t s = 0; s < 4; ++s) {
            const int after = corners[r][(s + 1) % 4], before = corners[r][s];
            if (after != RuleMesh::none)
                roots.link[4 * r + s] = place[mesh.next(after)];
            else if (before != RuleMesh::none)
                roots.link[4 * r + s] = side_before(place[mesh.prev(before)]);
        }
    // The side before a crease's first face lies along the crease, and over there the one after its last.
    for (std::uint32_t r = 0; r < count; ++r)
        for (std::uint32_t c = 0; c < 4; ++c) {
            const std::uint32_t side = (c + 2) % 4;
            const int h = corners[r][c];
            if (h == RuleMesh::none || corners[r][(c + 3) % 4] != RuleMesh::none) continue;
            if (!mesh.sharp(h) || mesh.twin(h) == RuleMesh::none) continue;
            if (roots.link[4 * r + side] != VertexRoots::outside) continue;  // the crease ends here
            const std::uint32_t last = place[mesh.next(mesh.twin(h))];
            const std::uint32_t other = last / 4 * 4 + (last + 1) % 4;
            roots.link[4 * r + side] = other;
            roots.link[other] = 4 * r + side;
            roots.crease[r] = static_cast<std::uint8_t>(roots.crease[r] | 1u << side);
            roots.crease[other / 4] = static_cast<std::uint8_t>(roots.crease[other / 4] | 1u << other % 4);
        }
    // A corner's child belongs to its face, a point of a boundary or crease to that of the point above it; a corner of
    // these to that above the one after it: as in RuleLevels, which refine() goes by.
    for (std::uint32_t r = 0; r < count; ++r) {
        const bool corner = corners[r][2] != RuleMesh::none && corners[r][3] == RuleMesh::none;
        std::uint32_t inside = r;
        if (corner)
            inside = place[mesh.next(mesh.next(corners[r][2]))] / 4;
        else if (!root_face[r].valid())
            inside = roots.link[4 * std::size_t{r} + 2] / 4;
        roots.face[r] = root_face[inside];
        roots.hole[r] = control.is_hole(roots.face[r]) ? 1 : 0;
    }
    return roots;
}

std::vector<std::uint32_t> detail::root_halfedges(const VertexRoots& roots, const RootLattices& net,
                                                  std::uint32_t corners) {
    const MeshLevel& base = net.base();
    std::vector<std::uint32_t> first(roots.count(), MeshLevel::none), found;
    for (std::uint32_t h = 0; h < corners; ++h) {
        first[h] = 4 * h;
        found.push_back(h);
    }
    // From the corners of faces outwards over the boundary.
    while (!found.empty()) {
        const std::uint32_t r = found.back();
        found.pop_back();
        for (std::uint32_t s = 0; s < 4; ++s) {
            const std::uint32_t link = roots.link[4 * std::size_t{r} + s];
            if (link == VertexRoots::outside || (roots.crease[r] >> s & 1) != 0) continue;
            const std::uint32_t beyond = link / 4;
            const std::uint32_t twin = base.twin[first[r] / 4 * 4 + (first[r] + s) % 4];
            if (first[beyond] != MeshLevel::none || twin == MeshLevel::none) continue;
            first[beyond] = twin / 4 * 4 + (twin + 4 - link % 4) % 4;
            found.push_back(beyond);
        }
    }
    return first;
}

}  // namespace tetrakis
