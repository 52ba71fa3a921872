#include "../../hier/base/parallel.hpp"
#include "../../refine/adaptive/adaptive_refinement.hpp"
#include "../../refine/attributes/uv_mesh.hpp"
#include "../estimate/limit_estimator.hpp"
#include "../estimate/linear_bound.hpp"
#include "../estimate/mask_norm_bound.hpp"
#include "../surface/local_frame.hpp"
#include "../surface/site_limits.hpp"
#include "exported_mesh.hpp"
#include "measure.hpp"
#include "tessellate_run.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

namespace tetrakis::detail {

namespace {

/// Bytes a triangle that refining and exporting take at their peak (leaf, samples, error, output), for the memory
/// limit.
constexpr std::uint64_t k_lattice_bytes = 800;

/// Triangles estimated between two chances to cancel: enough for many blocks of limit points.
constexpr std::size_t k_estimator_block = 1u << 14;

/// Texture coordinates at addresses: limits of the chart by the same scheme where it can be subdivided, else linear.
template <class Family>
std::vector<Vec2d> uvs_at(std::span<const Site> addresses, const ControlMesh& mesh, const TessellateOptions& options,
                          const RunContext& context, std::vector<std::string>& warnings) {
    ControlMesh chart;
    std::optional<Hierarchy> points;
    try {
        const std::optional<ControlMesh> untagged = without_ignored_tags(mesh, options.scheme.info(), options.rules);
        chart = uv_mesh(untagged ? *untagged : mesh, options.rules);
        const bool linear = mesh.face_varying_rule() == FaceVaryingRule::linear_all;
        const bool triangles = options.scheme.info().family == MeshFamily::triangles;
        const SchemeInfo& scheme = linear ? *find_scheme(triangles ? "midpoint" : "bilinear") : options.scheme.info();
        points.emplace(make_hierarchy(chart, scheme,
                                      {.rules = chart_rules(options.rules), .whole_levels = true, .context = context}));
    } catch (const Error& error) {
        warnings.push_back(std::string("the UV layer cannot be subdivided and is interpolated linearly (") +
                           error.what() + ")");
    }
    std::vector<Vec2d> uvs(addresses.size());
    const auto count = static_cast<std::uint32_t>(addresses.size());
    if (!points) {
        for_each_index(count, [&](std::uint32_t i) {
            const Site& s = addresses[i];
            const double step = std::ldexp(1.0, -s.level);
            uvs[i] = Family::linear(mesh, s.root, s.at.x * step, s.at.y * step,
                                    [&](HalfedgeId h) { return mesh.data().uvs[mesh.uv_index(h)]; });
        });
        return uvs;
    }
    std::vector<Site> sites(addresses.size());
    for_each_index(count, [&](std::uint32_t i) { sites[i] = Family::canonical_site(chart, addresses[i]); });
    std::vector<Vec3d> positions(addresses.size());
    limit_positions_once(*points, sites, positions, [&](double done) { context.report("attributes", 0.5 * done); });
    for_each_index(count, [&](std::uint32_t i) { uvs[i] = Vec2d(positions[i]); });
    return uvs;
}

template <class Family>
class LatticeTessellator final : public TessellationRun {
  public:
    LatticeTessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : TessellationRun(mesh, options, context),
          points_(make_hierarchy(mesh, options.scheme.info(),
                                 {.rules = options.rules, .whole_levels = true, .context = context})),
          forest_(mesh),
          progress_(context, options.max_triangles, [this] { return forest_.triangle_count(); }) {}

  private:
    using ForestView = typename Family::Hierarchy;
    using Refinement = AdaptiveRefinement<ForestView>;

    void prepare() override {
        // A budget compares errors with each other: there all are looked at closely.
        const double decide_at = options_.max_triangles != 0 ? 0.0 : aim_;
        if (options_.scheme.info().is_linear()) bound_ = std::make_unique<LinearBound>(mesh_, options_.scheme.info());
        // It takes several times as long as all else.
        else if (certified() && MaskNormBound<Family>::has(options_.scheme.info(), options_.rules, mesh_))
            bound_ =
                std::make_unique<MaskNormBound<Family>>(points_, options_.scheme.info(), options_.rules, decide_at);
        if (certified() && !bound_)
            throw Error(
                ErrorCode::unsupported,
                "there is no certified bound where edges or vertices are semi-sharp for more than 6 levels, or more "
                "than 64 edges meet or bound a face; use the measured estimator, or change the mesh there",
                mesh_.data().source);
        by_points_ = std::make_unique<LimitEstimator<Family>>(points_, decide_at);
        watched_.emplace(certified() ? static_cast<const ErrorEstimator&>(*bound_) : *by_points_, progress_,
                         k_estimator_block);
    }

