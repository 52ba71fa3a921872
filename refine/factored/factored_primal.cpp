#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../attributes/used_values.hpp"
#include "../lattices/mesh_level.hpp"
#include "factored_steps.hpp"
#include "level_ring.hpp"

#include <limits>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

/// Catmull-Clark and 4-8. Vertices: those of the level, then its faces' points (first half-step), then its edges'
/// points (second), which is the order of refine_to_quads().
class FactoredPrimal final : public FactoredSteps {
  public:
    FactoredPrimal(const ControlMesh& mesh, FactoredScheme scheme)
        : control_(mesh),
          four_eight_(scheme == FactoredScheme::four_eight),
          // Chaikin creasing is Catmull-Clark's.
          method_(four_eight_ ? CreaseMethod::uniform : mesh.crease_method()),
          level_(control_level(control_)) {
        positions_.assign(control_.positions().begin(), control_.positions().end());
        source_.resize(level_.face_count);
        bool quads = true;
        for (std::uint32_t f = 0; f < level_.face_count; ++f) {
            source_[f] = f;
            quads &= level_.size_of(f) == 4;
        }
        if (!four_eight_ || quads) return;
        // The tetrakis mesh: centres are there, nothing has moved.
        previous_ = positions_;
        positions_.resize(std::size_t{level_.vertex_count} + level_.face_count);
        for (std::uint32_t f = 0; f < level_.face_count; ++f)
            positions_[level_.vertex_count + f] = centre(f, nullptr, previous_);
        centred_ = true;
    }

    void half_step(FactoredTrace* trace) override {
        check_counts(counts(), centred_, k_next);
        if (!centred_)
            insert_centres(trace);
        else
            insert_edge_points(trace);
    }

    void check_half_steps(int count) const override {
        LevelCounts at = counts();
        bool centred = centred_;
        for (int i = 0; i < count; ++i, centred = !centred) {
            check_counts(at, centred, half_step_of(i, count));
            if (centred) at = next_counts(at, SchemeKind::catmull_clark);
        }
    }

    FactoredVertex state(std::uint32_t v) const override {
        return v < level_.vertex_count && level_.vertex_halfedge[v] == none ? FactoredVertex::unused
                                                                            : FactoredVertex::active;
    }

    std::vector<std::array<std::uint32_t, 3>> triangles() const override {
        std::vector<std::array<std::uint32_t, 3>> result;
        for_each_triangle([&](std::uint32_t, const std::array<std::uint32_t, 3>& t) { result.push_back(t); });
        return result;
    }

    PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const override {
        if (!has_triangles()) return whole_faces(numbers);
        PolygonMesh result = with_attributes();
        for_each_triangle([&](std::uint32_t f, const std::array<std::uint32_t, 3>& t) { add_face(result, f, t); });
        drop_unused_vertices(result, numbers);
        return result;
    }

    PolygonMesh active_mesh() const override { return whole_faces(nullptr); }

  private:
    PolygonMesh whole_faces(std::vector<std::uint32_t>* numbers) const {
        PolygonMesh result = with_attributes();
        if (centred_) result.positions.assign(previous_.begin(), previous_.end());
        for (std::uint32_t f = 0; f < level_.face_count; ++f)
            add_face(result, f, std::span(&level_.origin[level_.first_halfedge(f)], level_.size_of(f)));
        drop_unused_vertices(result, numbers);
        return result;
    }

    /// What a rule sees: positions of one of the arrays, by number. All reads of rules pass here.
    class Reader {
      public:
        Reader(FactoredTrace* trace, std::uint32_t computed) : trace_(trace), computed_(computed) {}
        const Vec3d& operator()(std::span<const Vec3d> points, std::uint32_t v) const {
            if (trace_ != nullptr) trace_->reads.emplace_back(computed_, v);
            return points[v];
        }

      private:
        FactoredTrace* trace_;
        std::uint32_t computed_;
    };

