#include "cell_surroundings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

// In a key: vertices that are corners follow; then half-edges of sectors with angles, each with the halves of its
// angle.
constexpr int k_corners = std::numeric_limits<int>::min(), k_angles = k_corners + 1;

}  // namespace

std::optional<CellSurroundings> cell_surroundings(const RuleMesh& mesh, int halfedge, int rings,
                                                  MeshPartFinder& parts) {
    std::vector<int> seeds;
    for (const int v : mesh.corners(mesh.face(halfedge))) seeds.push_back(v);
    const MeshPart part = parts.find(mesh, seeds, rings);
    const RuleMesh& here = part.mesh;
    for (int h = 0; h < here.halfedge_count(); ++h)
        if (is_semi_sharp(here.sharpness(h)) || is_semi_sharp(here.vertex_sharpness(here.origin(h))))
            return std::nullopt;
    CellSurroundings result;
    std::vector<int> number(here.vertex_count(), -1), entry{part.halfedge(mesh, halfedge)};
    std::vector<char> entered(here.face_count(), 0);
    entered[here.face(entry[0])] = 1;
    SurroundingsKey& key = result.key;
    std::vector<double> angles;
    for (std::size_t i = 0; i < entry.size(); ++i) {
        int h = entry[i];
        key.push_back(-here.face_size(here.face(h)));
        do {
            const int v = here.origin(h), t = here.twin(h);
            if (number[v] < 0) {
                number[v] = static_cast<int>(result.vertices.size());
                result.vertices.push_back(part.vertex[v]);
            }
            // Inner edges alone: a part's own end is sharp, too.
            const bool sharp = t != RuleMesh::none && is_sharp(here.sharpness(h));
            key.push_back(2 * number[v] + (sharp ? 1 : 0));
            if (here.has_corner_angles()) angles.push_back(here.corner_angle(h));
            if (t != RuleMesh::none && !std::exchange(entered[here.face(t)], 1)) entry.push_back(t);
            h = here.next(h);
        } while (h != entry[i]);
    }
    if (entry.size() != static_cast<std::size_t>(here.face_count())) return std::nullopt;  // in pieces
    key.push_back(k_corners);
    for (std::size_t v = 0; v < number.size(); ++v)
        if (is_sharp(here.vertex_sharpness(static_cast<int>(v)))) key.push_back(number[v]);
    std::sort(std::find(key.begin(), key.end(), k_corners) + 1, key.end());
    if (!here.has_corner_angles()) return result;
    key.push_back(k_angles);
    for (std::size_t i = 0; i < angles.size(); ++i) {
        if (angles[i] == 0) continue;
        const auto halves = std::bit_cast<std::array<int, 2>>(angles[i]);
        key.insert(key.end(), {static_cast<int>(i), halves[0], halves[1]});
    }
    return result;
}

SurroundingsKey fan_surroundings(FanLattice lattice, const FanShape& shape, int rings) {
    // One ring more than there is around the cell, so that the fan's own end is out of sight.
    const SectorFan fan(lattice, shape, rings + 2);
    MeshPartFinder parts;
    return cell_surroundings(fan.mesh, fan.start[0], rings, parts)->key;
}

RuleMesh surroundings_mesh(const SurroundingsKey& key) {
    RuleMesh::Builder faces;
    int vertices = 0;
    std::size_t i = 0, halfedges = 0;
    for (; key[i] != k_corners;) {
        const int size = -key[i++];
        for (int c = 0; c < size; ++c, ++i) {
            faces.corner(key[i] / 2, key[i] % 2 != 0 ? std::numeric_limits<float>::infinity() : 0.0f);
            vertices = std::max(vertices, key[i] / 2 + 1);
            ++halfedges;
        }
        faces.end_face();
    }
    std::vector<float> sharpness(vertices, 0.0f);
    for (++i; i < key.size() && key[i] != k_angles; ++i) sharpness[key[i]] = std::numeric_limits<float>::infinity();
    if (i < key.size()) {
        std::vector<double> angles(halfedges);
        for (++i; i < key.size(); i += 3)
            angles[static_cast<std::size_t>(key[i])] = std::bit_cast<double>(std::array{key[i + 1], key[i + 2]});
        faces.set_corner_angles(std::move(angles));
    }
    return RuleMesh(vertices, std::move(faces), std::move(sharpness));
}

bool is_regular_vertex(const RuleMesh& mesh, int vertex, int cell_corners) {
    const int valence = cell_corners == 3 ? 6 : 4;
    const RuleMesh::Ring ring = mesh.ring(vertex);
    switch (mesh.rule(vertex)) {
        case VertexRule::smooth:
            return ring.closed && ring.edges() == valence;
        case VertexRule::crease: {
            if (!ring.closed) return ring.faces() == valence / 2;
            if (ring.edges() != valence) return false;
            for (int i = 0; i < valence; ++i)
                if (is_sharp(ring.sharpness[i])) return is_sharp(ring.sharpness[(i + valence / 2) % valence]);
            return false;
        }
        default:
            return false;
    }
}

bool is_simple(const RuleMesh& mesh, int cell_corners, int rings) {
    if (!mesh.all_faces_have(cell_corners)) return false;
    std::vector<int> ring(mesh.vertex_count(), -1), front;
    for (const int v : mesh.corners(0)) {
        ring[v] = 0;
        front.push_back(v);
    }
    int special = 0;
    for (std::size_t i = 0; i < front.size(); ++i) {
        const int v = front[i];
        if (ring[v] >= rings) break;
        special += is_regular_vertex(mesh, v, cell_corners) ? 0 : 1;
        const RuleMesh::Ring around = mesh.ring(v);
        for (const int h : around.halfedge)
            for (const int w : mesh.corners(mesh.face(h)))
                if (ring[w] < 0) {
                    ring[w] = ring[v] + 1;
                    front.push_back(w);
                }
    }
    return special <= 1;
}

}  // namespace tetrakis::detail