    void refine() override {
        AdaptiveOptions adaptive{aim_, options_.max_triangles, options_.min_level, options_.max_level};
        adaptive.max_memory_bytes = context_.max_memory_bytes;
        adaptive.base_bytes = points_.memory_bytes();
        adaptive.bytes_per_triangle = k_lattice_bytes;
        if constexpr (std::is_same_v<Family, QuadFamily>) choose_coarsest(forest_);
        refinement_.emplace(forest_, *watched_, adaptive, progress_.context());
        refinement_->run();
        estimate_seconds_ = watched_->seconds();
    }

    /// eval/README.md, Coarsest mesh: faces that do without their centre.
    void choose_coarsest(BisectionHierarchy& forest) {
        if (options_.min_level > 0) return;
        std::vector<Site> sites;
        std::vector<std::uint32_t> vertex;
        corners_.assign(mesh_.positions().begin(), mesh_.positions().end());
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (const HalfedgeId h = mesh_.vertex_halfedge(VertexId(v)); h.valid()) {
                sites.push_back(canonical(mesh_, {h, {0, 0}, 0}));
                vertex.push_back(v);
            }
        std::vector<Vec3d> positions(sites.size());
        limit_positions(points_, sites, positions, [&](double done) { context_.report("coarsest", 0.2 * done); });
        for (std::size_t i = 0; i < vertex.size(); ++i) corners_[vertex[i]] = positions[i];
        // Those that a bound is wanted for, if there is one at all.
        std::vector<std::uint8_t> wanted(mesh_.face_count(), 1);
        if (bound_)
            for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) wanted[f] = bound_->has_fan_bound(FaceId(f)) ? 1 : 0;
        fans_ = choose_fans(mesh_, corners_, wanted);
        std::vector<double> errors;
        if (options_.estimator == EstimatorKind::certified) {
            std::vector<FaceId> faces;
            for (std::uint32_t f = 0; f < mesh_.face_count(); ++f)
                if (fans_.has(FaceId(f))) faces.push_back(FaceId(f));
            std::vector<double> found(faces.size());
            bound_->bound_fans(fans_, faces, corners_, {}, found);
            errors.assign(mesh_.face_count(), 0.0);
            for (std::size_t i = 0; i < faces.size(); ++i) errors[faces[i].value] = found[i];
        } else {
            errors = fan_limit_errors(points_, fans_, corners_, context_);
        }
        for (std::uint32_t f = 0; f < mesh_.face_count(); ++f)
            if (fans_.has(FaceId(f)) && (options_.max_triangles != 0 || errors[f] <= aim_))
                forest.accept_fan(FaceId(f), errors[f]);
    }

    void export_mesh() override {
        context_.report("export", 0);
        exported_ = ExportedMesh<Family>(forest_, fans_);
        TriangleMesh& mesh = result_.mesh;
        mesh.triangles = std::move(exported_.triangles);
        mesh.positions.resize(exported_.sites.size());
        limit_positions(points_, exported_.sites, mesh.positions,
                        [&](double done) { context_.report("export", 0.9 * done); });
        exported_.describe(forest_, *refinement_, result_);
        context_.report("export", 1.0);
    }

    OutputTriangle origin(std::uint32_t t) const { return exported_.origin(forest_, fans_, t); }

    /// Against a denser mesh of limit points over the same leaves. Those that fans hide are leaves like others.
    void measure() override {
        std::vector<CellTriangle> pieces;
        int deepest = 0;
        for (std::uint32_t t = 0; t < result_.mesh.triangles.size(); ++t) {
            const OutputTriangle from = origin(t);
            if (!from.fan.valid()) {
                pieces.push_back(from.cell);
                deepest = std::max<int>(deepest, from.cell.level);
            } else if (exported_.part[t] == 0) {
                const std::uint32_t h0 = mesh_.face_halfedge(from.fan).value;
                for (std::uint32_t r = 0; r < mesh_.face_size(from.fan); ++r)
                    pieces.push_back(root_triangle(HalfedgeId(h0 + r)));
            }
        }
        measure_triangles(
            limit_reference<Family>(points_, pieces, reference_bits(pieces.size(), deepest), context_, 0.5), result_,
            options_.measure_samples / 2, context_);
    }

    /// Splits what the measurement found to be off. False when nothing can be done.
    bool repair(int) override {
        std::vector<LeafId> leaves;
        std::vector<FaceId> fans;
        for (std::uint32_t t = 0; t < result_.triangle_error.size(); ++t) {
            if (!(static_cast<double>(result_.triangle_error[t]) > off_above_)) continue;
            const LeafId leaf = exported_.leaves[t];
            if (!leaf.valid())
                fans.push_back(exported_.faces[t]);
            else if (forest_.level(leaf) < options_.max_level)
                leaves.push_back(leaf);
        }
        if (leaves.empty() && fans.empty()) return false;
        refinement_->split(leaves, fans);
        return true;
    }
    bool left_over() const override { return refinement_->left_over(); }

