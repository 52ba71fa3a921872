#include "../../hier/base/error.hpp"
#include "../../schemes/parts/averaging_level.hpp"
#include "factored_faces.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_no_number = 0xFFFF'FFFFu;

/// Repeated averaging: first the centres of faces become points, then midpoints are inserted on edges. After that the
/// points alternate between the vertices and the quads of the split mesh; the others rest as centres.
class FactoredAveraging final : public FactoredFaces {
  public:
    FactoredAveraging(const ControlMesh& control, const RuleOptions& rules)
        : FactoredFaces(control), rules_(rules), open_(control.has_boundary()), source_(control.data().source) {
        put_centres();
        set_states();
        own_ = FactoredFaces::active_mesh();
        rules_.runner = nullptr;
        if (rules.averaging_steps < 0 || rules.averaging_steps > k_most_averaging_steps)
            throw Error(ErrorCode::invalid_input, "the number of averaging steps must be from 0 to 64");
    }

    int half_steps_per_level() const override { return 2 + rules_.averaging_steps; }

    void make_half_step() override {
        if (rules_.averaging_steps == 0 && done_ == 2) {
            take_split(HalfSharpness(mesh_));
            put_centres();
        }
        if (done_ == 0)
            rest_centres();
        else if (done_ == 1)
            insert_midpoints();
        else
            average(done_ - 2);
        ++done_;
        if (rules_.averaging_steps == 0 && done_ == 2)
            own_ = polygons(split_polygons(mesh_, HalfSharpness(mesh_)), places());
        if (done_ > 2 && !run_) done_ = 0;
        set_states();
    }

    void check_half_steps(int count) const override {
        // How much a receding boundary leaves does not follow from counts, and the mesh need not grow.
        const bool recedes = rules_.averaging_boundary == AveragingBoundary::recede && open_;
        FactoredFaces::check_half_steps(recedes ? std::min(count, 1) : count);
    }

    std::vector<std::array<std::uint32_t, 3>> triangles() const override {
        return run_ ? averaged_triangles(true) : FactoredFaces::triangles();
    }
    PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const override {
        return run_ ? polygons(averaged_triangles(false), numbers) : FactoredFaces::mesh(numbers);
    }
    PolygonMesh active_mesh() const override { return own_; }

  private:
    Room room(int done) const override {
        // Four quads with four half-edges for each half-edge, those of copies included.
        constexpr std::uint64_t k_most_growth = 64;
        const std::uint64_t growth = rules_.averaging_steps == 0 ? k_growth : k_most_growth;
        return {done == 2 ? growth : 1, done >= 2 ? k_per_finer : k_per_halfedge};
    }

    /// Data for all averagings of a level.
    struct Run {
        AveragingLevel level;
        AveragingLevel::End end;                        ///< its stencil rows name the points themselves
        std::vector<char> made;                         ///< which quads or vertices have points
        std::vector<std::uint32_t> at_vertex, at_quad;  ///< their point numbers
        std::vector<Vec3d> split{};                     ///< positions before the first averaging, for sharp rules
    };

    void average(int averaging) {
        if (averaging == 0) start();
        run_->made = run_->level.made(averaging, run_->made);
        set_points(averaging, run_->made, false);
        // From now on copies have positions of their own.
        if (averaging == 0)
            for (std::size_t v = 0; v < run_->at_vertex.size(); ++v)
                if (run_->level.is_copy(static_cast<int>(v))) run_->at_vertex[v] = k_no_number;
        if (averaging + 1 == rules_.averaging_steps)
            finish();
        else
            set_points(averaging + 1, run_->level.made(averaging + 1, run_->made), true);
    }

    /// Does everything that can fail before anything changes.
    void start() {
        check_halfedge_count(positions_.size(), 1, k_next);
        try {
            AveragingLevel level(mesh_, rules_);
            std::vector<char> first = level.made(), last = first;
            for (int i = 0; i < level.averagings(); ++i) last = level.made(i, last);
            AveragingLevel::End end = level.end(last, nullptr, [](int point) { return StencilRow{{point, 1}}; });
            const std::vector<std::uint32_t> at = places();
            std::vector<std::uint32_t> at_vertex(first.size()), at_quad(level.split().face_count(), k_no_number);
            for (std::size_t v = 0; v < at_vertex.size(); ++v) at_vertex[v] = at[level.place(static_cast<int>(v))];
            Run run{std::move(level), std::move(end), std::move(first), std::move(at_vertex), std::move(at_quad)};
            if (run.level.has_sharp_rules()) run.split = positions_;
            run_ = std::move(run);
        } catch (const std::invalid_argument& e) {
            throw Error(ErrorCode::invalid_input, e.what(), source_);
        }
    }

    /// Sets the points of an averaging; with `rest`, the centres where its points will be, if the mesh has them.
    void set_points(int averaging, const std::vector<char>& made, bool rest) {
        const bool to_quads = averaging % 2 == 0;
        const bool sharp = !rest && !to_quads && run_->level.has_sharp_rules();
        std::vector<std::uint32_t>& to = to_quads ? run_->at_quad : run_->at_vertex;
        const std::vector<std::uint32_t>& from = to_quads ? run_->at_vertex : run_->at_quad;
        for (int i = 0; i < static_cast<int>(made.size()); ++i) {
            if (!made[i]) continue;
            const auto around = run_->level.around(averaging, i);
            if (rest && around.size() < 3) continue;
            if (to[i] == k_no_number) to[i] = add({});
            const auto mean = [&] {
                Vec3d sum(0);
                for (const int p : around) sum += positions_[from[p]];
                return sum / static_cast<double>(around.size());
            };
            positions_[to[i]] = sharp && !run_->level.is_copy(i) ? blended(i, mean) : mean();
        }
    }

