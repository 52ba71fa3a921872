#include "../../hier/base/parallel.hpp"
#include "../../refine/adaptive/adaptive_refinement.hpp"
#include "../../refine/adaptive/dual_charts.hpp"
#include "../../refine/points/row_points.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../bounds/dual_bound.hpp"
#include "../bounds/dual_leaf_error.hpp"
#include "../surface/local_frame.hpp"
#include "measure.hpp"
#include "tessellate_run.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>

namespace tetrakis::detail {

namespace {

/// Peak memory of refining and exporting per triangle, in bytes (half a leaf with its points, faces), for the memory
/// limit.
constexpr std::uint64_t k_dual_bytes = 800;

/// Factor of the aim in each repair after the first.
constexpr double k_lower_aim = 0.8;

/// A split leaf adds three vertices, and each vertex two triangles.
constexpr std::uint64_t k_triangles_per_split = 6;

class DualTessellator final : public TessellationRun {
  public:
    DualTessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                    VertexRoots roots)
        : TessellationRun(mesh, options, context),
          forest_(std::move(roots)),
          points_(row_points(mesh, options.scheme.info(), options.rules, &forest_.roots(), context, true)),
          leaf_errors_([this](std::span<const Site> sites, std::span<Vec3d> points) {
              points_->limit_positions(sites, points);
          }) {
        const bool has_holes = std::ranges::count(forest_.roots().hole, 1) != 0;
        if (DualBound::has(options.scheme.info()) && !has_holes)
            bound_.emplace(*points_, options.scheme.info(), forest_.roots(), mesh);
        if (certified() && !bound_)
            throw Error(ErrorCode::unsupported,
                        "there is no certified bound where the mesh has holes (remove their faces instead); use the "
                        "measured estimator",
                        mesh.data().source);
    }

  private:
    void refine() override {
        ForestChange change;
        for (int level = 0; level < options_.min_level; ++level) {
            const std::vector<LeafId> leaves = forest_.ordered_leaves();
            // Each leaf is a vertex, and a mesh has about two triangles a vertex.
            const std::uint64_t next = 4 * leaves.size(), triangles = 2 * next;
            if (options_.max_triangles != 0 && next > options_.max_triangles)
                refuse_least_level(options_.max_triangles);
            check_triangle_memory(triangles, triangles * k_dual_bytes, context_.max_memory_bytes);
            forest_.refine(leaves, change);
        }
        refine({});
    }

    /// Splits the leaves `marked`, then leaves with errors above the aim, as far as levels and budget allow. A round
    /// splits all of them. Within a budget it splits those above half of the largest error, as many as the budget
    /// allows. Afterwards mesh, positions and errors are those of the final forest.
    void refine(std::vector<LeafId> marked) {
        constexpr double k_share = 0.5;
        constexpr std::uint64_t k_all = std::numeric_limits<std::uint64_t>::max();
        const std::uint64_t budget = options_.max_triangles;
        std::uint64_t most = k_all;  // leaves to split in a round
        ForestChange change;
        if (!marked.empty()) forest_.refine(marked, change);
        estimate(0);
        for (int pass = 2;; ++pass) {
            const std::uint64_t count = triangles_.triangle_count();
            check_triangle_memory(count, count * k_dual_bytes, context_.max_memory_bytes);
            std::vector<std::uint32_t> open;
            left_over_ = false;
            double largest = 0;
            for (std::uint32_t v = 0; v < errors_.size(); ++v) {
                if (!(errors_[v] > aim_)) continue;
                left_over_ = true;
                if (forest_.level(triangles_.faces.leaves[v]) >= options_.max_level) continue;
                open.push_back(v);
                largest = std::max(largest, errors_[v]);
            }
            std::optional<VertexForest> before;
            if (budget != 0) {
                std::erase_if(open, [&](std::uint32_t v) { return errors_[v] < k_share * largest; });
                // Vertices are in the order of their leaves' paths, so the sort does not depend on earlier rounds.
                std::ranges::stable_sort(open, std::greater{}, [&](std::uint32_t v) { return errors_[v]; });
                most = std::min(
                    {most, std::uint64_t{open.size()}, count < budget ? (budget - count) / k_triangles_per_split : 0});
                open.resize(most);
                before = forest_;
            }
            if (open.empty()) return;
            marked.clear();
            for (const std::uint32_t v : open) marked.push_back(triangles_.faces.leaves[v]);
            forest_.refine(marked, change);
            double done = 1.0 - 1.0 / pass;
            if (budget != 0) {
                const std::uint64_t next = dual_triangles(forest_).triangle_count();
                if (next > budget) {  // closure split too many leaves: mark fewer at a time
                    forest_ = *before;
                    most /= 2;
                    continue;
                }
                if (most == open.size()) most = k_all;
                done = static_cast<double>(next) / static_cast<double>(budget);
            }
            estimate(done);
        }
    }