    /// Nothing where a face's fan has no bound.
    void certify() override {
        if (!bound_) return;
        constexpr std::uint32_t k_triangles = 4096;  // between two chances to cancel
        const auto count = static_cast<std::uint32_t>(result_.mesh.triangles.size());
        // What the bound has decided is certified already.
        const auto decided = [&](double error) { return certified() && error <= aim_; };
        double largest = 0;
        std::vector<CellTriangle> cells;
        std::vector<FaceId> fans;
        std::vector<double> errors;
        for (std::uint32_t t = 0; t < count; ++t) {
            const OutputTriangle from = origin(t);
            const bool fan = from.fan.valid();
            const double error = fan ? forest_.fan_error(from.fan) : refinement_->error(exported_.leaves[t]);
            if (decided(error))
                largest = std::max(largest, error);
            else if (!fan)
                cells.push_back(from.cell);
            else if (exported_.part[t] == 0)
                fans.push_back(from.fan);
            if (t + 1 < count && cells.size() < k_triangles && fans.size() < k_triangles) continue;
            context_.report("certify", static_cast<double>(t) / count);
            errors.assign(cells.size(), 0.0);
            bound_->bound(cells, largest, errors);
            for (const double e : errors) largest = std::max(largest, e);
            errors.assign(fans.size(), 0.0);
            bound_->bound_fans(fans_, fans, corners_, largest, errors);
            for (const double e : errors) largest = std::max(largest, e);
            cells.clear();
            fans.clear();
        }
        if (std::isfinite(largest)) result_.certified_error = largest;
    }

    /// Those of the limit surface, or of the triangles where the rules would have to make whole levels that are too
    /// large.
    void add_normals() {
        TriangleMesh& mesh = result_.mesh;
        mesh.normals.resize(mesh.positions.size());
        const auto limit_normals = [&](std::span<const Site> sites, std::span<Vec3d> normals) {
            points_.normals(sites, normals);
        };
        try {
            // The deepest first: where it cannot be had, no time goes into others.
            const auto deepest = std::ranges::max_element(exported_.sites, {}, &Site::level);
            if (deepest != exported_.sites.end()) limit_normals({&*deepest, 1}, std::span(mesh.normals).first(1));
            constexpr std::size_t k_block = 1u << 16;
            for (std::size_t begin = 0; begin < mesh.normals.size(); begin += k_block) {
                context_.report("attributes",
                                0.4 * static_cast<double>(begin) / static_cast<double>(mesh.normals.size()));
                const std::size_t size = std::min(k_block, mesh.normals.size() - begin);
                limit_normals(std::span(exported_.sites).subspan(begin, size), {&mesh.normals[begin], size});
            }
            split_normals_of(result_, mesh_, options_,
                             normals_from_inside<Family>(
                                 mesh_, [&](std::uint32_t t) { return origin(t); }, limit_normals));
        } catch (const Error& error) {
            if (error.code() != ErrorCode::unsupported && error.code() != ErrorCode::memory_limit) throw;
            mesh.triangle_normals.clear();
            geometric_normals(mesh);
            split_normals_of(result_, mesh_, options_);
            result_.warnings.push_back(
                "the normals are those of the triangles: for the limit surface's the rules would "
                "have to make levels that are too large");
        }
    }

    void add_attributes() override {
        warn_of_fine_control_mesh(mesh_, options_, result_);
        TriangleMesh& mesh = result_.mesh;
        context_.report("attributes", 0);
        if (options_.normals) add_normals();
        if (options_.uvs && mesh_.has_uvs()) {
            std::vector<Site> addresses(3 * mesh.triangles.size());
            for_each_index(static_cast<std::uint32_t>(mesh.triangles.size()), [&](std::uint32_t t) {
                for (std::size_t k = 0; k < 3; ++k)
                    addresses[3 * std::size_t{t} + k] = origin(t).template corner_site<Family>(mesh_, k);
            });
            add_uvs(mesh, uvs_at<Family>(addresses, mesh_, options_, context_, result_.warnings));
        }
        context_.report("attributes", 1);
        add_face_attributes(mesh_, result_.triangle_face, mesh);
    }

    Hierarchy points_;
    ForestView forest_;
    RefineProgress progress_;
    std::unique_ptr<SurfaceBound> bound_;
    std::unique_ptr<LimitEstimator<Family>> by_points_;
    std::optional<WatchedEstimator> watched_;
    std::optional<Refinement> refinement_;
    FanChoice fans_;
    std::vector<Vec3d> corners_;  ///< of the fans, by control vertex
    ExportedMesh<Family> exported_;
};

}  // namespace

Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context) {
    if (options.scheme.info().family == MeshFamily::triangles)
        return LatticeTessellator<LoopFamily>(mesh, options, context).run();
    return LatticeTessellator<QuadFamily>(mesh, options, context).run();
}

}  // namespace tetrakis::detail
