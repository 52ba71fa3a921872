#include "../estimate/sqrt3_leaf_error.hpp"
#include "cell_tessellator.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrakis::detail {

namespace {

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

/// Peak memory of refining and exporting per triangle, in bytes (leaf, error, output), for the memory limit.
constexpr std::uint64_t k_sqrt3_bytes = 500;

/// Number of simple steps in one level of refine().
constexpr int k_steps_a_level = 2;

/// Estimates errors by the limit points that refined leaves would get (sqrt3_leaf_errors()).
class Sqrt3Estimator final : public ErrorEstimator {
  public:
    Sqrt3Estimator(const Hierarchy& points, const Sqrt3Lattice& lattice) : points_(points), lattice_(lattice) {}
    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle>, std::span<double>) const override {}
    void estimate_sqrt3(std::span<const Sqrt3Triangle> triangles, std::span<double> errors) const override {
        sqrt3_leaf_errors(points_, lattice_, triangles, errors);
    }

  private:
    const Hierarchy& points_;
    const Sqrt3Lattice& lattice_;
};

struct Sqrt3Family {
    using Hierarchy = Sqrt3Hierarchy;
};

class Sqrt3Tessellator final : public CellTessellator<Sqrt3Family> {
  public:
    Sqrt3Tessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : CellTessellator(mesh, options, context),
          points_(make_hierarchy(mesh, options.scheme.info(),
                                 {.rules = options.rules, .whole_levels = true, .context = context})) {
        hierarchy_.emplace(mesh, sqrt3_seams(mesh, options.uvs));
        min_depth_ = k_steps_a_level * options.min_level;
        max_depth_ = std::min(k_steps_a_level * options.max_level, forest().max_level() - k_sqrt3_error_steps);
    }

  private:
    const Sqrt3Forest& forest() const { return hierarchy_->forest(); }

    void refine() override {
        estimator_.emplace(points_, forest().lattice());
        refine_by(*estimator_, points_.memory_bytes(), k_sqrt3_bytes);
    }

    void place(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals,
               std::string_view stage, double share) override {
        limit_positions(points_, sites, positions, [&](double done) { context_.report(stage, share * done); });
        if (!normals.empty()) points_.normals(sites, normals);
    }

    void measure() override {
        const std::size_t count = result_.mesh.triangles.size();
        // The number of triangles is about that of reference_bits() cuts in four; a simple step cuts each in three.
        const double bits = reference_bits(count, 0);
        const int steps =
            std::max(static_cast<int>(std::lround(bits * std::log(4.0) / std::log(3.0))), k_steps_a_level);
        check_reference_memory(static_cast<std::uint64_t>(static_cast<double>(count) * std::pow(3.0, steps)), context_);
        Sqrt3Hierarchy finer = *hierarchy_;
        std::vector<LeafId> fresh;
        for (int i = 0; i < steps; ++i) finer.refine(finer.forest().ordered_leaves(), fresh);
        measure_against(finer);
    }

    void add_attributes() override {
        result_.deepest_level = 0;
        for (const LeafId leaf : exported_.leaves)
            result_.deepest_level = std::max(result_.deepest_level, sqrt3_lattice_level(forest().level(leaf)));
        CellTessellator::add_attributes();
    }
    void add_normals() override { split_creases(); }
    std::vector<Vec2d> corner_uvs() override {
        ControlMesh charts;
        std::optional<Hierarchy> points;
        try {
            charts = uv_mesh(mesh_, options_.rules);
            if (!is_linear(mesh_)) points.emplace(chart_hierarchy(charts));
        } catch (const Error& error) {
            if (error.code() != ErrorCode::invalid_input) throw;
            result_.warnings.push_back(std::string("the UV layer cannot be subdivided and is left out (") +
                                       error.what() + ")");
            return {};
        }
        const std::vector<Sqrt3Triangle> leaves = forest().leaves();
        const auto cell_at = [&](std::size_t corner) { return forest().lattice().cell(leaves[corner / 3]); };
        return chart_uvs(
            points,
            [&](std::size_t corner) {
                const Sqrt3Cell cell = cell_at(corner);
                return sqrt3_site(charts, cell.root, cell.corner[corner % 3], cell.lattice());
            },
            [&](std::size_t corner) {
                const Sqrt3Cell cell = cell_at(corner);
                const Sqrt3Point& p = cell.corner[corner % 3];
                Vec3d sum(0);
                for (std::uint32_t c = 0; c < 3; ++c)
                    sum +=
                        static_cast<double>(p[c]) * charts.position(charts.origin(HalfedgeId(3 * cell.root.value + c)));
                return Vec2d(sum) / static_cast<double>(p[0] + p[1] + p[2]);
            });
    }

    Hierarchy points_;  ///< used for limit points and normals only
    std::optional<Sqrt3Estimator> estimator_;
};

}  // namespace

Tessellation tessellate_sqrt3(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context) {
    return Sqrt3Tessellator(mesh, options, context).run();
}

}  // namespace tetrakis::detail
