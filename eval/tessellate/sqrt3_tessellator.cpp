#include "sqrt3_tessellator.hpp"

#include "../../refine/adaptive/adaptive_sqrt3.hpp"
#include "../../refine/adaptive/triangle_memory.hpp"
#include "../surface/local_frame.hpp"
#include "limit_reference.hpp"
#include "sqrt3_leaf_error.hpp"
#include "sqrt3_uvs.hpp"
#include "tessellate_run.hpp"
#include "tessellation_attributes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace tetrakis::detail {

namespace {

/// Bytes a triangle that refining and exporting take at their peak (leaf, error, output), for the memory limit.
constexpr std::uint64_t k_sqrt3_bytes = 500;

/// Simple steps that make one level of refine().
constexpr int k_steps_a_level = 2;

int level_of(const Sqrt3Leaf& leaf) {
    const int steps = leaf.level + (leaf.half ? 1 : 0);
    return (steps + k_steps_a_level - 1) / k_steps_a_level;
}

class Sqrt3Tessellator final : public TessellationRun {
  public:
    Sqrt3Tessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : TessellationRun(mesh, options, context),
          forest_(mesh, sqrt3_seams(mesh, options.uvs)),
          leaf_errors_(forest_.lattice()),
          max_steps_(
              std::min(k_steps_a_level * options.max_level, forest_.max_level() - Sqrt3LeafErrors::k_steps_beyond)) {
        require_sqrt3_limits(mesh_);
        for (int steps = 0; steps < k_steps_a_level * options.min_level; ++steps) refine_all(forest_);
    }

  private:
    bool may_split(const Sqrt3Leaf& leaf) const { return leaf.level < max_steps_; }

    /// Splits the leaves that are marked, by their places in leaves_.
    void split(const std::vector<std::uint8_t>& marked) {
        std::vector<LeafId> leaves = forest_.ordered_leaves();
        std::size_t next = 0;
        std::erase_if(leaves, [&](LeafId) { return marked[next++] == 0; });
        ForestChange change;
        forest_.refine(leaves, change);
    }
    static void refine_all(Sqrt3Forest& forest) {
        ForestChange change;
        forest.refine(forest.ordered_leaves(), change);
    }

    /// Splits all leaves whose error is above the aim, as far as levels and budget allow; ends with the leaves and
    /// errors of the last state.
    void refine() override {
        std::vector<std::uint8_t> marked;
        for (int pass = 1;; ++pass) {
            estimate(1.0 - 1.0 / pass);
            if (options_.max_triangles != 0) return refine_in_budget();
            marked.assign(leaves_.size(), 0);
            left_over_ = false;
            bool any = false;
            for (std::size_t i = 0; i < leaves_.size(); ++i) {
                if (!(errors_[i] > aim_)) continue;
                if (may_split(leaves_[i]))
                    marked[i] = any = true;
                else
                    left_over_ = true;
            }
            if (!any) return;
            split(marked);
        }
    }

    /// The worst leaves first: in each round those above half of the largest error, as far as the budget goes.
    void refine_in_budget() {
        constexpr double k_share = 0.5;
        std::vector<std::size_t> order;
        for (const std::uint64_t budget = options_.max_triangles;;) {
            order.clear();
            left_over_ = false;
            double largest = 0;
            for (std::size_t i = 0; i < leaves_.size(); ++i) {
                if (!(errors_[i] > aim_)) continue;
                left_over_ = true;
                if (!may_split(leaves_[i])) continue;
                order.push_back(i);
                largest = std::max(largest, errors_[i]);
            }
            std::erase_if(order, [&](std::size_t i) { return errors_[i] < k_share * largest; });
            // Leaves stand in the order of where they come from, whatever the history.
            std::stable_sort(order.begin(), order.end(),
                             [&](std::size_t a, std::size_t b) { return errors_[a] > errors_[b]; });
            bool any = false;
            const std::vector<LeafId> leaves = forest_.ordered_leaves();
            ForestChange change;
            for (const std::size_t i : order) {
                const LeafId leaf = leaves[i];
                // One before it may have split it, or made it whole.
                if (!forest_.is_leaf(leaf) || forest_.is_half(leaf) != leaves_[i].half) continue;
                if (forest_.leaf_count() + 2 * std::uint64_t{forest_.splits_for(leaf)} > budget) break;
                forest_.refine({&leaf, 1}, change);
                any = true;
            }
            if (!any) return;
            estimate(static_cast<double>(forest_.leaf_count()) / static_cast<double>(budget));
        }
    }

