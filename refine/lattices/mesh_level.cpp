#include "mesh_level.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

/// Child half-edges that run along the first and the second half of half-edge h.
struct QuadHalves {
    const MeshLevel& level;
    std::uint32_t first(std::uint32_t h) const { return 4 * h; }
    std::uint32_t second(std::uint32_t h) const { return 4 * level.next(h) + 3; }
};
bool touches_sharp(const MeshLevel& level, std::uint32_t v) {
    if (is_sharp(level.vertex_sharpness[v])) return true;
    const std::uint32_t start = level.vertex_halfedge[v];
    if (start == none) return false;
    std::uint32_t h = start;
    do {
        if (is_sharp(level.edge_sharpness[level.edge(h)])) return true;
        h = level.twin[level.prev(h)];
    } while (h != start && h != none);
    return h == none;  // the last boundary edge has no outgoing half-edge
}

/// Edge sharpness around the origin of h, counter-clockwise from the vertex' first half-edge.
void gather_sharpness(const MeshLevel& level, std::uint32_t v, std::vector<float>& around) {
    around.clear();
    const std::uint32_t start = level.vertex_halfedge[v];
    std::uint32_t h = start;
    do {
        around.push_back(level.edge_sharpness[level.edge(h)]);
        const std::uint32_t before = level.prev(h);
        h = level.twin[before];
        if (h == none) around.push_back(level.edge_sharpness[level.edge(before)]);
    } while (h != start && h != none);
}

void refine_edges(const MeshLevel& level, const QuadHalves& halves, MeshLevel& finer) {
    // Twins and edges of the halves: the first half of h lies on the second half of its twin, and the other way round.
    for_each_index(level.halfedge_count(), [&](std::uint32_t h) {
        const std::uint32_t t = level.twin[h], a = halves.first(h), b = halves.second(h);
        finer.twin[a] = t == none ? none : halves.second(t);
        finer.twin[b] = t == none ? none : halves.first(t);
        const std::uint32_t e = level.edge_side[h] >> 1, side = level.edge_side[h] & 1;
        finer.edge_side[a] = 2 * (2 * e + side) + side;
        finer.edge_side[b] = 2 * (2 * e + 1 - side) + side;
    });
    for_each_index(level.edge_count, [&](std::uint32_t e) {
        finer.edge_halfedge[2 * e] = halves.first(level.edge_halfedge[e]);
        finer.edge_halfedge[2 * e + 1] = halves.second(level.edge_halfedge[e]);
    });
}

void refine_vertex_halfedges(const MeshLevel& level, const QuadHalves& halves, MeshLevel& finer,
                             std::uint32_t first_edge_vertex) {
    for_each_index(level.vertex_count, [&](std::uint32_t v) {
        const std::uint32_t h = level.vertex_halfedge[v];
        finer.vertex_halfedge[v] = h == none ? none : halves.first(h);
    });
    for_each_index(level.edge_count, [&](std::uint32_t e) {
        finer.vertex_halfedge[first_edge_vertex + e] = halves.second(level.edge_halfedge[e]);
    });
}

void refine_quads(const MeshLevel& level, MeshLevel& finer) {
    const std::uint32_t V = level.vertex_count, F = level.face_count, E = level.edge_count;
    for_each_index(F, [&](std::uint32_t f) {
        const std::uint32_t begin = level.first_halfedge(f), size = level.size_of(f);
        for (std::uint32_t i = 0; i < size; ++i) {
            const std::uint32_t h = begin + i, before = i == 0 ? begin + size - 1 : h - 1;
            std::uint32_t* q = &finer.origin[4 * static_cast<std::size_t>(h)];
            q[0] = level.origin[h];
            q[1] = V + F + level.edge(h);
            q[2] = V + f;
            q[3] = V + F + level.edge(before);
        }
    });
    const QuadHalves halves{level};
    refine_edges(level, halves, finer);
    for_each_index(level.halfedge_count(), [&](std::uint32_t h) {
        const std::uint32_t next = level.next(h);
        finer.twin[4 * h + 1] = 4 * next + 2;
        finer.twin[4 * next + 2] = 4 * h + 1;
        finer.edge_side[4 * h + 1] = 2 * (2 * E + h);
        finer.edge_side[4 * next + 2] = 2 * (2 * E + h) + 1;
        finer.edge_halfedge[2 * E + h] = 4 * h + 1;
    });
    refine_vertex_halfedges(level, halves, finer, V + F);
    for_each_index(F, [&](std::uint32_t f) { finer.vertex_halfedge[V + f] = 4 * level.first_halfedge(f) + 2; });
}

