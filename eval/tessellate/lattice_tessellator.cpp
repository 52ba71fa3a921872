#include "../estimate/limit_estimator.hpp"
#include "../estimate/linear_bound.hpp"
#include "../estimate/mask_norm_bound.hpp"
#include "cell_tessellator.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

namespace tetrakis::detail {

namespace {

/// Peak memory of refining and exporting per triangle, in bytes (leaf, samples, error, output), for the memory limit.
constexpr std::uint64_t k_lattice_bytes = 800;

template <class Family>
class LatticeTessellator final : public CellTessellator<Family> {
  public:
    LatticeTessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : CellTessellator<Family>(mesh, options, context),
          points_(make_hierarchy(mesh, options.scheme.info(),
                                 {.rules = options.rules, .whole_levels = true, .context = context})) {}

  private:
    using Base = CellTessellator<Family>;
    using Base::hierarchy_, Base::refinement_, Base::fans_, Base::corners_, Base::exported_, Base::origin;
    using Base::mesh_, Base::options_, Base::context_, Base::result_, Base::aim_, Base::certified;

    void prepare() override {
        hierarchy_.emplace(mesh_);
        // Within a budget errors are compared with each other, so all of them must be tight.
        const double decide_at = options_.max_triangles != 0 ? 0.0 : aim_;
        if (options_.scheme.info().is_linear()) bound_ = std::make_unique<LinearBound>(mesh_, options_.scheme.info());
        // MaskNormBound takes several times as long as all else, so the measured estimator does without it.
        else if (certified() && MaskNormBound<Family>::has(options_.scheme.info(), options_.rules, mesh_))
            bound_ =
                std::make_unique<MaskNormBound<Family>>(points_, options_.scheme.info(), options_.rules, decide_at);
        if (certified() && !bound_)
            throw Error(
                ErrorCode::unsupported,
                "there is no certified bound where edges or vertices are semi-sharp for more than 6 levels, or more "
                "than 64 edges meet or bound a face; use the measured estimator, or change the mesh there",
                mesh_.data().source);
        if (!certified()) by_points_.emplace(points_, decide_at);
    }

    void refine() override {
        this->refine_by(certified() ? static_cast<const ErrorEstimator&>(*bound_) : *by_points_, points_.memory_bytes(),
                        k_lattice_bytes);
    }

    void place(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d>, std::string_view stage,
               double share) override {
        limit_positions(points_, sites, positions, [&](double done) { context_.report(stage, share * done); });
    }
    void fan_errors(std::span<const FaceId> faces, std::span<double> errors) override {
        if (certified())
            bound_->bound_fans(fans_, faces, corners_, {}, errors);
        else
            fan_limit_errors(points_, fans_, faces, corners_, errors);
    }

    /// Measures against limit points of all leaves (those under fans, too), each cut in four a few times.
    void measure() override {
        const auto& forest = hierarchy_->forest();
        const std::uint64_t count = forest.leaf_count();
        const int bits = reference_bits(count, result_.deepest_level);
        check_reference_memory(count << (2 * bits), context_);
        typename Family::Hierarchy finer = *hierarchy_;
        std::vector<LeafId> marked, fresh;
        if constexpr (std::is_same_v<Family, LoopFamily>) {
            for (int i = 0; i < bits; ++i) finer.refine(finer.forest().ordered_leaves(), fresh);
        } else {
            // Two bisections of all leaves halve each edge once, so no other leaf has to be split. But a leaf may be
            // split early, together with its neighbour: only parts that are not deep enough are marked. Parts of a leaf
            // follow each other in the order of `leaves`.
            const std::vector<LeafId> leaves = forest.ordered_leaves();
            for (marked = leaves; !marked.empty();) {
                finer.refine(marked, fresh);
                marked.clear();
                auto whole = leaves.begin();
                double rest = 1;
                for (const LeafId part : finer.forest().ordered_leaves()) {
                    const int deeper = finer.forest().depth(part) - forest.depth(*whole);
                    if (deeper < 2 * bits) marked.push_back(part);
                    rest -= std::ldexp(1.0, -deeper);
                    if (rest == 0) ++whole, rest = 1;
                }
            }
        }
        this->measure_against(finer);
    }