    /// Calls body(i, scratch) for i in [0, count): in parallel, without a trace.
    template <class Body>
    static void each(std::uint32_t count, const FactoredTrace* trace, Body&& body) {
        const auto block = [&](std::uint32_t begin, std::uint32_t end) {
            LevelRing scratch;
            for (std::uint32_t i = begin; i < end; ++i) body(i, scratch);
        };
        if (trace != nullptr)
            block(0, count);
        else
            for_each_block(count, k_default_grain, block);
    }

    bool has_triangles() const { return centred_ || level_.face_size == 4; }
    bool tagged(std::uint32_t v) const { return level_.has_tags() && level_.tagged[v] != 0; }
    std::uint32_t target(std::uint32_t h) const { return level_.origin[level_.next(h)]; }

    LevelCounts counts() const {
        return {level_.vertex_count, level_.edge_count, level_.face_count, level_.halfedge_count()};
    }

    /// Of a half-step from a level, or from what is between it and the next one.
    void check_counts(const LevelCounts& level, bool centred, std::string_view which) const {
        const LevelCounts finer = next_counts(level, SchemeKind::catmull_clark);
        if (finer.halfedges > std::numeric_limits<std::uint32_t>::max() || finer.vertices >= none)
            refuse_count(finer.halfedges, 32, which);
        // Points now, before and as output; connectivity of the level and of the next one; triangles as output.
        const std::uint64_t H = level.halfedges;
        constexpr std::uint64_t k_per_point = 96, k_per_halfedge = 24, k_per_triangle = 24;
        if (!centred)
            check_memory(k_per_point * (level.vertices + level.faces) + (k_per_halfedge + k_per_triangle) * H, which);
        else
            check_memory(k_per_point * finer.vertices + k_per_halfedge * (H + finer.halfedges) + k_per_triangle * 2 * H,
                         which);
    }

    Vec3d centre(std::uint32_t f, FactoredTrace* trace, std::span<const Vec3d> points) const {
        const Reader read(trace, level_.vertex_count + f);
        const std::uint32_t begin = level_.first_halfedge(f), size = level_.size_of(f);
        const std::uint32_t* v = &level_.origin[begin];
        if (size == 4)
            return 0.25 * ((read(points, v[0]) + read(points, v[1])) + (read(points, v[2]) + read(points, v[3])));
        Vec3d sum(0);
        for (std::uint32_t i = 0; i < size; ++i) sum += read(points, v[i]);
        return sum / static_cast<double>(size);
    }

    /// Calls ring(neighbour) and face(face) around a vertex without tags, returns how many there are.
    template <class Ring, class Face>
    std::uint32_t around(std::uint32_t v, Ring&& ring, Face&& face) const {
        const std::uint32_t start = level_.vertex_halfedge[v];
        std::uint32_t n = 0, h = start;
        do {
            ring(target(h));
            face(level_.face_of(h));
            ++n;
            const std::uint32_t before = level_.prev(h);
            h = level_.twin[before];
            if (h == none) {
                ring(level_.origin[before]);
                break;
            }
        } while (h != start);
        return n;
    }

    // First half-step.
    void insert_centres(FactoredTrace* trace) {
        const std::uint32_t V = level_.vertex_count;
        std::vector<Vec3d> next(std::size_t{V} + level_.face_count);
        each(level_.face_count, trace,
             [&](std::uint32_t f, LevelRing&) { next[V + f] = centre(f, trace, positions_); });
        each(V, trace, [&](std::uint32_t v, LevelRing& scratch) {
            if (level_.vertex_halfedge[v] == none)
                next[v] = positions_[v];
            else
                next[v] = four_eight_ ? waiting_corner(v, trace, scratch) : corner(v, next, trace, scratch);
        });
        previous_ = std::move(positions_);
        positions_ = std::move(next);
        centred_ = true;
    }

