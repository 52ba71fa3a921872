#include "../../hier/base/parallel.hpp"
#include "../../schemes/parts/face_split.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "factored_faces.hpp"

#include <numeric>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Catmull-Clark and 4-8. Points are numbered: first the level's vertices, then a point in each face (first half-step),
/// then one on each edge (second).
class FactoredPrimal final : public FactoredFaces {
  public:
    FactoredPrimal(const ControlMesh& mesh, FactoredScheme scheme)
        : FactoredFaces(mesh),
          control_(mesh),
          four_eight_(scheme == FactoredScheme::four_eight),
          // Of the two, only Catmull-Clark has Chaikin creases.
          chaikin_(!four_eight_ && mesh.crease_method() == CreaseMethod::chaikin),
          source_(mesh.face_count()) {
        std::iota(source_.begin(), source_.end(), 0u);
        // 4-8 on other faces starts from the tetrakis mesh: centres are inserted, but no vertex moves.
        if (four_eight_ && !mesh_.all_faces_have(4)) insert_centres();
        set_states(true);
    }

    void make_half_step() override {
        if (centred()) {
            insert_edge_points();
        } else {
            insert_centres();
            move_corners();
        }
        set_states(true);
    }
    std::vector<std::array<std::uint32_t, 3>> triangles() const override {
        if (centred()) return FactoredFaces::triangles();
        std::vector<std::array<std::uint32_t, 3>> result;
        if (source_.size() == control_.face_count()) return result;  // at the control faces
        result.reserve(2 * source_.size());
        // A quad is cut from the old vertex to the centre of the old face, which is the opposite corner.
        for (int f = 0; f < mesh_.face_count(); ++f) {
            const std::span<const int> v = mesh_.corners(f);
            result.push_back({vertex_[v[0]], vertex_[v[1]], vertex_[v[2]]});
            result.push_back({vertex_[v[0]], vertex_[v[2]], vertex_[v[3]]});
        }
        return result;
    }
    PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const override {
        const std::vector<std::array<std::uint32_t, 3>> all = triangles();
        return with_names(all.empty() ? polygons(mesh_, vertex_, numbers) : polygons(all, numbers));
    }
    PolygonMesh active_mesh() const override {
        std::vector<std::uint32_t> numbers;
        PolygonMesh result = with_names(polygons(mesh_, vertex_, &numbers));
        for (std::size_t v = 0; centred() && v < numbers.size(); ++v) result.positions[v] = previous_[numbers[v]];
        return result;
    }

  private:
    Room room(int done) const override {
        // Positions (now, before, output), connectivity of this level and the next one, and output triangles.
        constexpr std::uint64_t k_first = 96, k_second = 264;
        return {k_growth, done == 0 ? k_first : k_second};
    }
    /// Whether the mesh is between the two half-steps of a level.
    bool centred() const { return done_ == 1; }

    PolygonMesh with_names(PolygonMesh mesh) const {
        mesh.materials = control_.data().materials;
        mesh.groups = control_.data().groups;
        return mesh;
    }
    bool take(PolygonMesh& to, int face) const override {
        const std::uint32_t root = source_[face];
        if (control_.is_hole(FaceId(root))) return false;
        const ControlMeshData& data = control_.data();
        if (!data.face_material.empty()) to.face_material.push_back(data.face_material[root]);
        if (!data.face_group.empty()) to.face_group.push_back(data.face_group[root]);
        return true;
    }
    /// Between the half-steps a triangle belongs to a half-edge.
    int face_of_triangle(std::size_t triangle) const override {
        return centred() ? mesh_.face(static_cast<int>(triangle)) : static_cast<int>(triangle / 2);
    }

    template <class Body>
    static void each(int count, const Body& body) {
        for_each_index(static_cast<std::uint32_t>(count), [&](std::uint32_t i) { body(static_cast<int>(i)); });
    }
    /// A vertex before it moved, the sum of its neighbours before they moved, and the sum of the centres around it.
    struct Around {
        Vec3d vertex, neighbours{0}, centres{0};
    };
    Around around(int v, const RuleMesh::Ring& ring) const {
        Around result{previous_[vertex_[v]]};
        for (const int neighbour : ring.neighbour) result.neighbours += previous_[vertex_[neighbour]];
        for (const int h : ring.halfedge) result.centres += positions_[centre_[mesh_.face(h)]];
        return result;
    }