    /// Sets no error if some fan has no bound.
    void certify() override {
        if (!bound_) return;
        // With the certified estimator, estimates within the aim are certified already.
        const auto known = [&](std::uint32_t t) {
            const double error = this->estimated_error(t);
            return certified() && error <= aim_ ? error : std::numeric_limits<double>::infinity();
        };
        const double largest = this->largest_error(
            known, [&](std::span<const std::uint32_t> triangles, double floor, std::span<double> errors) {
                const auto fans_begin =
                    std::ranges::find_if(triangles, [&](std::uint32_t t) { return !exported_.leaves[t].valid(); });
                const std::size_t cell_count = static_cast<std::size_t>(fans_begin - triangles.begin());
                std::vector<CellTriangle> cells;
                std::vector<FaceId> faces;
                for (const std::uint32_t t : triangles.first(cell_count)) cells.push_back(origin(t).cell);
                for (const std::uint32_t t : triangles.subspan(cell_count)) faces.push_back(exported_.faces[t]);
                bound_->bound(cells, floor, errors.first(cell_count));
                bound_->bound_fans(fans_, faces, corners_, floor, errors.subspan(cell_count));
            });
        if (std::isfinite(largest)) result_.certified_error = largest;
    }

    void add_attributes() override {
        this->warn_of_fine_control_mesh();
        Base::add_attributes();
    }

    /// Adds normals of the limit surface; of the triangles, with a warning, if limit normals need whole levels that are
    /// too large.
    void add_normals() override {
        TriangleMesh& mesh = result_.mesh;
        mesh.normals.resize(mesh.positions.size());
        const auto limit_normals = [&](std::span<const Site> sites, std::span<Vec3d> normals) {
            points_.normals(sites, normals);
        };
        try {
            constexpr std::size_t k_block = 1u << 16;
            for (std::size_t begin = 0; begin < mesh.normals.size(); begin += k_block) {
                context_.report("attributes",
                                0.4 * static_cast<double>(begin) / static_cast<double>(mesh.normals.size()));
                const std::size_t size = std::min(k_block, mesh.normals.size() - begin);
                limit_normals(std::span(exported_.sites).subspan(begin, size), {&mesh.normals[begin], size});
            }
            this->split_creases(this->normals_from_inside(limit_normals));
        } catch (const Error& error) {
            if (error.code() != ErrorCode::unsupported && error.code() != ErrorCode::memory_limit) throw;
            mesh.triangle_normals.clear();
            geometric_normals(mesh);
            this->split_creases();
            result_.warnings.push_back(
                "the normals are those of the triangles: for the limit surface's the rules would "
                "have to make levels that are too large");
        }
    }

    std::vector<Vec2d> corner_uvs() override {
        ControlMesh chart;
        std::optional<Hierarchy> points;
        try {
            if (mesh_.face_varying_rule() != FaceVaryingRule::linear_all) {
                const auto untagged = without_ignored_tags(mesh_, options_.scheme.info(), options_.rules);
                chart = uv_mesh(untagged ? *untagged : mesh_, options_.rules);
                points.emplace(this->chart_hierarchy(chart));
            }
        } catch (const Error& error) {
            result_.warnings.push_back(std::string("the UV layer cannot be subdivided and is interpolated linearly (") +
                                       error.what() + ")");
        }
        const auto address = [&](std::size_t corner) {
            return this->corner_site(static_cast<std::uint32_t>(corner / 3), corner % 3);
        };
        return this->chart_uvs(
            points, [&](std::size_t corner) { return Family::canonical_site(chart, address(corner)); },
            [&](std::size_t corner) {
                const Site s = address(corner);
                const double step = std::ldexp(1.0, -s.level);
                return Family::linear(mesh_, s.root, s.at.x * step, s.at.y * step,
                                      [&](HalfedgeId h) { return mesh_.data().uvs[mesh_.uv_index(h)]; });
            });
    }

    Hierarchy points_;
    std::unique_ptr<SurfaceBound> bound_;
    std::optional<LimitEstimator<Family>> by_points_;
};

}  // namespace

Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context) {
    if (options.scheme.info().family == MeshFamily::triangles)
        return LatticeTessellator<LoopFamily>(mesh, options, context).run();
    return LatticeTessellator<QuadFamily>(mesh, options, context).run();
}

}  // namespace tetrakis::detail
