#include "vertex_links.hpp"

#include "../../hier/base/error.hpp"
#include "../rules/rule_refiner.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace tetrakis::detail {

namespace {

constexpr int k_first_corner = 2;

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

/// The half-edge of a cell lies at corner 2, and is the first counter-clockwise of its side.
std::vector<CellFrame> frames_of(const RuleMesh& level) {
    std::vector<CellFrame> frames(level.vertex_count()), others;
    for (int v = 0; v < level.vertex_count(); ++v) {
        frames[v] = {level.first(v), k_first_corner};
        const RuleMesh::Ring ring = level.ring(v);
        int sides = 0;
        for (int i = 0; i < ring.faces(); ++i)
            if (is_sharp(ring.sharpness[i]))
                (sides++ == 0 ? frames[v] : others.emplace_back()) = {ring.halfedge[i], k_first_corner};
    }
    frames.insert(frames.end(), others.begin(), others.end());
    return frames;
}

}  // namespace

FirstCells first_cells(const ControlMesh& control, const RuleStep& first_step) {
    const RuleMesh& mesh = first_step.mesh;
    std::vector<CellFrame> cells = frames_of(mesh);
    FirstCells first;
    first.face.resize(cells.size());
    // A corner's child has the corner's face at its far corner; at the end of the surface, and on a crease, the faces
    // of a point lie above it.
    for (std::uint32_t h = 0; h < control.halfedge_count(); ++h) {
        const int child = first_step.child_halfedge[h], v = mesh.origin(child);
        cells[v] = {child, k_first_corner};
        first.face[v] = control.face(HalfedgeId(h));
    }
    for (const CellFrame& cell : cells) {
        const std::array<int, 4> at = vertex_corners(mesh, cell);
        unsigned faces = 0;
        for (std::size_t c = 0; c < 4; ++c) faces |= at[c] != RuleMesh::none ? 1u << c : 0u;
        first.frames.push_back({cell, faces});
    }
    return first;
}

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
    const auto [frames, root_face] = first_cells(control, first_step);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (const char* what = fault(mesh, v))
            throw Error(ErrorCode::unsupported,
                        "vertex quadtrees need four children of every vertex; vertex " + std::to_string(v) +
                            " of level 1 " + what + "; refine the mesh once with the same scheme and start from there",
                        control.data().source);
    VertexRoots roots;
    const std::size_t count = frames.size();
    std::vector<std::array<int, 4>> corners(count);
    std::vector<std::uint32_t> place(mesh.halfedge_count(), 0);  // 4 * root + corner
    for (std::uint32_t r = 0; r < count; ++r) {
        corners[r] = vertex_corners(mesh, frames[r].frame);
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

}  // namespace tetrakis
