#include "../../hier/base/parallel.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/adaptive/triangle_memory.hpp"
#include "../../refine/attributes/uv_mesh.hpp"
#include "../estimate/sqrt3_leaf_error.hpp"
#include "../surface/local_frame.hpp"
#include "../surface/site_limits.hpp"
#include "measure.hpp"
#include "tessellate_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

namespace {

bool is_linear(const ControlMesh& mesh) { return mesh.face_varying_rule() == FaceVaryingRule::linear_all; }

/// Which edges a sqrt(3) forest has to keep for leaves that lie on one side of all seams: those of the UV layer (where
/// UVs are linear, of faces), of materials and of groups.
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

/// Texture coordinates at the corners of leaves, three a leaf: limits of the charts by the scheme, or linear.
/// @param lattice  of a forest over a mesh with UVs that keeps sqrt3_seams()
/// @throws Error   the UV layer makes no mesh
std::vector<Vec2d> sqrt3_uvs(const Sqrt3Lattice& lattice, std::span<const Sqrt3Triangle> leaves,
                             const TessellateOptions& options, const RunContext& context) {
    const ControlMesh charts = uv_mesh(lattice.mesh(), options.rules);
    std::vector<Vec2d> result(3 * leaves.size());
    std::vector<Site> sites(is_linear(lattice.mesh()) ? 0 : result.size());
    for_each_index(static_cast<std::uint32_t>(leaves.size()), [&](std::uint32_t i) {
        const Sqrt3Cell cell = lattice.cell(leaves[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            const Sqrt3Point& p = cell.corner[k];
            if (!sites.empty()) {
                sites[3 * std::size_t{i} + k] = sqrt3_site(charts, cell.root, p, cell.lattice());
                continue;
            }
            Vec3d sum(0);
            for (std::uint32_t c = 0; c < 3; ++c)
                sum += static_cast<double>(p[c]) * charts.position(charts.origin(HalfedgeId(3 * cell.root.value + c)));
            result[3 * std::size_t{i} + k] = Vec2d(sum) / static_cast<double>(p[0] + p[1] + p[2]);
        }
    });
    if (sites.empty()) return result;
    const Hierarchy points = make_hierarchy(
        charts, options.scheme.info(), {.rules = chart_rules(options.rules), .whole_levels = true, .context = context});
    std::vector<Vec3d> positions(sites.size());
    limit_positions_once(points, sites, positions, [&](double done) { context.report("attributes", 0.5 * done); });
    for (std::size_t i = 0; i < positions.size(); ++i) result[i] = Vec2d(positions[i]);
    return result;
}

/// Bytes a triangle that refining and exporting take at their peak (leaf, error, output), for the memory limit.
constexpr std::uint64_t k_sqrt3_bytes = 500;

/// Simple steps that make one level of refine().
constexpr int k_steps_a_level = 2;

class Sqrt3Tessellator final : public TessellationRun {
  public:
    Sqrt3Tessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : TessellationRun(mesh, options, context),
          points_(make_hierarchy(mesh, options.scheme.info(),
                                 {.rules = options.rules, .whole_levels = true, .context = context})),
          forest_(mesh, sqrt3_seams(mesh, options.uvs)),
          max_steps_(std::min(k_steps_a_level * options.max_level, forest_.max_level() - k_sqrt3_error_steps)) {
        for (int steps = 0; steps < k_steps_a_level * options.min_level; ++steps) refine_all(forest_);
    }

  private:
    bool may_split(const Sqrt3Triangle& leaf) const { return leaf.level - (leaf.half ? 1 : 0) < max_steps_; }

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
        errors_.resize(leaves_.size());
        std::vector<Sqrt3Triangle> fresh;
        std::vector<std::size_t> place;
        for (std::size_t i = 0; i < leaves_.size(); ++i)
            if (const auto known = known_.find(leaves_[i]); known != known_.end()) {
                errors_[i] = known->second;
            } else {
                fresh.push_back(leaves_[i]);
                place.push_back(i);
            }
        const std::vector<double> found = sqrt3_leaf_errors(points_, forest_.lattice(), fresh, decide_at, [&](double) {
            context_.report("refine", std::min(done, 1.0));
        });
        for (std::size_t i = 0; i < fresh.size(); ++i) {
            errors_[place[i]] = found[i];
            known_.emplace(fresh[i], found[i]);
        }
        estimate_seconds_ += watch.lap();
    }

    /// The leaves of a forest, with limit points for vertices.
    TriangleMesh triangle_mesh(const Sqrt3Forest& forest, std::vector<Site>& sites, const char* stage) const {
        TriangleMesh mesh;
        constexpr std::uint32_t k_no_number = 0xFFFF'FFFFu;
        std::vector<std::uint32_t> number(forest.point_slots(), k_no_number);
        std::vector<PointId> points;
        forest.for_each_leaf([&](LeafId leaf, FaceId) {
            auto& triangle = mesh.triangles.emplace_back();
            const std::array<PointId, 3> corners = forest.points(leaf);
            for (std::size_t k = 0; k < 3; ++k) {
                std::uint32_t& v = number[corners[k].value];
                if (v == k_no_number) {
                    v = static_cast<std::uint32_t>(points.size());
                    points.push_back(corners[k]);
                }
                triangle[k] = v;
            }
        });
        sites.resize(points.size());
        for_each_index(static_cast<std::uint32_t>(points.size()),
                       [&](std::uint32_t v) { sites[v] = forest.site(points[v]); });
        mesh.positions.resize(points.size());
        limit_positions(points_, sites, mesh.positions, [&](double) { context_.report(stage, 0.1); });
        return mesh;
    }

    void export_mesh() override {
        context_.report("export", 0);
        std::vector<Site> sites;
        result_.mesh = triangle_mesh(forest_, sites, "export");
        if (options_.normals) {
            result_.mesh.normals.resize(sites.size());
            points_.normals(sites, result_.mesh.normals);
        }
        result_.triangle_error.resize(leaves_.size());
        for (std::size_t t = 0; t < leaves_.size(); ++t) result_.triangle_error[t] = round_up(errors_[t]);
        context_.report("export", 1);
    }

    /// Against the mesh of all leaves split some steps further.
    void measure() override {
        const std::size_t count = result_.mesh.triangles.size();
        int deepest = 0;
        for (const Sqrt3Triangle& leaf : leaves_) deepest = std::max<int>(deepest, leaf.level);
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
        std::vector<Site> sites;
        reference.mesh = triangle_mesh(finer, sites, "measure");
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
        for (const Sqrt3Triangle& leaf : leaves_) {
            result_.triangle_face.push_back(leaf.control_face().value);
            result_.deepest_level = std::max(result_.deepest_level, sqrt3_lattice_level(leaf.level));
        }
        add_face_attributes(mesh_, result_.triangle_face, result_.mesh);
        split_normals_of(result_, mesh_, options_);
        if (!options_.uvs || !mesh_.has_uvs()) return;
        try {
            const std::vector<Vec2d> uv = sqrt3_uvs(forest_.lattice(), leaves_, options_, context_);
            add_uvs(
                result_.mesh, [&](std::uint32_t t, std::size_t k) { return uv[3 * std::size_t{t} + k]; }, context_);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::invalid_input) throw;
            result_.warnings.push_back(std::string("the UV layer cannot be subdivided and is left out (") +
                                       error.what() + ")");
        }
        context_.report("attributes", 1);
    }

    struct Hash {
        std::size_t operator()(const Sqrt3Triangle& leaf) const noexcept {
            const std::uint64_t h = leaf.face ^ std::uint64_t{leaf.level} << 57 ^ std::uint64_t{leaf.half} << 56;
            return static_cast<std::size_t>(h * 0x9E37'79B9'7F4A'7C15ull >> 7);
        }
    };

    Hierarchy points_;  ///< asked for limits alone
    Sqrt3Forest forest_;
    std::unordered_map<Sqrt3Triangle, double, Hash> known_;  ///< errors
    int max_steps_ = 0;
    bool left_over_ = false;
    std::vector<Sqrt3Triangle> leaves_;
    std::vector<double> errors_;  ///< per leaf
};

}  // namespace

Tessellation tessellate_sqrt3(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context) {
    return Sqrt3Tessellator(mesh, options, context).run();
}

}  // namespace tetrakis::detail