    void estimate(double done) {
        check_triangle_memory(forest_.leaf_count(), forest_.leaf_count() * k_sqrt3_bytes, context_.max_memory_bytes);
        leaves_ = forest_.leaves();
        Stopwatch watch;
        // A budget compares errors with each other: there all are looked at closely.
        const double decide_at = options_.max_triangles != 0 ? std::numeric_limits<double>::infinity() : aim_;
        errors_ =
            leaf_errors_.errors(leaves_, decide_at, [&](double) { context_.report("refine", std::min(done, 1.0)); });
        estimate_seconds_ += watch.lap();
    }

    static TriangleMesh triangle_mesh(Sqrt3Mesh&& from) {
        TriangleMesh mesh;
        mesh.positions = std::move(from.mesh.positions);
        mesh.normals = std::move(from.mesh.normals);
        mesh.triangles.resize(from.mesh.face_count());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) mesh.triangles[t][k] = from.mesh.face_vertices[3 * t + k];
        return mesh;
    }

    void export_mesh() override {
        context_.report("export", 0);
        result_.mesh =
            triangle_mesh(sqrt3_mesh(forest_, {.limit = true, .normals = options_.normals, .leaves = false}));
        result_.triangle_error.resize(leaves_.size());
        for (std::size_t t = 0; t < leaves_.size(); ++t) result_.triangle_error[t] = round_up(errors_[t]);
        context_.report("export", 1);
    }

    /// Against the mesh of all leaves split some steps further.
    void measure() override {
        const std::size_t count = result_.mesh.triangles.size();
        int deepest = 0;
        for (const Sqrt3Leaf& leaf : leaves_) deepest = std::max<int>(deepest, leaf.level);
        // As many triangles as by cutting each in four, of which a step makes three.
        const double bits = reference_bits(count, 0);
        const int steps = std::clamp(static_cast<int>(std::lround(bits * std::log(4.0) / std::log(3.0))),
                                     k_steps_a_level, forest_.max_level() - deepest);
        check_reference_memory(static_cast<std::uint64_t>(static_cast<double>(count) * std::pow(3.0, steps)), context_);
        context_.report("measure", 0);
        Sqrt3Forest finer = forest_;
        for (int i = 0; i < steps; ++i) refine_all(finer);
        context_.report("measure", 0.1);
        LimitReference reference;
        reference.mesh = triangle_mesh(sqrt3_mesh(finer, {.leaves = false}));
        context_.report("measure", 0.3);
        measure_triangles(std::move(reference), result_, options_.measure_samples / 2, context_);
    }

    /// Splits the triangles that a measurement found to be off. False when there is nothing to split.
    bool repair(int) override {
        std::vector<std::uint8_t> off(leaves_.size(), 0);
        for (std::size_t t = 0; t < leaves_.size(); ++t)
            off[t] = static_cast<double>(result_.triangle_error[t]) > tolerance_ && may_split(leaves_[t]) ? 1 : 0;
        if (std::find(off.begin(), off.end(), 1) == off.end()) return false;
        split(off);
        refine();
        return true;
    }
    bool left_over() const override { return left_over_; }

    void add_attributes() override {
        for (const Sqrt3Leaf& leaf : leaves_) {
            result_.triangle_face.push_back(leaf.control_face.value);
            result_.deepest_level = std::max(result_.deepest_level, level_of(leaf));
        }
        add_face_attributes(mesh_, result_.triangle_face, result_.mesh);
        split_normals_of(result_, mesh_, options_);
        if (!options_.uvs || !mesh_.has_uvs()) return;
        try {
            const std::vector<Vec2d> uv = Sqrt3Uvs(forest_.lattice()).corners(leaves_, context_);
            add_uvs(
                result_.mesh, [&](std::uint32_t t, std::size_t k) { return uv[3 * std::size_t{t} + k]; }, context_);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::invalid_input) throw;
            result_.warnings.push_back(std::string("the UV layer cannot be subdivided and is left out (") +
                                       error.what() + ")");
        }
        context_.report("attributes", 1);
    }

    Sqrt3Forest forest_;
    Sqrt3LeafErrors leaf_errors_;
    int max_steps_ = 0;
    bool left_over_ = false;
    std::vector<Sqrt3Leaf> leaves_;
    std::vector<double> errors_;  ///< per leaf
};

}  // namespace

Tessellation tessellate_sqrt3(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context) {
    return Sqrt3Tessellator(mesh, options, context).run();
}

}  // namespace tetrakis::detail
