#include "averaging_level.hpp"

#include "face_split.hpp"
#include "vertex_split.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

/// A mesh with copies of its boundary around it; creases inside are smooth.
struct Layered {
    RuleMesh mesh;
    std::vector<int> source;                ///< vertex of the original mesh that each vertex is a copy of
    std::vector<std::array<int, 2>> outer;  ///< per boundary half-edge of the original: the half-edges of its copies'
                                            ///< quad that leave its origin and its target
    std::vector<int> tip;                   ///< per corner of the original: the half-edge of its quad that leaves it
};

bool is_tip(const RuleMesh& mesh, int v) {
    return mesh.first(v) != RuleMesh::none && mesh.on_boundary(v) && is_sharp(mesh.vertex_sharpness(v));
}

RuleMesh::Builder smooth_faces(const RuleMesh& mesh) {
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) faces.face(mesh.corners(f));
    return faces;
}

Layered smooth_inside(const RuleMesh& mesh) {
    Layered result;
    result.mesh = RuleMesh(mesh.vertex_count(), smooth_faces(mesh), mesh.vertex_sharpness());
    result.source.resize(mesh.vertex_count());
    std::iota(result.source.begin(), result.source.end(), 0);
    return result;
}

/// Adds a layer of copies. `outer` and `tip` are those of the first layer.
void add_layer(Layered& layered) {
    const RuleMesh& mesh = layered.mesh;
    RuleMesh::Builder faces = smooth_faces(mesh);
    int count = mesh.vertex_count();
    std::vector<int> source = layered.source;
    const auto copy = [&](int v) {
        source.push_back(layered.source[v]);
        return count++;
    };
    // Copies of each boundary vertex: for the boundary edge ahead, for the one behind, and at a corner one between.
    std::vector<std::array<int, 3>> copies(mesh.vertex_count(), {-1, -1, -1});
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none || !mesh.on_boundary(v)) continue;
        const int first = copy(v);
        copies[v] = {first, first, -1};
        if (is_tip(mesh, v)) copies[v] = {first, copy(v), copy(v)};
    }
    const bool remember = layered.outer.empty();
    std::vector<std::array<int, 2>> outer(mesh.halfedge_count(), {RuleMesh::none, RuleMesh::none});
    std::vector<int> tip(mesh.vertex_count(), RuleMesh::none);
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        if (mesh.twin(h) != RuleMesh::none) continue;
        const int u = mesh.origin(h), v = mesh.target(h);
        outer[h] = {faces.halfedge_count() + 1, faces.halfedge_count()};
        faces.face({v, u, copies[u][0], copies[v][1]});
    }
    std::vector<float> sharpness;
    if (!mesh.vertex_sharpness().empty()) sharpness.assign(count, 0.0f);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (copies[v][2] < 0) continue;
        tip[v] = faces.halfedge_count();
        faces.face({v, copies[v][1], copies[v][2], copies[v][0]});
        sharpness[copies[v][2]] = mesh.vertex_sharpness(v);
    }
    layered.mesh = RuleMesh(count, std::move(faces), std::move(sharpness));
    layered.source = std::move(source);
    if (!remember) return;
    layered.outer = std::move(outer);
    layered.tip = std::move(tip);
}

/// The number of layers of copies on which the points beside the boundary depend.
int layers_needed(int averagings) { return (averagings + 3) / 4; }

/// The boundary edge between two vertices.
int boundary_edge(const RuleMesh& mesh, int u, int v) {
    const int h = mesh.first(u);
    return mesh.edge(mesh.target(h) == v ? h : mesh.first(v));
}

}  // namespace

AveragingLevel::AveragingLevel(const RuleMesh& mesh, const RuleOptions& options)
    : averagings_(options.averaging_steps),
      // Without averaging no point depends on copies.
      recedes_(options.averaging_boundary == AveragingBoundary::recede && averagings_ != 0) {
    if (averagings_ < 0 || averagings_ > k_most_averaging_steps)
        throw std::invalid_argument("the number of averaging steps must be from 0 to 64");
    sharp_rules_ = averagings_ == 2 && !recedes_;
    Layered layered = smooth_inside(mesh);
    mesh_ = sharp_rules_ || averagings_ == 0 ? mesh : layered.mesh;
    if (!recedes_)
        for (int i = 0; i < layers_needed(averagings_); ++i) add_layer(layered);
    layered_vertices_ = layered.mesh.vertex_count();
    layered_edges_ = layered.mesh.edge_count();
    split_ = split_polygons(layered.mesh, HalfSharpness(layered.mesh));
    outer_ = std::move(layered.outer);
    tip_ = std::move(layered.tip);

    // Vertices, edges and faces of the mesh are the first in the layered mesh, with the same numbers.
    place_.reserve(split_.vertex_count());
    const int V = mesh_.vertex_count(), E = mesh_.edge_count();
    const auto between = [&](int h) {
        const int u = layered.source[layered.mesh.origin(h)], v = layered.source[layered.mesh.target(h)];
        return u == v ? u : V + boundary_edge(mesh_, u, v);
    };
    for (int v = 0; v < layered_vertices_; ++v) place_.push_back(layered.source[v]);
    for (int e = 0; e < layered_edges_; ++e) place_.push_back(e < E ? V + e : between(layered.mesh.edge_halfedge(e)));
    for (int f = 0; f < layered.mesh.face_count(); ++f)
        place_.push_back(f < mesh_.face_count() ? V + E + f : between(layered.mesh.face_begin(f)));
}

