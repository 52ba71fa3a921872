#include "../../hier/base/parallel.hpp"
#include "../../schemes/parts/face_split.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../attributes/used_values.hpp"
#include "factored_faces.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Catmull-Clark and 4-8. Points: those of the level's vertices, then its faces' (first half-step), then its edges'
/// (second).
class FactoredPrimal final : public FactoredFaces {
  public:
    FactoredPrimal(const ControlMesh& mesh, FactoredScheme scheme)
        : FactoredFaces(mesh),
          control_(mesh),
          four_eight_(scheme == FactoredScheme::four_eight),
          // Chaikin creasing is Catmull-Clark's.
          chaikin_(!four_eight_ && mesh.crease_method() == CreaseMethod::chaikin),
          source_(mesh.face_count()) {
        std::iota(source_.begin(), source_.end(), 0u);
        for (std::uint32_t e = 0; e < mesh.edge_count(); ++e)
            edge_halfedge_.push_back(static_cast<int>(mesh.edge_halfedge(EdgeId(e)).value));
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            start_.push_back(static_cast<int>(mesh.vertex_halfedge(VertexId(v)).value));
        if (four_eight_ && !mesh_.all_faces_have(4)) {
            // The tetrakis mesh: centres are there, nothing has moved.
            std::vector<Vec3d> next = with_centres();
            std::copy(positions_.begin(), positions_.end(), next.begin());
            take_centred(std::move(next));
        }
    }

    void half_step() override {
        check_counts(counts(), centred(), k_next);
        if (!centred())
            insert_centres();
        else
            insert_edge_points();
    }
    void check_half_steps(int count) const override {
        Counts at = counts();
        bool between = centred();
        for (int i = 0; i < count; ++i, between = !between) {
            check_counts(at, between, half_step_of(i, count));
            if (between) at = at.next();
        }
    }
    FactoredVertex state(std::uint32_t v) const override {
        const bool isolated = v < control_.vertex_count() && control_.is_isolated(VertexId(v));
        return isolated ? FactoredVertex::unused : FactoredVertex::active;
    }
    std::vector<std::array<std::uint32_t, 3>> triangles() const override {
        if (centred()) return FactoredFaces::triangles();
        std::vector<std::array<std::uint32_t, 3>> result;
        if (at_control_) return result;
        result.reserve(2 * static_cast<std::size_t>(mesh_.face_count()));
        // A quad is cut from the old vertex to the old face's centre, opposite of it.
        for (int f = 0; f < mesh_.face_count(); ++f) {
            const std::span<const int> v = mesh_.corners(f);
            result.push_back({vertex_[v[0]], vertex_[v[1]], vertex_[v[2]]});
            result.push_back({vertex_[v[0]], vertex_[v[2]], vertex_[v[3]]});
        }
        return result;
    }
    PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const override {
        const std::vector<std::array<std::uint32_t, 3>> all = triangles();
        if (all.empty()) return whole_faces(numbers);
        PolygonMesh result = with_attributes();
        result.face_vertices.reserve(3 * all.size());
        result.face_offsets.reserve(all.size() + 1);
        for (std::size_t t = 0; t < all.size(); ++t)
            // Between half-steps there is one for each half-edge.
            add_face(result, centred() ? mesh_.face(static_cast<int>(t)) : static_cast<int>(t / 2), all[t]);
        drop_unused_vertices(result, numbers);
        return result;
    }
    PolygonMesh active_mesh() const override { return whole_faces(nullptr); }

  private:
    struct Counts {
        std::uint64_t vertices, edges, faces, halfedges;
        Counts next() const { return {vertices + faces + edges, 2 * edges + halfedges, halfedges, 4 * halfedges}; }
    };
    Counts counts() const {
        return {static_cast<std::uint64_t>(mesh_.vertex_count()), static_cast<std::uint64_t>(mesh_.edge_count()),
                static_cast<std::uint64_t>(mesh_.face_count()), halfedges()};
    }
    /// Of a half-step from a level, or from what is between it and the next one.
    void check_counts(const Counts& level, bool between, std::string_view which) const {
        check_halfedge_count(level.halfedges, k_growth, which);
        // Points now, before and as output; connectivity of the level and of the next one; triangles as output.
        const std::uint64_t H = level.halfedges;
        constexpr std::uint64_t k_per_point = 96, k_per_halfedge = 24, k_per_triangle = 24;
        if (!between)
            check_memory(k_per_point * (level.vertices + level.faces) + (k_per_halfedge + k_per_triangle) * H, which);
        else
            check_memory(k_per_point * level.next().vertices + k_per_halfedge * (H + level.next().halfedges) +
                             k_per_triangle * 2 * H,
                         which);
    }
    /// Between the two half-steps.
    bool centred() const { return !centre_.empty(); }

