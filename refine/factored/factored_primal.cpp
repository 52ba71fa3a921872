#include "../../hier/base/parallel.hpp"
#include "../../schemes/parts/face_split.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
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
        if (four_eight_ && !mesh_.all_faces_have(4)) {
            // The tetrakis mesh: centres are there, nothing has moved.
            std::vector<Vec3d> next = with_centres();
            std::copy(positions_.begin(), positions_.end(), next.begin());
            take_centred(std::move(next));
        }
    }

    void make_half_step() override {
        if (!centred())
            insert_centres();
        else
            insert_edge_points();
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
        // Points now, before and as output; connectivity of the level and of the next one; triangles as output.
        constexpr std::uint64_t k_first = 96, k_second = 264;
        return {k_growth, done == 0 ? k_first : k_second};
    }
    /// Between the two half-steps.
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
    /// Between half-steps there is one for each half-edge.
    int face_of_triangle(std::size_t triangle) const override {
        return centred() ? mesh_.face(static_cast<int>(triangle)) : static_cast<int>(triangle / 2);
    }

    template <class Body>
    static void each(int count, const Body& body) {
        for_each_index(static_cast<std::uint32_t>(count), [&](std::uint32_t i) { body(static_cast<int>(i)); });
    }
    /// Calls edge(half-edge of it, neighbour) for the edges and face(face) for the faces around a vertex.
    /// @return  how many edges there are
    template <class Edge, class Face>
    int around(int v, const Edge& edge, const Face& face) const {
        int h = mesh_.first(v), edges = 0;
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
        } while (h != RuleMesh::none && h != mesh_.first(v));
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
        done_ = 1;
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
        std::iota(midpoint_.begin(), midpoint_.end(), static_cast<std::uint32_t>(V + F));
        each(E, [&](int e) {
            const int h = mesh_.edge_halfedge(e);
            next[midpoint_[e]] = four_eight_ ? four_eight_edge(h) : edge_point(h, halves);
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
    /// The split mesh is the next level's, with a quad for each half-edge.
    void take_split(const HalfSharpness& halves) {
        std::vector<std::uint32_t> source;
        for (int h = 0; h < mesh_.halfedge_count(); ++h) source.push_back(source_[mesh_.face(h)]);
        source_ = std::move(source);
        vertex_ = places();
        mesh_ = split_polygons(mesh_, halves);
        at_control_ = false;
        midpoint_.clear();
        centre_.clear();
        done_ = 0;
    }

    ControlMesh control_;
    bool four_eight_, chaikin_, at_control_ = true;
    std::vector<Vec3d> previous_;        ///< between the two half-steps: the level's vertices as they were
    std::vector<std::uint32_t> source_;  ///< control face of each face of the level
};

}  // namespace

std::unique_ptr<FactoredFaces> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme) {
    return std::make_unique<FactoredPrimal>(mesh, scheme);
}

}  // namespace tetrakis::detail