void refine_tags(const MeshLevel& level, CreaseMethod method, MeshLevel& finer) {
    finer.edge_sharpness.assign(finer.edge_count, 0.0f);
    finer.vertex_sharpness.assign(finer.vertex_count, 0.0f);
    for_each_index(level.vertex_count,
                   [&](std::uint32_t v) { finer.vertex_sharpness[v] = child_sharpness(level.vertex_sharpness[v]); });
    for_each_block(level.edge_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<float> around;
        for (std::uint32_t e = begin; e < end; ++e) {
            const float s = level.edge_sharpness[e];
            if (!is_sharp(s)) continue;
            if (method == CreaseMethod::uniform || !is_semi_sharp(s)) {
                finer.edge_sharpness[2 * e] = finer.edge_sharpness[2 * e + 1] = child_sharpness(s);
                continue;
            }
            const std::uint32_t h = level.edge_halfedge[e];
            gather_sharpness(level, level.origin[h], around);
            finer.edge_sharpness[2 * e] = child_sharpness_chaikin(s, around);
            gather_sharpness(level, level.origin[level.next(h)], around);
            finer.edge_sharpness[2 * e + 1] = child_sharpness_chaikin(s, around);
        }
    });
    finer.tagged.assign(finer.vertex_count, 0);
    for_each_index(level.vertex_count,
                   [&](std::uint32_t v) { finer.tagged[v] = level.tagged[v] != 0 && touches_sharp(finer, v); });
    const std::uint32_t first_edge_vertex = finer.vertex_count - level.edge_count;
    for_each_index(level.edge_count, [&](std::uint32_t e) {
        finer.tagged[first_edge_vertex + e] =
            is_sharp(finer.edge_sharpness[2 * e]) || is_sharp(finer.edge_sharpness[2 * e + 1]);
    });
}

}  // namespace

MeshLevel control_level(const ControlMesh& mesh) {
    MeshLevel level;
    level.control = &mesh;
    level.face_size = mesh.all_triangles() ? 3 : 0;
    level.vertex_count = mesh.vertex_count();
    level.edge_count = mesh.edge_count();
    level.face_count = mesh.face_count();
    level.origin = mesh.data().face_vertices;
    level.twin.resize(mesh.halfedge_count());
    level.edge_side.resize(mesh.halfedge_count());
    level.edge_halfedge.resize(mesh.edge_count());
    level.vertex_halfedge.resize(mesh.vertex_count());
    for_each_index(mesh.halfedge_count(), [&](std::uint32_t i) {
        const HalfedgeId h(i);
        const EdgeId e = mesh.edge(h);
        level.twin[i] = mesh.twin(h).value;
        level.edge_side[i] = 2 * e.value + (mesh.edge_halfedge(e) == h ? 0 : 1);
    });
    bool sharp = false;
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        level.edge_halfedge[e] = mesh.edge_halfedge(EdgeId(e)).value;
        sharp |= is_sharp(mesh.sharpness(EdgeId(e)));
    }
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        level.vertex_halfedge[v] = mesh.vertex_halfedge(VertexId(v)).value;
        sharp |= is_sharp(mesh.sharpness(VertexId(v)));
    }
    if (!sharp) return level;
    level.edge_sharpness.resize(mesh.edge_count());
    level.vertex_sharpness.resize(mesh.vertex_count());
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) level.edge_sharpness[e] = mesh.sharpness(EdgeId(e));
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) level.vertex_sharpness[v] = mesh.sharpness(VertexId(v));
    level.tagged.resize(mesh.vertex_count());
    for_each_index(mesh.vertex_count(), [&](std::uint32_t v) { level.tagged[v] = touches_sharp(level, v); });
    return level;
}

LevelCounts next_counts(const LevelCounts& counts, SchemeKind scheme) {
    if (scheme == SchemeKind::catmull_clark)
        return {.vertices = counts.vertices + counts.faces + counts.edges,
                .edges = 2 * counts.edges + counts.halfedges,
                .faces = counts.halfedges,
                .halfedges = 4 * counts.halfedges};
    return {.vertices = counts.vertices + counts.edges,
            .edges = 2 * counts.edges + counts.halfedges,
            .faces = 4 * counts.faces,
            .halfedges = 4 * counts.halfedges};
}

MeshLevel refine_to_quads(const MeshLevel& control, CreaseMethod method) {
    const LevelCounts counts =
        next_counts({control.vertex_count, control.edge_count, control.face_count, control.halfedge_count()},
                    SchemeKind::catmull_clark);
    MeshLevel finer;
    finer.control = control.control;
    finer.face_size = 4;
    finer.vertex_count = static_cast<std::uint32_t>(counts.vertices);
    finer.edge_count = static_cast<std::uint32_t>(counts.edges);
    finer.face_count = static_cast<std::uint32_t>(counts.faces);
    finer.origin.resize(counts.halfedges);
    finer.twin.resize(counts.halfedges);
    finer.vertex_halfedge.resize(counts.vertices);
    finer.edge_side.resize(counts.halfedges);
    finer.edge_halfedge.resize(counts.edges);
    refine_quads(control, finer);
    if (control.has_tags()) refine_tags(control, method, finer);
    return finer;
}

}  // namespace tetrakis::detail