int AveragingLevel::vertex_at(int place) const {
    const int V = mesh_.vertex_count(), E = mesh_.edge_count();
    if (place < V) return place;
    return place < V + E ? place - V + layered_vertices_ : place - V - E + layered_vertices_ + layered_edges_;
}

std::vector<char> AveragingLevel::made() const {
    std::vector<char> result(split_.vertex_count());
    for (int v = 0; v < split_.vertex_count(); ++v) result[v] = split_.first(v) != RuleMesh::none;
    return result;
}

std::vector<char> AveragingLevel::made(int averaging, const std::vector<char>& before) const {
    const bool to_quads = averaging % 2 == 0;
    std::vector<char> result(to_quads ? split_.face_count() : split_.vertex_count(), 1);
    if (!to_quads)
        for (int v = 0; v < split_.vertex_count(); ++v) result[v] = !split_.on_boundary(v);
    for (int q = 0; q < split_.face_count(); ++q)
        for (const int v : split_.corners(q)) {
            char& made = to_quads ? result[q] : result[v];
            made = made && before[to_quads ? v : q];
        }
    return result;
}

ShortList<int, 8> AveragingLevel::around(int averaging, int point) const {
    ShortList<int, 8> result;
    if (averaging % 2 == 0)
        for (const int v : split_.corners(point)) result.push_back(v);
    else
        for (const int h : split_.ring(point).halfedge) result.push_back(split_.face(h));
    return result;
}

AveragingLevel::End AveragingLevel::end(const std::vector<char>& made, const BlockRunner* runner,
                                        const std::function<StencilRow(int)>& row) const {
    const bool dual = averagings_ % 2 == 1;
    if (recedes_) return receding(made, row);
    if (dual) return replicated_dual(runner, row);
    const int V = mesh_.vertex_count(), E = mesh_.edge_count();
    End end;
    end.step = split_polygons(
        mesh_, HalfSharpness(mesh_), runner,
        [&](int v) { return mesh_.first(v) == RuleMesh::none ? vertex_itself(v) : row(v); },
        [&](int h) { return row(vertex_at(V + mesh_.edge(h))); }, [&](int f) { return row(vertex_at(V + E + f)); });
    end.centre.resize(mesh_.halfedge_count());
    std::iota(end.centre.begin(), end.centre.end(), 0);
    return end;
}

AveragingLevel::End AveragingLevel::replicated_dual(const BlockRunner* runner,
                                                    const std::function<StencilRow(int)>& row) const {
    const int V = mesh_.vertex_count(), E = mesh_.edge_count();
    End end;
    end.step = split_vertices(
        mesh_, runner, row, [&](int h, int near) { return row(outer_[h][mesh_.origin(h) == near ? 0 : 1]); },
        [&](int v) { return row(tip_[v]); });
    for_each_split_face(
        mesh_, [&](int f) { end.centre.push_back(vertex_at(V + E + f)); },
        [&](int h) { end.centre.push_back(vertex_at(V + mesh_.edge(h))); },
        [&](int v, int) { end.centre.push_back(v); });
    return end;
}

AveragingLevel::End AveragingLevel::receding(const std::vector<char>& made,
                                             const std::function<StencilRow(int)>& row) const {
    End end;
    RuleStep& step = end.step;
    // The new faces are the quads, or vertices, of the split mesh to which one more averaging would give a point.
    const std::vector<char> whole = this->made(averagings_, made);
    const bool primal = averagings_ % 2 == 0;
    std::vector<ShortList<int, 8>> polygons;
    std::vector<int> number(made.size(), RuleMesh::none);
    for (std::size_t i = 0; i < whole.size(); ++i) {
        if (!whole[i]) continue;
        ShortList<int, 8> polygon = around(averagings_, static_cast<int>(i));
        if (polygon.size() < 3) continue;
        for (const int point : polygon) number[point] = 0;
        polygons.push_back(std::move(polygon));
        end.centre.push_back(static_cast<int>(i));
    }
    int count = 0;
    for (std::size_t point = 0; point < number.size(); ++point)
        if (number[point] == 0) {
            number[point] = count++;
            step.stencils.push(row(static_cast<int>(point)));
        }
    if (count == 0) throw std::invalid_argument("the averaging steps use up the whole mesh; replicate its boundary");
    RuleMesh::Builder faces;
    step.child_halfedge.assign(mesh_.halfedge_count(), RuleMesh::none);
    for (std::size_t i = 0; i < polygons.size(); ++i) {
        const ShortList<int, 8>& polygon = polygons[i];
        // Quad q belongs to half-edge q; around a face's centre the quads are in the face's order.
        const auto face = [&](int k) { return mesh_.face(polygon[k]); };
        if (primal) step.child_halfedge[end.centre[i]] = faces.halfedge_count();
        const bool around_face = !primal && face(0) == face(1) && face(1) == face(2);
        for (const int point : polygon) {
            if (around_face) step.child_halfedge[point] = faces.halfedge_count();
            faces.corner(number[point]);
        }
        faces.end_face();
        step.parent_face.push_back(primal ? mesh_.face(end.centre[i]) : face(0));
    }
    step.mesh = RuleMesh(count, std::move(faces));
    return end;
}

}  // namespace tetrakis::detail