    /// For two averagings: Catmull-Clark's rules, from the positions before the first one.
    template <class Mean>
    Vec3d blended(int v, Mean&& mean) const {
        const AveragingLevel& level = run_->level;
        const RuleMesh& mesh = level.mesh();
        const int edge = level.place(v) - mesh.vertex_count();
        if (edge >= mesh.edge_count()) return mean();
        Vec3d point(0);
        if (edge >= 0) {
            const double crease = uniform_crease_weight(mesh.sharpness(mesh.edge_halfedge(edge)));
            if (crease != 0) point += crease * run_->split[run_->at_vertex[v]];
            if (crease != 1) point += (1 - crease) * mean();
            return point;
        }
        const RuleMesh::Ring ring = mesh.ring(v);
        const VertexBlend blend = uniform_vertex_blend(ring.sharpness, mesh.vertex_sharpness(v));
        if (blend.corner != 0) point += blend.corner * run_->split[run_->at_vertex[v]];
        if (blend.crease.weight != 0) {
            // 3/4 of the vertex and 1/8 of each neighbour, by way of the midpoints.
            point += blend.crease.weight * 0.5 * run_->split[run_->at_vertex[v]];
            for (const int i : {blend.crease.a, blend.crease.b}) {
                const int h = i < ring.faces() ? ring.halfedge[i] : mesh.prev(ring.halfedge[i - 1]);
                const int midpoint = level.vertex_at(mesh.vertex_count() + mesh.edge(h));
                point += blend.crease.weight * 0.25 * run_->split[run_->at_vertex[midpoint]];
            }
        }
        if (blend.smooth != 0) point += blend.smooth * mean();
        return point;
    }

    void finish() {
        const bool dual = rules_.averaging_steps % 2 == 1;
        const AveragingLevel::End& end = run_->end;
        const std::vector<std::uint32_t>& points = dual ? run_->at_quad : run_->at_vertex;
        const std::vector<std::uint32_t>& centres = dual ? run_->at_vertex : run_->at_quad;
        vertex_.clear();
        for (int r = 0; r < end.step.stencils.row_count(); ++r)
            vertex_.push_back(points[end.step.stencils.points(r)[0]]);
        centre_.clear();
        for (const int c : end.centre) centre_.push_back(centres[c]);
        mesh_ = end.step.mesh;
        midpoint_.clear();
        whole_ = !dual;
        run_.reset();
        rest_centres();
        own_ = FactoredFaces::active_mesh();
    }

    /// The triangles between two averagings.
    std::vector<std::array<std::uint32_t, 3>> averaged_triangles(bool with_copies) const {
        std::vector<std::array<std::uint32_t, 3>> result;
        const AveragingLevel& level = run_->level;
        const RuleMesh& split = level.split();
        const std::vector<std::uint32_t>&at_vertex = run_->at_vertex, &at_quad = run_->at_quad;
        const int averagings = done_ - 2;
        if (averagings % 2 == 0) {
            for (int q = 0; q < split.face_count(); ++q) {
                if (!with_copies && level.is_quad_of_copies(q)) continue;
                const auto corners = split.corners(q);
                bool whole = true;
                for (const int v : corners) whole = whole && run_->made[v];
                for (std::size_t i = 0; whole && i < corners.size(); ++i)
                    result.push_back({at_vertex[corners[i]], at_vertex[corners[(i + 1) % corners.size()]], at_quad[q]});
            }
            return result;
        }
        std::vector<char> centres = level.made(averagings, run_->made);
        for (int v = 0; v < split.vertex_count(); ++v)
            if (centres[v] && ((!with_copies && level.is_copy(v)) || split.ring(v).faces() < 3)) centres[v] = 0;
        for (int v = 0; v < split.vertex_count(); ++v) {
            if (!centres[v]) continue;
            const RuleMesh::Ring ring = split.ring(v);
            for (int i = 0; i < ring.faces(); ++i) {
                // From quad to quad across an edge: the block there is cut from centre to centre.
                const int w = ring.at(i + 1);
                const int next = split.face(ring.halfedge[(i + 1) % ring.faces()]);
                result.push_back(
                    {at_quad[split.face(ring.halfedge[i])], centres[w] ? at_vertex[w] : at_quad[next], at_vertex[v]});
            }
        }
        return result;
    }

    void set_states() {
        if (!run_) return FactoredFaces::set_states(done_ != 0);
        state_.assign(positions_.size(), FactoredVertex::unused);
        for (const auto& t : averaged_triangles(true))
            for (const std::uint32_t v : t) state_[v] = FactoredVertex::active;
        for (const std::uint32_t c : done_ % 2 == 0 ? run_->at_quad : run_->at_vertex)
            if (c != k_no_number && state_[c] == FactoredVertex::active) state_[c] = FactoredVertex::inactive;
    }

    RuleOptions rules_;
    bool open_;
    std::string source_;
    std::optional<Run> run_;
    PolygonMesh own_;
};

}  // namespace

std::unique_ptr<FactoredFaces> make_factored_averaging(const ControlMesh& mesh, const RuleOptions& rules) {
    return std::make_unique<FactoredAveraging>(mesh, rules);
}

}  // namespace tetrakis::detail
