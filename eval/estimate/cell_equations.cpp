#include "cell_equations.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

// In a key: vertices that are corners follow; then half-edges of sectors with angles, each with the halves of its
// angle.
constexpr int k_corners = std::numeric_limits<int>::min(), k_angles = k_corners + 1;

// Levels that a weight is looked at directly; below them it is a sum of others.
constexpr int k_levels = 3;

using Coordinates = std::array<double, 2>;

std::array<double, 4> affine(const Coordinates& p, int corners) {
    if (corners == 3) return {1 - p[0] - p[1], p[0], p[1], 0};
    return {1 - p[0] - p[1], p[0], 0, p[1]};
}
std::array<double, 4> bilinear(const Coordinates& p) {
    const double x = p[0], y = p[1];
    return {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
}
std::array<double, 4> hats(const Coordinates& p, int corners) {
    return corners == 3 ? affine(p, corners) : bilinear(p);
}
std::array<Coordinates, 4> unit_cell(int corners) {
    if (corners == 3) return {{{0, 0}, {1, 0}, {0, 1}, {0, 0}}};
    return {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
}
Coordinates middle(const Coordinates& a, const Coordinates& b) { return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2}; }

/// A cell some levels down, and where its corners are in the first one's coordinates.
struct SmallCell {
    CellFrame frame;
    std::array<Coordinates, 4> at;
};

SmallCell child_of(const RuleMesh& mesh, const RuleStep& step, const SmallCell& cell, int child, int n) {
    SmallCell result{n == 3 ? triangle_child(mesh, step, cell.frame, child) : quad_child(mesh, step, cell.frame, child),
                     cell.at};
    if (n == 3) {
        for (int k = 0; k < 3; ++k)
            result.at[k] =
                child < 3 ? middle(cell.at[k], cell.at[child]) : middle(cell.at[(k + 1) % 3], cell.at[(k + 2) % 3]);
        return result;
    }
    for (int k = 0; k < 4; ++k) result.at[k] = middle(cell.at[k], cell.at[child]);
    return result;
}

/// Where a lattice that goes on from the first face has its vertices: face by face across edges.
std::vector<Coordinates> unrolled(const RuleMesh& mesh, int corners) {
    std::vector<Coordinates> at(mesh.vertex_count());
    std::vector<char> seen(mesh.vertex_count(), 0), entered(mesh.face_count(), 0);
    const std::array<Coordinates, 4> first = unit_cell(corners);
    for (int k = 0; k < corners; ++k) {
        at[mesh.origin(k)] = first[k];
        seen[mesh.origin(k)] = 1;
    }
    std::vector<std::pair<int, std::array<Coordinates, 4>>> queue{{0, first}};  // a half-edge, and its face from there
    entered[0] = 1;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const auto [h, cell] = queue[i];
        int side = h;
        for (int k = 0; k < corners; ++k, side = mesh.next(side)) {
            const int t = mesh.twin(side);
            if (t == RuleMesh::none || entered[mesh.face(t)]) continue;
            entered[mesh.face(t)] = 1;
            const Coordinates &a = cell[k], &b = cell[(k + 1) % corners];
            const auto beyond = [&](const Coordinates& base, const Coordinates& inner, const Coordinates& other) {
                return Coordinates{base[0] + other[0] - inner[0], base[1] + other[1] - inner[1]};
            };
            // The twin leaves b.
            std::array<Coordinates, 4> next{b, a};
            if (corners == 3) {
                next[2] = beyond(a, cell[(k + 2) % 3], b);
            } else {
                next[2] = beyond(a, cell[(k + 3) % 4], a);
                next[3] = beyond(b, cell[(k + 2) % 4], b);
            }
            int at_corner = t;
            for (int c = 0; c < corners; ++c, at_corner = mesh.next(at_corner))
                if (!std::exchange(seen[mesh.origin(at_corner)], 1)) at[mesh.origin(at_corner)] = next[c];
            queue.emplace_back(t, next);
        }
    }
    return at;
}

/// The rows of `fine` as combinations of what those of `coarse` are made of.
std::vector<SparseRow> compose(int points, std::span<const SparseRow> coarse, const StencilTable& fine,
                               std::span<const int> rows) {
    std::vector<SparseRow> result;
    SparseSum sum(points);
    for (const int r : rows) {
        for (std::size_t t = 0; t < fine.points(r).size(); ++t)
            sum.add(coarse[static_cast<std::size_t>(fine.points(r)[t])], fine.weights(r)[t]);
        result.push_back(sum.take());
    }
    return result;
}

bool has_too_many_edges(const RuleMesh& mesh) {
    std::vector<int> edges(mesh.vertex_count(), 0);
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (++edges[mesh.origin(h)] > k_most_edges || ++edges[mesh.target(h)] > k_most_edges) return true;
    }
    return false;
}

