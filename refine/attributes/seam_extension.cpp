#include "seam_extension.hpp"

#include "uv_mesh.hpp"

#include <array>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr float k_seam_corner = std::numeric_limits<float>::infinity();

/// Adds a row of quads at the half-edges marked in `open`, which then marks the outer half-edges of the new row.
SeamExtension one_more_layer(const SeamExtension& from, std::vector<char>& open, const std::vector<char>& crease_ends) {
    const RuleMesh& mesh = from.mesh;
    SeamExtension to;
    to.uvs = from.uvs;
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + mesh.face_size(f); ++h)
            faces.corner(mesh.origin(h), mesh.twin(h) == RuleMesh::none ? 0.0f : mesh.sharpness(h));
        faces.end_face();
    }
    int count = mesh.vertex_count();
    const auto copy = [&](const Vec2d& uv) {
        to.uvs.push_back(uv);
        return count++;
    };
    // New points outside of each vertex: for its next and its previous boundary edge, and at a corner one between them.
    std::vector<std::array<int, 3>> beyond(mesh.vertex_count(), {-1, -1, -1});
    std::vector<float> continued(mesh.vertex_count(), 0.0f);  // sharpness of the crease that is continued there
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none || !mesh.on_boundary(v)) continue;
        const RuleMesh::Ring ring = mesh.ring(v);
        const int last = ring.faces();
        const bool ahead = open[ring.halfedge[0]] != 0, behind = open[mesh.prev(ring.halfedge[last - 1])] != 0;
        const Vec2d at = from.uvs[v], first = from.uvs[ring.neighbour[0]], end = from.uvs[ring.neighbour[last]];
        if (ahead && behind && last == 1) {
            beyond[v] = {copy(2.0 * at - end), copy(2.0 * at - first), copy(3.0 * at - first - end)};
        } else if (ahead && behind) {
            Vec2d mean(0);
            int creases = 0;
            for (int i = 1; i < last; ++i) {
                mean += from.uvs[ring.neighbour[i]] / double(last - 1);
                if (!is_sharp(ring.sharpness[i])) continue;
                ++creases;
                continued[v] = ring.sharpness[i];
            }
            if (creases != 1 || crease_ends[v] != 0) continued[v] = 0;
            const int only = copy(2.0 * at - mean);
            beyond[v] = {only, only, -1};
        } else if (ahead || behind) {
            const int only = copy(2.0 * at - (ahead ? end : first));
            beyond[v] = {only, only, -1};
        }
    }
    std::vector<char> next_open(mesh.halfedge_count(), 0);
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        if (open[h] == 0) continue;
        const int u = mesh.origin(h), v = mesh.target(h);
        faces.corner(v);
        faces.corner(u, continued[u]);
        faces.corner(beyond[u][0]);
        faces.corner(beyond[v][1]);
        faces.end_face();
        next_open.insert(next_open.end(), {0, 0, 1, 0});
    }
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (beyond[v][2] < 0) continue;
        faces.face({v, beyond[v][1], beyond[v][2], beyond[v][0]});
        next_open.insert(next_open.end(), {0, 1, 1, 0});
    }
    std::vector<float> sharpness = mesh.vertex_sharpness();
    sharpness.resize(count, 0.0f);
    to.mesh = RuleMesh(count, std::move(faces), std::move(sharpness));
    open = std::move(next_open);
    return to;
}

}  // namespace

SeamExtension extend_over_seams(const ControlMesh& mesh, const RuleMesh& surface, const SchemeInfo& scheme,
                                const RuleOptions& rules) {
    const bool averages = scheme.averaging_steps != 0;
    // A step of averaging reaches half a face further. In honeycomb old vertices depend on all faces around them.
    const int layers = averages                                     ? (averaging_steps(scheme, rules) + 1) / 2
                       : scheme.refinement == Refinement::honeycomb ? 2
                                                                    : 1;
    const ControlMesh charts = uv_mesh(mesh);
    SeamExtension result;
    for (const Vec3d& p : charts.positions()) result.uvs.emplace_back(p);
    RuleMesh::Builder faces;
    std::vector<float> sharpness(charts.vertex_count(), 0.0f);
    std::vector<char> crease_ends(charts.vertex_count(), 0), open(mesh.halfedge_count(), 0);
    for (int f = 0; f < surface.face_count(); ++f) {
        for (int h = surface.face_begin(f); h < surface.face_begin(f) + surface.face_size(f); ++h) {
            const HalfedgeId half(static_cast<std::uint32_t>(h));
            const bool cut = !charts.twin(half).valid();
            const auto v = static_cast<int>(charts.origin(half).value);
            faces.corner(v, cut ? 0.0f : surface.sharpness(h));
            open[h] = cut && surface.twin(h) != RuleMesh::none && (averages || !is_sharp(surface.sharpness(h)));
            // Charts have the corners and darts of the surface.
            const VertexRule rule = surface.rule(surface.origin(h));
            sharpness[v] = surface.vertex_sharpness(surface.origin(h));
            if (rule == VertexRule::corner && sharpness[v] == 0) sharpness[v] = k_seam_corner;
            crease_ends[v] = rule == VertexRule::dart;
        }
        faces.end_face();
    }
    result.mesh = RuleMesh(static_cast<int>(charts.vertex_count()), std::move(faces), std::move(sharpness));
    for (int i = 0; i < layers; ++i) {
        crease_ends.resize(result.uvs.size(), 0);
        result = one_more_layer(result, open, crease_ends);
    }
    return result;
}

}  // namespace tetrakis::detail