    /// Catmull-Clark's corner rule from old neighbours and new centres.
    Vec3d corner(std::uint32_t v, std::span<const Vec3d> next, FactoredTrace* trace, LevelRing& ring) const {
        const Reader read(trace, v);
        const std::uint32_t V = level_.vertex_count;
        const auto smooth = [&] {
            Vec3d edges(0), faces(0);
            std::uint32_t n = 0;
            around(
                v,
                [&](std::uint32_t w) {
                    edges += read(positions_, w);
                    ++n;
                },
                [&](std::uint32_t f) { faces += read(next, V + f); });
            const RingMask m = CatmullClark::vertex_mask(static_cast<int>(n));
            return m.vertex * read(positions_, v) + m.edge * edges + m.face * faces;
        };
        if (!tagged(v)) return smooth();
        ring.gather(level_, method_, v);
        const float s = level_.vertex_sharpness[v];
        const VertexBlend blend = vertex_blend(ring.sharpness, s, ring.child, child_sharpness(s));
        Vec3d point = (blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * read(positions_, v);
        if (blend.crease.weight > 0)
            point +=
                blend.crease.weight * k_crease_vertex_mask.neighbour *
                (read(positions_, ring.neighbours[blend.crease.a]) + read(positions_, ring.neighbours[blend.crease.b]));
        if (blend.smooth > 0) point += blend.smooth * smooth();
        return point;
    }

    VertexRule rule(std::uint32_t v, LevelRing& ring) const {
        if (!tagged(v)) return VertexRule::smooth;
        ring.gather(level_, method_, v);
        return vertex_rule(ring.sharpness, level_.vertex_sharpness[v]);
    }
    static bool waits(VertexRule rule) { return rule == VertexRule::crease || rule == VertexRule::corner; }

    /// 4-8's vertex rule along the sides of the faces; crease vertices wait for the half-step that cuts creases.
    Vec3d waiting_corner(std::uint32_t v, FactoredTrace* trace, LevelRing& ring) const {
        const Reader read(trace, v);
        if (waits(rule(v, ring))) return read(positions_, v);
        Vec3d edges(0);
        std::uint32_t n = 0;
        around(
            v,
            [&](std::uint32_t w) {
                edges += read(positions_, w);
                ++n;
            },
            [](std::uint32_t) {});
        return 0.5 * read(positions_, v) + (0.5 / n) * edges;
    }

    // Second half-step.
    void insert_edge_points(FactoredTrace* trace) {
        const std::uint32_t V = level_.vertex_count, F = level_.face_count, E = level_.edge_count;
        MeshLevel finer = refine_to_quads(level_, method_);
        std::vector<Vec3d> next(std::size_t{V} + F + E);
        if (four_eight_) {
            each(V, trace,
                 [&](std::uint32_t v, LevelRing& scratch) { next[v] = four_eight_vertex(v, trace, scratch); });
            each(F, trace, [&](std::uint32_t f, LevelRing&) { next[V + f] = four_eight_centre(f, trace); });
        } else {
            std::copy(positions_.begin(), positions_.end(), next.begin());
        }
        each(E, trace, [&](std::uint32_t e, LevelRing& scratch) {
            next[V + F + e] = four_eight_ ? four_eight_edge(e, trace) : edge_point(e, trace, scratch);
        });
        std::vector<std::uint32_t> source(finer.face_count);
        for_each_index(finer.face_count, [&](std::uint32_t q) { source[q] = source_[level_.face_of(q)]; });
        source_ = std::move(source);
        level_ = std::move(finer);
        positions_ = std::move(next);
        previous_ = {};
        centred_ = false;
    }

    /// Catmull-Clark's edge rule: the ends as they were, the centres on either side.
    Vec3d edge_point(std::uint32_t e, FactoredTrace* trace, LevelRing& scratch) const {
        const std::uint32_t V = level_.vertex_count, h = level_.edge_halfedge[e], t = level_.twin[h];
        const Reader read(trace, V + level_.face_count + e);
        const Vec3d ends = read(previous_, level_.origin[h]) + read(previous_, target(h));
        if (t == none) return 0.5 * ends;
        const double crease = level_.has_tags() ? crease_weight(level_, method_, e, scratch) : 0;
        if (crease == 1) return 0.5 * ends;
        const Vec3d smooth =
            0.25 * (ends + (read(positions_, V + level_.face_of(h)) + read(positions_, V + level_.face_of(t))));
        return crease == 0 ? smooth : crease * 0.5 * ends + (1 - crease) * smooth;
    }

    Vec3d four_eight_vertex(std::uint32_t v, FactoredTrace* trace, LevelRing& ring) const {
        const Reader read(trace, v);
        const std::uint32_t V = level_.vertex_count;
        if (level_.vertex_halfedge[v] == none) return positions_[v];
        const VertexRule of_v = rule(v, ring);
        if (of_v == VertexRule::corner) return read(positions_, v);
        if (of_v == VertexRule::crease) {
            Vec3d along(0);
            for (std::size_t i = 0; i < ring.neighbours.size(); ++i)
                if (is_sharp(ring.sharpness[i])) along += read(previous_, ring.neighbours[i]);
            return k_crease_vertex_mask.vertex * read(previous_, v) + k_crease_vertex_mask.neighbour * along;
        }
        Vec3d centres(0);
        const std::uint32_t n = around(
            v, [](std::uint32_t) {}, [&](std::uint32_t f) { centres += read(positions_, V + f); });
        return 0.5 * read(positions_, v) + (0.5 / n) * centres;
    }

    Vec3d four_eight_centre(std::uint32_t f, FactoredTrace* trace) const {
        const Reader read(trace, level_.vertex_count + f);
        const std::uint32_t begin = level_.first_halfedge(f), size = level_.size_of(f);
        Vec3d corners(0);
        for (std::uint32_t h = begin; h < begin + size; ++h) corners += read(positions_, level_.origin[h]);
        return 0.5 * read(positions_, level_.vertex_count + f) + (0.5 / size) * corners;
    }

    Vec3d four_eight_edge(std::uint32_t e, FactoredTrace* trace) const {
        const std::uint32_t V = level_.vertex_count, h = level_.edge_halfedge[e], t = level_.twin[h];
        const Reader read(trace, V + level_.face_count + e);
        if (level_.has_tags() && is_sharp(level_.edge_sharpness[e]))
            return 0.5 * (read(previous_, level_.origin[h]) + read(previous_, target(h)));
        return 0.25 * ((read(positions_, level_.origin[h]) + read(positions_, target(h))) +
                       (read(positions_, V + level_.face_of(h)) + read(positions_, V + level_.face_of(t))));
    }

    /// Calls body(face, corners) for all triangles.
    template <class Body>
    void for_each_triangle(Body&& body) const {
        if (!has_triangles()) return;
        for (std::uint32_t f = 0; f < level_.face_count; ++f) {
            const std::uint32_t begin = level_.first_halfedge(f), size = level_.size_of(f);
            const std::uint32_t* v = &level_.origin[begin];
            if (centred_) {
                for (std::uint32_t i = 0; i < size; ++i)
                    body(f, {v[i], v[i + 1 == size ? 0 : i + 1], level_.vertex_count + f});
            } else {
                // A quad of refine_to_quads() is cut from the old vertex to the face's centre, opposite of it.
                body(f, {v[0], v[1], v[2]});
                body(f, {v[0], v[2], v[3]});
            }
        }
    }

    PolygonMesh with_attributes() const {
        PolygonMesh result;
        result.positions = positions_;
        result.face_offsets.push_back(0);
        result.materials = control_.data().materials;
        result.groups = control_.data().groups;
        return result;
    }
    void add_face(PolygonMesh& result, std::uint32_t f, std::span<const std::uint32_t> corners) const {
        const std::uint32_t root = source_[f];
        if (control_.is_hole(FaceId(root))) return;
        result.face_vertices.insert(result.face_vertices.end(), corners.begin(), corners.end());
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
        const ControlMeshData& data = control_.data();
        if (!data.face_material.empty()) result.face_material.push_back(data.face_material[root]);
        if (!data.face_group.empty()) result.face_group.push_back(data.face_group[root]);
    }

    ControlMesh control_;
    bool four_eight_;
    CreaseMethod method_;
    MeshLevel level_;
    bool centred_ = false;               ///< between the two half-steps
    std::vector<Vec3d> previous_;        ///< then: the level's vertices as they were
    std::vector<std::uint32_t> source_;  ///< control face of each face of the level
};

}  // namespace

std::unique_ptr<FactoredSteps> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme) {
    return std::make_unique<FactoredPrimal>(mesh, scheme);
}

}  // namespace tetrakis::detail