    PolygonMesh whole_faces(std::vector<std::uint32_t>* numbers) const {
        PolygonMesh result = with_attributes();
        if (centred()) result.positions = previous_;
        std::vector<std::uint32_t> corners;
        for (int f = 0; f < mesh_.face_count(); ++f) {
            corners.clear();
            for (const int v : mesh_.corners(f)) corners.push_back(vertex_[v]);
            add_face(result, f, corners);
        }
        drop_unused_vertices(result, numbers);
        return result;
    }
    PolygonMesh with_attributes() const {
        PolygonMesh result;
        result.positions = positions_;
        result.face_offsets.push_back(0);
        result.materials = control_.data().materials;
        result.groups = control_.data().groups;
        return result;
    }
    void add_face(PolygonMesh& result, int f, std::span<const std::uint32_t> corners) const {
        const std::uint32_t root = source_[f];
        if (control_.is_hole(FaceId(root))) return;
        result.face_vertices.insert(result.face_vertices.end(), corners.begin(), corners.end());
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
        const ControlMeshData& data = control_.data();
        if (!data.face_material.empty()) result.face_material.push_back(data.face_material[root]);
        if (!data.face_group.empty()) result.face_group.push_back(data.face_group[root]);
    }

    template <class Body>
    static void each(int count, const Body& body) {
        for_each_index(static_cast<std::uint32_t>(count), [&](std::uint32_t i) { body(static_cast<int>(i)); });
    }
    /// Calls edge(half-edge of it, neighbour) for the edges and face(face) for the faces around a vertex, from start_
    /// on.
    /// @return  how many edges there are
    template <class Edge, class Face>
    int around(int v, const Edge& edge, const Face& face) const {
        int h = start_[v], edges = 0;
        do {
            edge(h, mesh_.target(h));
            face(mesh_.face(h));
            ++edges;
            const int before = mesh_.prev(h);
            h = mesh_.twin(before);
            if (h == RuleMesh::none) {
                edge(before, mesh_.origin(before));
                ++edges;
            }
        } while (h != RuleMesh::none && h != start_[v]);
        return edges;
    }
    VertexRule rule(int v) const {
        bool sharp = is_sharp(mesh_.vertex_sharpness(v));
        around(
            v, [&](int h, int) { sharp = sharp || mesh_.sharp(h); }, [](int) {});
        return sharp ? mesh_.rule(v) : VertexRule::smooth;
    }

    /// Room for the next positions, with those of the faces.
    std::vector<Vec3d> with_centres() const {
        const int V = mesh_.vertex_count();
        std::vector<Vec3d> next(static_cast<std::size_t>(V + mesh_.face_count()));
        each(mesh_.face_count(), [&](int f) {
            const std::span<const int> v = mesh_.corners(f);
            Vec3d& point = next[static_cast<std::size_t>(V + f)];
            if (v.size() == 4) {
                point = 0.25 * ((positions_[vertex_[v[0]]] + positions_[vertex_[v[1]]]) +
                                (positions_[vertex_[v[2]]] + positions_[vertex_[v[3]]]));
                return;
            }
            Vec3d sum(0);
            for (const int corner : v) sum += positions_[vertex_[corner]];
            point = sum / static_cast<double>(v.size());
        });
        return next;
    }
    void take_centred(std::vector<Vec3d> next) {
        previous_ = std::exchange(positions_, std::move(next));
        centre_.resize(static_cast<std::size_t>(mesh_.face_count()));
        std::iota(centre_.begin(), centre_.end(), static_cast<std::uint32_t>(mesh_.vertex_count()));
    }