    void estimate(double done) {
        const auto report = [&](double) { context_.report("refine", std::min(done, 1.0)); };
        triangles_ = dual_triangles(forest_);
        Stopwatch watch;
        positions_ = leaf_errors_.positions(forest_, triangles_, report);
        if (certified()) {
            // Within a budget errors are compared with each other, so all of them must be tight.
            const bool budget = options_.max_triangles != 0;
            DualBound::Errors found =
                bound_->errors(forest_, triangles_, positions_, {budget ? 0.0 : aim_, budget}, report);
            errors_ = std::move(found.of_vertex);
            certified_ = found.largest;
        } else {
            const std::vector<DualFaces::LeafOfVertex> leaves = triangles_.leaves();
            const std::vector<double> found = leaf_errors_.errors(forest_, triangles_, positions_, leaves, report);
            errors_.assign(triangles_.vertex_count(), 0.0);
            for (std::size_t i = 0; i < leaves.size(); ++i)
                errors_[leaves[i].vertex] = std::max(errors_[leaves[i].vertex], found[i]);
        }
        estimate_seconds_ += watch.lap();
    }

    void export_mesh() override {
        result_.mesh.positions = positions_;
        result_.mesh.triangles.resize(triangles_.triangle_count());
        result_.triangle_error.resize(triangles_.triangle_count());
        for (std::uint32_t t = 0; t < triangles_.triangle_count(); ++t) {
            const auto corners = triangles_.triangle(t);
            result_.mesh.triangles[t] = corners;
            result_.triangle_error[t] =
                round_up(std::max({errors_[corners[0]], errors_[corners[1]], errors_[corners[2]]}));
        }
    }

    void certify() override {
        if (!bound_) return;
        context_.report("certify", 0);
        if (!certified() || certified_ > aim_)
            certified_ = bound_
                             ->errors(forest_, triangles_, positions_, {aim_, true},
                                      [&](double done) { context_.report("certify", done); })
                             .largest;
        if (certified() || std::isfinite(certified_)) result_.certified_error = certified_;
    }

    /// Measures against the mesh that the forest gives if all leaves are split a few levels further.
    void measure() override {
        const std::size_t count = result_.mesh.triangles.size();
        int deepest = 0;
        for (const VertexCell& cell : triangles_.faces.cells) deepest = std::max<int>(deepest, cell.level);
        const int bits = reference_bits(count, deepest);
        check_reference_memory(std::uint64_t{count} << (2 * bits), context_);
        VertexForest finer = forest_;
        ForestChange change;
        for (int i = 0; i < bits; ++i) finer.refine(finer.ordered_leaves(), change);
        const DualTriangles triangles = dual_triangles(finer);
        TriangleMesh reference;
        reference.positions =
            leaf_errors_.positions(finer, triangles, [&](double done) { context_.report("measure", 0.5 * done); });
        for (std::uint32_t t = 0; t < triangles.triangle_count(); ++t)
            reference.triangles.push_back(triangles.triangle(t));
        measure_triangles(reference, result_, options_.measure_samples / 2, context_);
    }