    // First half-step.
    void insert_centres() {
        previous_ = positions_;
        put_centres();
        done_ = 1;
    }
    void move_corners() {
        const HalfSharpness halves(mesh_, chaikin_);
        each(mesh_.vertex_count(), [&](int v) {
            if (mesh_.first(v) != RuleMesh::none) positions_[vertex_[v]] = corner(v, halves);
        });
    }
    Vec3d corner(int v, const HalfSharpness& halves) const {
        const RuleMesh::Ring ring = mesh_.ring(v);
        const Around at = around(v, ring);
        // 4-8's vertex rule along the sides of the faces; crease vertices move in the half-step that cuts creases.
        if (four_eight_) return follows_crease(v) ? at.vertex : 0.5 * at.vertex + (0.5 / ring.edges()) * at.neighbours;
        // Catmull-Clark's corner rule from old neighbours and new centres.
        const float s = mesh_.vertex_sharpness(v);
        const VertexBlend blend = vertex_blend(ring.sharpness, s, halves.around(ring), child_sharpness(s));
        Vec3d point = (blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * at.vertex;
        if (blend.crease.weight > 0)
            point += blend.crease.weight * k_crease_vertex_mask.neighbour *
                     (previous_[vertex_[ring.neighbour[blend.crease.a]]] +
                      previous_[vertex_[ring.neighbour[blend.crease.b]]]);
        if (blend.smooth > 0) {
            const RingMask m = CatmullClark::vertex_mask(ring.edges());
            point += blend.smooth * (m.vertex * at.vertex + m.edge * at.neighbours + m.face * at.centres);
        }
        return point;
    }
    bool follows_crease(int v) const {
        const VertexRule rule = mesh_.rule(v);
        return rule == VertexRule::crease || rule == VertexRule::corner;
    }

    // Second half-step.
    void insert_edge_points() {
        const HalfSharpness halves(mesh_, chaikin_);
        insert_midpoints();
        std::vector<Vec3d> next = positions_;
        if (four_eight_) {
            each(mesh_.vertex_count(), [&](int v) { next[vertex_[v]] = four_eight_vertex(v); });
            each(mesh_.face_count(),
                 [&](int f) { next[centre_[f]] = 0.5 * (positions_[centre_[f]] + mean_of_corners(f)); });
        }
        each(mesh_.edge_count(), [&](int e) { next[midpoint_[e]] = edge_point(mesh_.edge_halfedge(e), halves); });
        positions_ = std::move(next);
        previous_ = {};
        // The split mesh, with a quad for each half-edge, is the mesh of the next level.
        std::vector<std::uint32_t> source;
        for (int h = 0; h < mesh_.halfedge_count(); ++h) source.push_back(source_[mesh_.face(h)]);
        source_ = std::move(source);
        take_split(halves);
    }
    /// The edge rule: from the centres on both sides, and the ends before they moved (for 4-8 as they are).
    Vec3d edge_point(int h, const HalfSharpness& halves) const {
        const std::uint32_t u = vertex_[mesh_.origin(h)], w = vertex_[mesh_.target(h)];
        const Vec3d sharp_ends = previous_[u] + previous_[w];
        const int t = mesh_.twin(h);
        const double semi_sharp = four_eight_ ? 0 : halves.crease_weight(h);
        const double crease = t == RuleMesh::none || (four_eight_ && mesh_.sharp(h)) ? 1 : semi_sharp;
        if (crease == 1) return 0.5 * sharp_ends;
        const Vec3d ends = four_eight_ ? positions_[u] + positions_[w] : sharp_ends;
        const Vec3d smooth = 0.25 * (ends + (positions_[centre_[mesh_.face(h)]] + positions_[centre_[mesh_.face(t)]]));
        return crease * 0.5 * sharp_ends + (1 - crease) * smooth;
    }
    Vec3d four_eight_vertex(int v) const {
        const VertexRule rule = mesh_.first(v) == RuleMesh::none ? VertexRule::corner : mesh_.rule(v);
        if (rule == VertexRule::corner) return positions_[vertex_[v]];
        if (rule == VertexRule::crease) {
            Vec3d along(0);
            for (const int neighbour : mesh_.sharp_neighbours(v)) along += previous_[vertex_[neighbour]];
            return k_crease_vertex_mask.vertex * previous_[vertex_[v]] + k_crease_vertex_mask.neighbour * along;
        }
        const RuleMesh::Ring ring = mesh_.ring(v);
        return 0.5 * positions_[vertex_[v]] + (0.5 / ring.edges()) * around(v, ring).centres;
    }

    ControlMesh control_;
    bool four_eight_, chaikin_;
    std::vector<Vec3d> previous_;        ///< between the two half-steps: the level's vertices as they were
    std::vector<std::uint32_t> source_;  ///< control face of each face of the level
};

}  // namespace

std::unique_ptr<FactoredFaces> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme) {
    return std::make_unique<FactoredPrimal>(mesh, scheme);
}

}  // namespace tetrakis::detail
