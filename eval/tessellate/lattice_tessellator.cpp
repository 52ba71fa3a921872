#include "../estimate/limit_estimator.hpp"
#include "../estimate/linear_bound.hpp"
#include "../estimate/mask_norm_bound.hpp"
#include "cell_tessellator.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tetrakis::detail {

namespace {

/// Peak memory of refining and exporting per triangle, in bytes (leaf, samples, error, output), for the memory limit.
constexpr std::uint64_t k_lattice_bytes = 800, k_sqrt3_bytes = 500;

struct Sqrt3Family {
    using Hierarchy = Sqrt3Hierarchy;
};

/// A tessellation by the limit points of the scheme's hierarchy.
template <class Family>
class LimitTessellator : public CellTessellator<Family> {
  public:
    LimitTessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : CellTessellator<Family>(mesh, options, context),
          points_(make_hierarchy(mesh, options.scheme.info(),
                                 {.rules = options.rules, .whole_levels = true, .context = context})) {}

  protected:
    using Base = CellTessellator<Family>;
    using Base::hierarchy_, Base::options_, Base::context_, Base::result_;

    void place(std::span<const Site> sites, std::span<Vec3d> positions, std::string_view stage, double share) override {
        limit_positions(points_, sites, positions, [&](double done) { context_.report(stage, share * done); });
    }
    void limit_normals(std::span<const Site> sites, std::span<Vec3d> normals) const override {
        points_.normals(sites, normals);
    }
    /// Measures against limit points of all leaves (those under fans, too), each cut in four a few times; sqrt(3)
    /// leaves are cut in three about as finely.
    void measure() override {
        const auto& forest = hierarchy_->forest();
        constexpr int k_parts = std::is_same_v<Family, Sqrt3Family> ? 3 : 4;
        const double cuts =
            reference_bits(forest.leaf_count(), result_.deepest_level) * std::log(4.0) / std::log(k_parts);
        const int splits = static_cast<int>(std::ceil(cuts - 0.1));  // 3^5 are nearly 4^4
        check_reference_memory(forest.leaf_count() * static_cast<std::uint64_t>(std::pow(k_parts, splits)), context_);
        context_.report("measure", 0);
        typename Family::Hierarchy finer = *hierarchy_;
        std::vector<LeafId> marked, fresh;
        if constexpr (!std::is_same_v<Family, QuadFamily>) {
            for (int i = 0; i < splits; ++i) finer.refine(finer.forest().ordered_leaves(), fresh);
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
                    if (deeper < 2 * splits) marked.push_back(part);
                    rest -= std::ldexp(1.0, -deeper);
                    if (rest == 0) ++whole, rest = 1;
                }
            }
        }
        ExportedTriangles leaves = finer.forest().exported();
        TriangleMesh reference;
        reference.triangles = std::move(leaves.triangles);
        reference.positions.resize(leaves.sites.size());
        place(leaves.sites, reference.positions, "measure", 0.5);
        measure_triangles(reference, result_, options_.measure_samples / 2, context_);
    }

    Hierarchy points_;
};

template <class Family>
class LatticeTessellator final : public LimitTessellator<Family> {
  public:
    using LimitTessellator<Family>::LimitTessellator;

  private:
    using Base = LimitTessellator<Family>;
    using Base::hierarchy_, Base::points_, Base::fans_, Base::corners_, Base::exported_, Base::origin;
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

    void fan_errors(std::span<const FaceId> faces, std::span<double> errors) override {
        if (certified())
            bound_->bound_fans(fans_, faces, corners_, {}, errors);
        else
            fan_limit_errors(points_, fans_, faces, corners_, errors);
    }

    /// Sets no error if some fan has no bound.
    void certify() override {
        if (!bound_) return;
        const double largest =
            this->largest_error([&](std::span<const std::uint32_t> triangles, double floor, std::span<double> errors) {
                std::vector<CellTriangle> cells;
                std::vector<FaceId> faces;
                for (const std::uint32_t t : triangles)
                    if (exported_.leaves[t].valid())
                        cells.push_back(origin(t).cell);
                    else
                        faces.push_back(exported_.faces[t]);
                bound_->bound(cells, floor, errors.first(cells.size()));
                bound_->bound_fans(fans_, faces, corners_, floor, errors.last(faces.size()));
            });
        if (std::isfinite(largest)) result_.certified_error = largest;
    }