/// Returns the small cells, in the order of the children.
std::vector<SmallCell> go_down(const SchemeInfo& scheme, const RuleOptions& options, const RuleMesh& whole,
                               int cell_corners, int rings, int levels, CellDescent& result) {
    const int points = whole.vertex_count();
    std::vector<SmallCell> cells{{{0, 0}, unit_cell(cell_corners)}};
    MeshPartFinder parts;
    // One level's points that matter further down, and the step from them: at vertices of many edges most of what it
    // makes is too far away, and its rows are long.
    std::vector<SparseRow> rows;
    RuleStep step;
    for (int level = 0; level < levels; ++level) {
        const RuleMesh& mesh = level == 0 ? whole : step.mesh;
        std::vector<int> seeds;
        for (const SmallCell& c : cells)
            for (const int v : mesh.corners(mesh.face(c.frame.halfedge))) seeds.push_back(v);
        const MeshPart part = parts.find(mesh, seeds, rings);
        if (level == 0)
            for (const int v : part.vertex) rows.push_back({{v, 1}});
        else
            rows = compose(points, rows, step.stencils, part.vertex);
        RuleStep next = scheme.step(part.mesh, options);
        std::vector<SmallCell> finer;
        for (SmallCell c : cells) {
            c.frame.halfedge = part.halfedge(mesh, c.frame.halfedge);
            for (int child = 0; child < 4; ++child) finer.push_back(child_of(part.mesh, next, c, child, cell_corners));
        }
        step = std::move(next);
        cells = std::move(finer);
    }
    std::vector<int> wanted, place(step.mesh.vertex_count(), -1);
    for (const SmallCell& c : cells) {
        std::optional<CellSurroundings> around =
            cell_surroundings(step.mesh, face_corner(step.mesh, c.frame, 0, cell_corners), rings, parts);
        if (!around) throw std::logic_error("a small cell has other tags than the large one");
        for (int& v : around->vertices) {
            if (place[v] < 0) {
                place[v] = static_cast<int>(wanted.size());
                wanted.push_back(v);
            }
            v = place[v];
        }
        result.children.push_back({std::move(around->key), std::move(around->vertices)});
    }
    result.rows = compose(points, rows, step.stencils, wanted);
    return cells;
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
            // Inner edges alone: where the part ends nothing is known of them.
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
    if (entry.size() != parts.faces().size()) return std::nullopt;  // in pieces
    key.push_back(k_corners);
    key.insert(key.end(), sharp_corners.begin(), sharp_corners.end());
    if (angles.empty()) return result;
    key.push_back(k_angles);
    key.insert(key.end(), angles.begin(), angles.end());
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

SparseRow SparseSum::take() {
    // But rounding, of weights near one that are summed.
    constexpr double k_rounding = 1e-16;
    SparseRow row;
    for (const int i : touched_) {
        if (std::abs(value_[i]) > k_rounding) row.emplace_back(i, value_[i]);
        value_[i] = 0;
        seen_[i] = 0;
    }
    touched_.clear();
    return row;
}

bool CellEquations::annihilates(const SparseRow& functional) const {
    CellAnchor sum{};
    double size = 1;
    for (const auto& [i, weight] : functional) {
        size += std::abs(weight);
        for (std::size_t k = 0; k < 4; ++k) sum[k] += weight * anchor[i][k];
    }
    return std::all_of(sum.begin(), sum.end(), [&](double s) { return std::abs(s) < k_no_weight * size; });
}

std::optional<CellEquations> cell_equations(const SchemeInfo& scheme, const RuleOptions& options,
                                            const SurroundingsKey& key, int cell_corners, int rings) {
    RuleMesh mesh;
    try {
        mesh = surroundings_mesh(key);
    } catch (const std::invalid_argument&) {
        return std::nullopt;
    }
    if (has_too_many_edges(mesh) || !mesh.all_faces_have(cell_corners)) return std::nullopt;
    CellEquations equations;
    const int n = mesh.vertex_count();
    equations.points = n;
    const std::vector<Coordinates> at = unrolled(mesh, cell_corners);
    go_down(scheme, options, mesh, cell_corners, rings, 1, equations.next);
    const std::vector<SmallCell> cells = go_down(scheme, options, mesh, cell_corners, rings, k_levels, equations.below);
    // The vertices of the small cells, without the hats.
    std::vector<SparseRow> off;
    SparseSum sum(n);
    for (std::size_t c = 0; c < cells.size(); ++c)
        for (int k = 0; k < cell_corners; ++k) {
            sum.add(equations.below.rows[equations.below.children[c].vertices[k]], 1);
            const std::array<double, 4> hat = hats(cells[c].at[k], cell_corners);
            for (int i = 0; i < cell_corners; ++i) sum.add(i, -hat[i]);
            off.push_back(sum.take());
        }
    equations.direct.assign(n, 0.0);
    for (const SparseRow& f : off)
        for (const auto& [i, weight] : f) equations.direct[i] = std::max(equations.direct[i], std::abs(weight));
    for (int i = 0; i < n; ++i)
        if (i < cell_corners || equations.direct[i] > k_no_weight) equations.active.push_back(i);
    // The anchor that the rules reproduce.
    const auto reproduces = [&](auto&& anchor) {
        equations.anchor.clear();
        for (int i = 0; i < n; ++i) equations.anchor.push_back(anchor(at[i]));
        return std::all_of(off.begin(), off.end(), [&](const SparseRow& f) { return equations.annihilates(f); });
    };
    // Around many edges a lattice may close after several turns: its points are far from there.
    std::vector<Coordinates> places;
    for (const int i : equations.active) places.push_back(at[i]);
    std::sort(places.begin(), places.end());
    const bool flat = std::adjacent_find(places.begin(), places.end()) == places.end();
    const bool linear = flat && ((cell_corners == 4 && reproduces(bilinear)) ||
                                 reproduces([&](const Coordinates& p) { return affine(p, cell_corners); }));
    if (!linear) equations.anchor = equations.constant();
    return equations;
}

}  // namespace tetrakis::detail