    bool repair(int round) override {
        std::vector<LeafId> leaves;
        for (std::uint32_t t = 0; t < result_.triangle_error.size(); ++t) {
            if (!(static_cast<double>(result_.triangle_error[t]) > off_above_)) continue;
            for (const std::uint32_t v : triangles_.triangle(t))
                if (const LeafId leaf = triangles_.faces.leaves[v]; forest_.level(leaf) < options_.max_level)
                    leaves.push_back(leaf);
        }
        if (leaves.empty()) return false;
        // A measurement finds only some of the triangles above the tolerance; a lower aim splits similar ones, too.
        if (round > 0) aim_ *= k_lower_aim;
        refine(std::move(leaves));
        return true;
    }
    bool left_over() const override { return left_over_; }

    void add_attributes() override {
        TriangleMesh& mesh = result_.mesh;
        if (options_.normals) {
            mesh.normals.resize(mesh.positions.size());
            constexpr std::size_t k_block = 1u << 15;  // between two reports
            const std::span<const VertexCell> cells = triangles_.faces.cells;
            for (std::size_t begin = 0; begin < cells.size(); begin += k_block) {
                context_.report("export", static_cast<double>(begin) / static_cast<double>(cells.size()));
                const std::size_t size = std::min(k_block, cells.size() - begin);
                points_->normals(cell_sites(cells.subspan(begin, size)), {&mesh.normals[begin], size});
            }
        }
        for (const VertexCell& cell : triangles_.faces.cells)
            result_.deepest_level = std::max<int>(result_.deepest_level, cell.level);
        if (options_.uvs && mesh_.has_uvs()) add_dual_uvs();
        for (const FaceId f : triangles_.faces.control_faces) result_.triangle_face.push_back(f.value);
        split_creases();
    }

    void add_dual_uvs() {
        context_.report("attributes", 0);
        try {
            const DualCharts charts(mesh_, options_.scheme.info(), options_.rules, forest_.roots(), context_);
            DualFaces faces = forest_.faces(FaceCorners::leaves);
            FaceUvs uvs = charts.uvs(forest_, faces, true);
            cut_into_triangles(faces, &uvs.face_uvs);
            add_uvs(std::move(uvs));
            // Control faces of triangles are taken from the same faces as their UVs.
            triangles_.faces.control_faces = std::move(faces.control_faces);
            if (mesh_.face_varying_rule() == FaceVaryingRule::linear_all)
                result_.warnings.push_back(
                    "the texture coordinates were refined smoothly, not linearly as their tag asks: faces of " +
                    std::string(options_.scheme.name()) + " do not lie in faces of the control mesh");
        } catch (const Error& error) {
            if (error.code() != ErrorCode::unsupported && error.code() != ErrorCode::invalid_input) throw;
            result_.warnings.push_back("the texture coordinates were left out: " + std::string(error.what()));
        }
    }

    VertexForest forest_;
    std::shared_ptr<const LevelSource> points_;
    DualLeafErrors leaf_errors_;
    std::optional<DualBound> bound_;
    double certified_ = 0;  ///< largest certified error of the final forest
    bool left_over_ = false;
    DualTriangles triangles_;
    std::vector<Vec3d> positions_;
    std::vector<double> errors_;  ///< per vertex
};

}  // namespace

Tessellation tessellate_dual(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context) {
    VertexRoots roots;
    try {
        roots = vertex_roots(mesh, options.scheme.info(), options.rules);
    } catch (const Error& none) {
        if (none.code() != ErrorCode::unsupported) throw;
        // If a vertex inside the mesh has two faces only, level 0 has no limits.
        TessellateOptions from_level_1 = options;
        from_level_1.min_level = std::max(options.min_level, 1);
        return tessellate_by_levels(mesh, from_level_1, context, none.what());
    }
    return DualTessellator(mesh, options, context, std::move(roots)).run();
}

}  // namespace tetrakis::detail