    void add_attributes() override {
        this->warn_of_fine_control_mesh();
        Base::add_attributes();
    }

    std::vector<Vec2d> corner_uvs() override {
        const auto address = [&](std::size_t corner) {
            return this->corner_site(static_cast<std::uint32_t>(corner / 3), corner % 3);
        };
        return this->chart_uvs([&](const ControlMesh& charts,
                                   std::size_t corner) { return Family::canonical_site(charts, address(corner)); },
                               [&](std::size_t corner) {
                                   const Site s = address(corner);
                                   const double step = std::ldexp(1.0, -s.level);
                                   return Family::linear(
                                       mesh_, s.root, s.at.x * step, s.at.y * step,
                                       [&](HalfedgeId h) { return mesh_.data().uvs[mesh_.uv_index(h)]; });
                               },
                               true);
    }

    std::unique_ptr<SurfaceBound> bound_;
    std::optional<LimitEstimator> by_points_;
};

bool is_linear(const ControlMesh& mesh) { return mesh.face_varying_rule() == FaceVaryingRule::linear_all; }

/// Whether a sqrt(3) forest must keep an edge, so that each leaf lies on one side of all seams: of materials, groups
/// and the UV layer. With linear UVs, all edges are kept.
std::function<bool(EdgeId)> sqrt3_seams(const ControlMesh& mesh, bool uvs) {
    const ControlMeshData& data = mesh.data();
    return [&mesh, &data, uvs = uvs && mesh.has_uvs()](EdgeId e) {
        const HalfedgeId h = mesh.edge_halfedge(e), t = mesh.twin(h);
        const auto differs = [](const std::vector<std::uint32_t>& of, auto a, auto b) {
            return !of.empty() && of[a.value] != of[b.value];
        };
        if (uvs &&
            (is_linear(mesh) || differs(data.face_uvs, h, mesh.next(t)) || differs(data.face_uvs, mesh.next(h), t)))
            return true;
        const FaceId here = mesh.face(h), there = mesh.face(t);
        return differs(data.face_material, here, there) || differs(data.face_group, here, there);
    };
}

class Sqrt3Tessellator final : public LimitTessellator<Sqrt3Family> {
  public:
    Sqrt3Tessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : LimitTessellator(mesh, options, context) {
        constexpr int k_steps_a_level = 2;
        hierarchy_.emplace(mesh, sqrt3_seams(mesh, options.uvs));
        estimator_.emplace(points_, 0.0, &forest().lattice());
        min_depth_ = k_steps_a_level * options.min_level;
        max_depth_ = std::min(k_steps_a_level * options.max_level, forest().max_level() - k_sqrt3_error_steps);
    }

  private:
    const Sqrt3Forest& forest() const { return hierarchy_->forest(); }
    int quadtree_level(LeafId leaf) const override { return sqrt3_lattice_level(forest().level(leaf)); }
    void refine() override { refine_by(*estimator_, points_.memory_bytes(), k_sqrt3_bytes); }

    std::vector<Vec2d> corner_uvs() override {
        const std::vector<Sqrt3Triangle> leaves = forest().leaves();
        const auto cell_at = [&](std::size_t corner) { return forest().lattice().cell(leaves[corner / 3]); };
        return chart_uvs(
            [&](const ControlMesh& charts, std::size_t corner) {
                const Sqrt3Cell cell = cell_at(corner);
                return sqrt3_site(charts, cell.root, cell.corner[corner % 3], cell.lattice());
            },
            [&](std::size_t corner) {
                const Sqrt3Cell cell = cell_at(corner);
                const Sqrt3Point& p = cell.corner[corner % 3];
                Vec2d sum(0);
                for (std::uint32_t c = 0; c < 3; ++c)
                    sum += static_cast<double>(p[c]) *
                           mesh_.data().uvs[mesh_.uv_index(HalfedgeId(3 * cell.root.value + c))];
                return sum / static_cast<double>(p[0] + p[1] + p[2]);
            },
            false);
    }

    std::optional<LimitEstimator> estimator_;
};

}  // namespace

Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context) {
    if (options.scheme.info().refinement == Refinement::sqrt3) return Sqrt3Tessellator(mesh, options, context).run();
    if (options.scheme.info().family == MeshFamily::triangles)
        return LatticeTessellator<LoopFamily>(mesh, options, context).run();
    return LatticeTessellator<QuadFamily>(mesh, options, context).run();
}

}  // namespace tetrakis::detail
