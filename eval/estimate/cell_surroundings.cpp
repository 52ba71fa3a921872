#include "cell_surroundings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

// Separators in a key. After the first, the sharp vertices follow; after the second, half-edges with corner angles,
// each with the two halves of its angle's bits.
constexpr int k_sharp_vertices = std::numeric_limits<int>::min(), k_angles = k_sharp_vertices + 1;

/// The mesh of these surroundings. Half-edge 0 leaves the cell's first corner, and the first half-edge of every other
/// face has its twin in an earlier face.
/// @throws std::invalid_argument  the surroundings are no valid mesh at their border
RuleMesh surroundings_mesh(const SurroundingsKey& key) {
    RuleMesh::Builder faces;
    int vertices = 0;
    std::size_t i = 0, halfedges = 0;
    for (; key[i] != k_sharp_vertices;) {
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

/// Lattice coordinates of all vertices: the lattice of the first face is continued face by face across edges.
std::vector<Vec2d> unrolled(const RuleMesh& mesh, int corners) {
    std::vector<Vec2d> at(mesh.vertex_count());
    std::vector<char> seen(mesh.vertex_count(), 0);
    const auto put = [&](int vertex, const Vec2d& place) {
        if (!std::exchange(seen[vertex], 1)) at[vertex] = place;
    };
    for (int k = 0; k < corners; ++k) put(mesh.origin(k), cell_corner(k, corners));
    for (int f = 1; f < mesh.face_count(); ++f) {
        const int h = mesh.face_begin(f), back = mesh.twin(h), ahead = mesh.next(h);
        const Vec2d &a = at[mesh.origin(h)], &b = at[mesh.target(h)];
        const Vec2d &beside_a = at[mesh.target(mesh.next(back))], &beside_b = at[mesh.origin(mesh.prev(back))];
        if (corners == 3) {
            put(mesh.target(ahead), a + b - beside_a);
        } else {
            put(mesh.target(ahead), 2.0 * b - beside_b);
            put(mesh.origin(mesh.prev(h)), 2.0 * a - beside_a);
        }
    }
    return at;
}

}  // namespace

std::optional<CellSurroundings> cell_surroundings(const RuleMesh& mesh, int halfedge, int rings,
                                                  MeshPartFinder& parts) {
    parts.look(mesh, mesh.corners(mesh.face(halfedge)), rings);
    CellSurroundings result;
    SurroundingsKey &key = result.key, angles;
    std::vector<int> number(parts.vertices().size(), -1), entry{halfedge}, sharp_corners;
    std::vector<char> entered(parts.faces().size(), 0);
    entered[parts.face_place(mesh.face(halfedge))] = 1;
    int halfedges = 0;
    for (std::size_t i = 0; i < entry.size(); ++i) {
        int h = entry[i];
        key.push_back(-mesh.face_size(mesh.face(h)));
        do {
            const int v = mesh.origin(h), t = mesh.twin(h);
            int& number_of_v = number[parts.vertex_place(v)];
            if (number_of_v < 0) {
                number_of_v = static_cast<int>(result.vertices.size());
                result.vertices.push_back(v);
                if (is_semi_sharp(mesh.vertex_sharpness(v))) return std::nullopt;
                if (is_sharp(mesh.vertex_sharpness(v))) sharp_corners.push_back(number_of_v);
            }
            // Only inner edges have a sharpness: at the border of the part it is unknown.
            const bool inner = t != RuleMesh::none && parts.has_face(mesh.face(t));
            if (inner && is_semi_sharp(mesh.sharpness(h))) return std::nullopt;
            key.push_back(2 * number_of_v + (inner && is_sharp(mesh.sharpness(h)) ? 1 : 0));
            if (mesh.has_corner_angles() && mesh.corner_angle(h) != 0) {
                const auto halves = std::bit_cast<std::array<int, 2>>(mesh.corner_angle(h));
                angles.insert(angles.end(), {halfedges, halves[0], halves[1]});
            }
            ++halfedges;
            if (inner && !std::exchange(entered[parts.face_place(mesh.face(t))], 1)) entry.push_back(t);
            h = mesh.next(h);
        } while (h != entry[i]);
    }
    if (entry.size() != parts.faces().size()) return std::nullopt;  // not connected by edges
    key.push_back(k_sharp_vertices);
    key.insert(key.end(), sharp_corners.begin(), sharp_corners.end());
    if (angles.empty()) return result;
    key.push_back(k_angles);
    key.insert(key.end(), angles.begin(), angles.end());
    return result;
}

std::optional<CellStep> cell_step(const SchemeInfo& scheme, const RuleOptions& options, const SurroundingsKey& key,
                                  int cell_corners, int rings) {
    RuleMesh mesh;
    try {
        mesh = surroundings_mesh(key);
    } catch (const std::invalid_argument&) {
        return std::nullopt;
    }
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.ring(v).edges() > k_most_edges) return std::nullopt;
    RuleStep step = scheme.step(mesh, options);
    CellStep result{unrolled(mesh, cell_corners), std::move(step.stencils), {}};
    MeshPartFinder parts;
    for (int child = 0; child < 4; ++child) {
        const CellFrame frame = child_cell(mesh, step, {0, 0}, child, cell_corners);
        std::optional<CellSurroundings> around =
            cell_surroundings(step.mesh, face_corner(step.mesh, frame, 0, cell_corners), rings, parts);
        if (!around) throw std::logic_error("a small cell has other tags than the large one");
        result.children[child] = std::move(*around);
    }
    return result;
}

}  // namespace tetrakis::detail