    // First half-step.
    void insert_centres() {
        std::vector<Vec3d> next = with_centres();
        const HalfSharpness halves(mesh_, chaikin_);
        each(mesh_.vertex_count(), [&](int v) {
            Vec3d& point = next[vertex_[v]];
            if (mesh_.first(v) == RuleMesh::none)
                point = positions_[vertex_[v]];
            else
                point = four_eight_ ? waiting_corner(v) : corner(v, halves, next);
        });
        take_centred(std::move(next));
    }
    /// Catmull-Clark's corner rule from old neighbours and new centres.
    Vec3d corner(int v, const HalfSharpness& halves, const std::vector<Vec3d>& next) const {
        const auto smooth = [&] {
            const auto first = static_cast<std::uint32_t>(mesh_.vertex_count());
            Vec3d edges(0), faces(0);
            const int n = around(
                v, [&](int, int neighbour) { edges += positions_[vertex_[neighbour]]; },
                [&](int f) { faces += next[first + static_cast<std::uint32_t>(f)]; });
            const RingMask m = CatmullClark::vertex_mask(n);
            return m.vertex * positions_[vertex_[v]] + m.edge * edges + m.face * faces;
        };
        if (rule(v) == VertexRule::smooth) return smooth();
        const RuleMesh::Ring ring = mesh_.ring(v);
        const float s = mesh_.vertex_sharpness(v);
        const VertexBlend blend = vertex_blend(ring.sharpness, s, halves.around(ring), child_sharpness(s));
        Vec3d point = (blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * positions_[vertex_[v]];
        if (blend.crease.weight > 0)
            point += blend.crease.weight * k_crease_vertex_mask.neighbour *
                     (positions_[vertex_[ring.neighbour[blend.crease.a]]] +
                      positions_[vertex_[ring.neighbour[blend.crease.b]]]);
        if (blend.smooth > 0) point += blend.smooth * smooth();
        return point;
    }
    /// 4-8's vertex rule along the sides of the faces; crease vertices wait for the half-step that cuts creases.
    Vec3d waiting_corner(int v) const {
        const VertexRule rule = this->rule(v);
        if (rule == VertexRule::crease || rule == VertexRule::corner) return positions_[vertex_[v]];
        Vec3d edges(0);
        const int n = around(
            v, [&](int, int neighbour) { edges += positions_[vertex_[neighbour]]; }, [](int) {});
        return 0.5 * positions_[vertex_[v]] + (0.5 / n) * edges;
    }

    // Second half-step.
    void insert_edge_points() {
        const int V = mesh_.vertex_count(), F = mesh_.face_count(), E = mesh_.edge_count();
        const HalfSharpness halves(mesh_, chaikin_);
        std::vector<Vec3d> next(static_cast<std::size_t>(V) + F + E);
        if (four_eight_) {
            each(V, [&](int v) { next[vertex_[v]] = four_eight_vertex(v); });
            each(F, [&](int f) { next[centre_[f]] = four_eight_centre(f); });
        } else {
            std::copy(positions_.begin(), positions_.end(), next.begin());
        }
        midpoint_.resize(static_cast<std::size_t>(E));
        each(E, [&](int e) {
            const int h = edge_halfedge_[e];
            const auto number = static_cast<std::uint32_t>(V + F + e);
            midpoint_[mesh_.edge(h)] = number;
            next[number] = four_eight_ ? four_eight_edge(h) : edge_point(h, halves);
        });
        positions_ = std::move(next);
        previous_ = {};
        take_split(halves);
    }
    /// Catmull-Clark's edge rule: the ends as they were, the centres on either side.
    Vec3d edge_point(int h, const HalfSharpness& halves) const {
        const Vec3d ends = previous_[vertex_[mesh_.origin(h)]] + previous_[vertex_[mesh_.target(h)]];
        const int t = mesh_.twin(h);
        if (t == RuleMesh::none) return 0.5 * ends;
        const double crease = halves.crease_weight(h);
        if (crease == 1) return 0.5 * ends;
        const Vec3d smooth = 0.25 * (ends + (positions_[centre_[mesh_.face(h)]] + positions_[centre_[mesh_.face(t)]]));
        return crease == 0 ? smooth : crease * 0.5 * ends + (1 - crease) * smooth;
    }
    Vec3d four_eight_vertex(int v) const {
        if (mesh_.first(v) == RuleMesh::none) return positions_[vertex_[v]];
        const VertexRule rule = this->rule(v);
        if (rule == VertexRule::corner) return positions_[vertex_[v]];
        if (rule == VertexRule::crease) {
            Vec3d along(0);
            for (const int neighbour : mesh_.sharp_neighbours(v)) along += previous_[vertex_[neighbour]];
            return k_crease_vertex_mask.vertex * previous_[vertex_[v]] + k_crease_vertex_mask.neighbour * along;
        }
        Vec3d faces(0);
        const int n = around(
            v, [](int, int) {}, [&](int f) { faces += positions_[centre_[f]]; });
        return 0.5 * positions_[vertex_[v]] + (0.5 / n) * faces;
    }
    Vec3d four_eight_centre(int f) const {
        Vec3d sum(0);
        for (const int v : mesh_.corners(f)) sum += positions_[vertex_[v]];
        return 0.5 * positions_[centre_[f]] + (0.5 / mesh_.face_size(f)) * sum;
    }
    Vec3d four_eight_edge(int h) const {
        const std::uint32_t u = vertex_[mesh_.origin(h)], w = vertex_[mesh_.target(h)];
        if (mesh_.sharp(h)) return 0.5 * (previous_[u] + previous_[w]);
        return 0.25 * ((positions_[u] + positions_[w]) +
                       (positions_[centre_[mesh_.face(h)]] + positions_[centre_[mesh_.face(mesh_.twin(h))]]));
    }
    /// The split mesh is the next level's.
    void take_split(const HalfSharpness& halves) {
        const int E = mesh_.edge_count(), H = mesh_.halfedge_count();
        // Quad h is at the origin of half-edge h; its corners are that, the edge's point, the face's, the edge's
        // before.
        const auto second_half = [&](int h) { return 4 * mesh_.next(h) + 3; };
        const auto vertices = static_cast<std::size_t>(mesh_.vertex_count());
        std::vector<int> start(vertices + static_cast<std::size_t>(E + mesh_.face_count())),
            edge_halfedge(static_cast<std::size_t>(2 * E + H));
        for (std::size_t v = 0; v < vertices; ++v) start[v] = start_[v] == RuleMesh::none ? start_[v] : 4 * start_[v];
        for (int e = 0; e < E; ++e) {
            const int h = edge_halfedge_[e];
            start[vertices + static_cast<std::size_t>(mesh_.edge(h))] = second_half(h);
            edge_halfedge[2 * e] = 4 * h;
            edge_halfedge[2 * e + 1] = second_half(h);
        }
        std::vector<std::uint32_t> source(static_cast<std::size_t>(H));
        for (int h = 0; h < H; ++h) {
            edge_halfedge[2 * E + h] = 4 * h + 1;
            source[h] = source_[mesh_.face(h)];
        }
        for (int f = 0; f < mesh_.face_count(); ++f)
            start[vertices + static_cast<std::size_t>(E + f)] = 4 * mesh_.face_begin(f) + 2;
        start_ = std::move(start);
        edge_halfedge_ = std::move(edge_halfedge);
        source_ = std::move(source);
        vertex_ = places();
        mesh_ = split_polygons(mesh_, halves);
        at_control_ = false;
        midpoint_.clear();
        centre_.clear();
    }

    ControlMesh control_;
    bool four_eight_, chaikin_, at_control_ = true;
    std::vector<Vec3d> previous_;        ///< between the two half-steps: the level's vertices as they were
    std::vector<std::uint32_t> source_;  ///< control face of each face of the level
    std::vector<int> edge_halfedge_;     ///< a half-edge of each edge, in the order of the edges' points
    std::vector<int> start_;             ///< by vertex: the half-edge that sums around it begin with
};

}  // namespace

std::unique_ptr<FactoredFaces> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme) {
    return std::make_unique<FactoredPrimal>(mesh, scheme);
}

}  // namespace tetrakis::detail
