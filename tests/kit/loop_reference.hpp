#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/loop.hpp"
#include "triangle_test_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace tetrakis::test {

/// A mesh refined everywhere, each of its faces with the place it has in the root it comes from.
struct UniformLoop {
    struct Place {
        HalfedgeId root;
        std::array<LatticePoint, 3> corner;
    };
    ControlMesh mesh;
    std::vector<Place> places;
    int level = 0;

    explicit UniformLoop(const ControlMesh& control) : mesh(control) {
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
            places.push_back({mesh.face_halfedge(FaceId(f)), {LatticePoint{0, 0}, {1, 0}, {0, 1}}});
    }

    /// One Loop step on the whole mesh, by the rules as they are written down, vertex by vertex.
    void step() {
        const std::uint32_t vertex_count = mesh.vertex_count();
        ControlMeshData fine;
        fine.boundary_rule = mesh.boundary_rule();
        fine.crease_method = mesh.crease_method();
        fine.positions.resize(vertex_count + mesh.edge_count());
        std::vector<float> half(mesh.halfedge_count());
        std::vector<std::vector<std::uint32_t>> fans(
            vertex_count);  // outgoing half-edges; incoming of the last is extra
        const auto at_vertex = [&](std::uint32_t v) {
            std::vector<float> sharpness;
            for (const std::uint32_t h : fans[v]) sharpness.push_back(mesh.sharpness(mesh.edge(HalfedgeId(h))));
            if (mesh.is_boundary(VertexId(v))) sharpness.push_back(k_sharpness_infinity);
            return sharpness;
        };
        for (std::uint32_t v = 0; v < vertex_count; ++v) {
            const HalfedgeId start = mesh.vertex_halfedge(VertexId(v));
            for (HalfedgeId h = start; h.valid();) {
                fans[v].push_back(h.value);
                h = mesh.ccw_outgoing(h);
                if (h == start) break;
            }
            const std::vector<float> around = at_vertex(v);
            for (std::size_t i = 0; i < fans[v].size(); ++i)
                half[fans[v][i]] = mesh.crease_method() == CreaseMethod::chaikin
                                       ? child_sharpness_chaikin(around[i], around)
                                       : child_sharpness(around[i]);
        }
        for (std::uint32_t v = 0; v < vertex_count; ++v) {
            const Vec3d centre = mesh.position(VertexId(v));
            fine.positions[v] = centre;
            if (fans[v].empty()) continue;
            std::vector<Vec3d> ring;
            std::vector<float> halves;
            for (const std::uint32_t h : fans[v]) {
                ring.push_back(mesh.position(mesh.target(HalfedgeId(h))));
                halves.push_back(half[h]);
            }
            if (mesh.is_boundary(VertexId(v))) {
                ring.push_back(mesh.position(mesh.origin(mesh.prev(HalfedgeId(fans[v].back())))));
                halves.push_back(k_sharpness_infinity);
            }
            const float sharpness = mesh.sharpness(VertexId(v));
            const VertexBlend blend = vertex_blend(at_vertex(v), sharpness, halves, child_sharpness(sharpness));
            Vec3d sum(0);
            for (const Vec3d& p : ring) sum += p;
            const RingMask mask = Loop::vertex_mask(static_cast<int>(ring.size()));
            fine.positions[v] = blend.smooth * (mask.vertex * centre + mask.edge * sum) + blend.corner * centre;
            if (blend.crease.weight != 0)
                fine.positions[v] +=
                    blend.crease.weight * (0.75 * centre + 0.125 * (ring[blend.crease.a] + ring[blend.crease.b]));
            if (child_sharpness(sharpness) > 0)
                fine.corners.push_back({v, std::min(child_sharpness(sharpness), 10.0f)});
        }
        for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
            const HalfedgeId h = mesh.edge_halfedge(EdgeId(e)), t = mesh.twin(h);
            const VertexId a = mesh.origin(h), b = mesh.target(h);
            const Vec3d middle = 0.5 * (mesh.position(a) + mesh.position(b));
            Vec3d& out = fine.positions[vertex_count + e];
            out = middle;
            if (!t.valid()) continue;
            const double crease = edge_crease_weight(mesh.sharpness(EdgeId(e)), half[h.value], half[t.value]);
            const Vec3d opposite = mesh.position(mesh.origin(mesh.prev(h))) + mesh.position(mesh.origin(mesh.prev(t)));
            out = crease * middle + (1 - crease) * (0.75 * middle + 0.125 * opposite);
            const auto tag = [&](VertexId v, float s) {
                if (s > 0) fine.creases.push_back({v.value, vertex_count + e, std::min(s, 10.0f)});
            };
            tag(a, half[h.value]);
            tag(b, half[t.value]);
        }
        std::vector<Place> fine_places;
        fine.face_offsets.push_back(0);
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            const std::uint32_t h = mesh.face_halfedge(FaceId(f)).value;
            std::array<std::uint32_t, 3> v, e;
            std::array<LatticePoint, 3> p, m;
            for (std::uint32_t k = 0; k < 3; ++k) {
                v[k] = mesh.origin(HalfedgeId(h + k)).value;
                e[k] = vertex_count + mesh.edge(HalfedgeId(h + k)).value;
                p[k] = {2 * places[f].corner[k].x, 2 * places[f].corner[k].y};
            }
            for (std::uint32_t k = 0; k < 3; ++k)
                m[k] = {(p[k].x + p[(k + 1) % 3].x) / 2, (p[k].y + p[(k + 1) % 3].y) / 2};
            const auto add = [&](std::array<std::uint32_t, 3> face, std::array<LatticePoint, 3> corners) {
                for (const std::uint32_t i : face) fine.face_vertices.push_back(i);
                fine.face_offsets.push_back(static_cast<std::uint32_t>(fine.face_vertices.size()));
                fine_places.push_back({places[f].root, corners});
            };
            add({v[0], e[0], e[2]}, {p[0], m[0], m[2]});
            add({e[0], v[1], e[1]}, {m[0], p[1], m[1]});
            add({e[2], e[1], v[2]}, {m[2], m[1], p[2]});
            add({e[1], e[2], e[0]}, {m[1], m[2], m[0]});
        }
        mesh = ControlMesh::build(std::move(fine));
        places = std::move(fine_places);
        ++level;
    }
};

/// random_triangle_mesh() with random creases, corners and crease method.
inline ControlMesh random_tagged_mesh(std::uint32_t seed) {
    const ControlMesh plain = random_triangle_mesh(seed);
    ControlMeshData data = plain.data();
    std::mt19937 random(seed * 7919u + 1);
    const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    constexpr std::array<float, 6> values{10.0f, 0.4f, 1.0f, 1.5f, 2.3f, 10.0f};
    if (seed % 5 != 0) {
        for (std::uint32_t e = 0; e < plain.edge_count(); ++e) {
            const HalfedgeId h = plain.edge_halfedge(EdgeId(e));
            if (below(6) == 0) data.creases.push_back({plain.origin(h).value, plain.target(h).value, values[below(6)]});
        }
        for (std::uint32_t v = 0; v < plain.vertex_count(); ++v)
            if (!plain.is_isolated(VertexId(v)) && below(12) == 0) data.corners.push_back({v, values[below(6)]});
    }
    if (seed % 2 == 0) data.crease_method = CreaseMethod::chaikin;
    if (seed % 3 == 1) data.boundary_rule = BoundaryRule::edge_only;
    return ControlMesh::build(std::move(data));
}

}  // namespace tetrakis::test
