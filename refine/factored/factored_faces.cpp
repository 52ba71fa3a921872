#include "factored_faces.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../attributes/used_values.hpp"
#include "../rules/rule_refiner.hpp"

#include <limits>

namespace tetrakis::detail {

FactoredFaces::FactoredFaces(const ControlMesh& control) {
    check_halfedge_count(control.halfedge_count(), 1, k_next);
    mesh_ = rule_mesh(control);
    positions_.assign(control.positions().begin(), control.positions().end());
    vertex_.resize(mesh_.vertex_count());
    for (std::size_t v = 0; v < vertex_.size(); ++v) vertex_[v] = static_cast<std::uint32_t>(v);
}

void FactoredFaces::put_centres() {
    centre_.resize(mesh_.face_count());
    for (std::uint32_t& c : centre_) c = add({});
    rest_centres();
    set_states();
}

std::vector<std::uint32_t> FactoredFaces::places() const {
    std::vector<std::uint32_t> result = vertex_;
    result.reserve(vertex_.size() + midpoint_.size() + centre_.size());
    result.insert(result.end(), midpoint_.begin(), midpoint_.end());
    result.insert(result.end(), centre_.begin(), centre_.end());
    return result;
}

void FactoredFaces::check_memory(std::uint64_t bytes, std::string_view which) const {
    detail::check_memory(std::string(which) + " needs", bytes, max_memory_bytes_,
                         "ask for fewer half-steps or allow more");
}

void FactoredFaces::check_half_steps(int count) const {
    std::uint64_t at = halfedges();
    int done = done_;
    for (int i = 0; i < count; ++i, ++done) {
        const std::string which = "half-step " + std::to_string(i + 1) + " of " + std::to_string(count);
        if (done == half_steps_per_level()) {
            at *= k_growth;
            done = 0;
        }
        check_halfedge_count(at, 1, which);
        check_room(at, done, which);
    }
}

void FactoredFaces::check_halfedge_count(std::uint64_t halfedges, std::uint64_t growth, std::string_view which) {
    constexpr std::uint64_t k_most = std::numeric_limits<int>::max();  // RuleMesh counts with int
    if (halfedges <= k_most / growth) return;
    throw Error(ErrorCode::unsupported,
                "so many half-steps have more elements than 31 bits can count: " + std::string(which) +
                    " needs up to " + std::to_string(halfedges * growth) + " face corners; ask for fewer half-steps");
}

void FactoredFaces::check_halfedge_memory(std::uint64_t halfedges, bool finer, std::string_view which) const {
    // Each with its point, triangle and stencil row.
    constexpr std::uint64_t k_per_halfedge = 240;
    check_memory(k_per_halfedge * halfedges * (finer ? k_growth : 1), which);
}

std::vector<std::array<std::uint32_t, 3>> FactoredFaces::triangles() const {
    std::vector<std::array<std::uint32_t, 3>> result;
    result.reserve(halfedges() * (midpoint_.empty() ? 1 : 2));
    for (int h = 0; h < mesh_.halfedge_count(); ++h) {
        const std::uint32_t u = vertex_[mesh_.origin(h)], w = vertex_[mesh_.target(h)];
        const std::uint32_t c = centre_[mesh_.face(h)];
        const int t = mesh_.twin(h);
        if (!midpoint_.empty()) {
            const std::uint32_t s = midpoint_[mesh_.edge(h)];
            result.push_back({u, s, c});
            result.push_back({s, w, c});
        } else if (whole_ || t == RuleMesh::none || mesh_.sharp(h)) {
            result.push_back({u, w, c});
        } else {
            // The block across the edge is still cut from centre to centre.
            result.push_back({u, centre_[mesh_.face(t)], c});
        }
    }
    return result;
}

PolygonMesh FactoredFaces::polygons(const RuleMesh& faces, std::span<const std::uint32_t> vertex,
                                    std::vector<std::uint32_t>* numbers) const {
    PolygonMesh result;
    result.positions = positions_;
    result.face_offsets.push_back(0);
    for (int f = 0; f < faces.face_count(); ++f) {
        if (!take(result, f)) continue;
        for (const int v : faces.corners(f)) result.face_vertices.push_back(vertex[v]);
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
    }
    drop_unused_vertices(result, numbers);
    return result;
}

PolygonMesh FactoredFaces::polygons(std::span<const std::array<std::uint32_t, 3>> triangles,
                                    std::vector<std::uint32_t>* numbers) const {
    PolygonMesh result;
    result.positions = positions_;
    result.face_offsets.push_back(0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (!take(result, face_of_triangle(t))) continue;
        result.face_vertices.insert(result.face_vertices.end(), triangles[t].begin(), triangles[t].end());
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
    }
    drop_unused_vertices(result, numbers);
    return result;
}

PolygonMesh FactoredFaces::mesh(std::vector<std::uint32_t>* numbers) const { return polygons(triangles(), numbers); }
PolygonMesh FactoredFaces::active_mesh() const { return polygons(mesh_, vertex_); }

void FactoredFaces::insert_midpoints() {
    positions_.reserve(positions_.size() + static_cast<std::size_t>(mesh_.edge_count()));
    midpoint_.resize(mesh_.edge_count());
    for (int e = 0; e < mesh_.edge_count(); ++e) {
        const int h = mesh_.edge_halfedge(e);
        midpoint_[e] = add(0.5 * (positions_[vertex_[mesh_.origin(h)]] + positions_[vertex_[mesh_.target(h)]]));
    }
}

void FactoredFaces::rest_centres() {
    for (int f = 0; f < mesh_.face_count(); ++f) {
        Vec3d sum(0);
        for (const int v : mesh_.corners(f)) sum += positions_[vertex_[v]];
        positions_[centre_[f]] = sum / static_cast<double>(mesh_.face_size(f));
    }
}

void FactoredFaces::set_states() {
    state_.assign(positions_.size(), FactoredVertex::unused);
    for (int v = 0; v < mesh_.vertex_count(); ++v)
        if (mesh_.first(v) != RuleMesh::none) state_[vertex_[v]] = FactoredVertex::active;
    for (const std::uint32_t c : centre_) state_[c] = FactoredVertex::inactive;
    for (const std::uint32_t s : midpoint_) state_[s] = FactoredVertex::active;
}

}  // namespace tetrakis::detail
