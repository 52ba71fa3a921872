#include "tessellate.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"
#include "../triangles/mesh_sliding.hpp"
#include "../triangles/point_triangle.hpp"
#include "cell_tessellator.hpp"
#include "leaf_estimator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tetrakis::detail {

namespace {

/// A repair that leaves more than this share of the error has not helped; after two such repairs, repairing ends.
constexpr double k_progress = 0.98;

/// Peak memory of refining and exporting per triangle, in bytes (leaf, half a vertex, error, output), for the memory
/// limit.
constexpr std::uint64_t k_patch_bytes = 200;

void check(const ControlMesh& mesh, const TessellateOptions& options) {
    const auto refuse = [](const std::string& text) { throw Error(ErrorCode::invalid_input, text); };
    if (mesh.face_count() == 0) refuse("the control mesh has no faces");
    if (!options.tolerance && options.max_triangles == 0)
        refuse("neither a tolerance nor a maximum number of triangles is given; give at least one of them");
    if (options.tolerance && !(*options.tolerance > 0 && std::isfinite(*options.tolerance)))
        refuse("the tolerance must be a positive number");
    if (options.min_level < 0 || options.max_level > k_max_level || options.min_level > options.max_level)
        refuse("levels must be 0 <= minimum <= maximum <= " + std::to_string(k_max_level));
    // A rough count: a level has four times the triangles (sqrt3: nine); level 0 of quads has one or two per half-edge.
    const SchemeInfo& scheme = options.scheme.info();
    const std::uint32_t coarsest = scheme.family == MeshFamily::triangles ? mesh.face_count() : mesh.halfedge_count();
    const double triangles = coarsest * std::pow(scheme.refinement == Refinement::sqrt3 ? 9 : 4, options.min_level);
    if (options.max_triangles == 0 && triangles > std::numeric_limits<std::uint32_t>::max())
        throw Error(ErrorCode::unsupported,
                    fmt::format("a minimum level of {} makes some {:.2g} triangles, more than 32 bits can count",
                                options.min_level, triangles));
    if (!(options.crease_degrees >= 0 && options.crease_degrees <= 180))
        refuse("the crease angle must be 0 to 180 degrees");
    if (options.displacement && !mesh.has_uvs())
        refuse("a displacement needs texture coordinates, and the control mesh has none");
    if (options.displacement && !std::isfinite(options.amplitude))
        refuse("the amplitude of the displacement must be a finite number");
    if (options.estimator == EstimatorKind::certified && (options.target || options.displacement))
        refuse(
            "the certified estimator bounds the limit surface itself; use the measured estimator with a target or a "
            "displacement");
    if (options.target && options.target->triangles.empty()) refuse("the target mesh has no triangles");
    if (scheme.family == MeshFamily::triangles && !mesh.all_triangles())
        refuse(std::string(scheme.name) + " needs a triangle mesh; triangulate() makes one");
}

template <class Family>
class PatchTessellator final : public CellTessellator<Family> {
  public:
    PatchTessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : CellTessellator<Family>(mesh, options, context, 1) {}

  private:
    using Base = CellTessellator<Family>;
    using Base::hierarchy_, Base::refinement_, Base::fans_, Base::corners_, Base::exported_, Base::part_, Base::origin;
    using Base::mesh_, Base::options_, Base::context_, Base::result_, Base::tolerance_, Base::aim_, Base::certified;

    /// Warns if target and mesh are farther apart than the tolerance, for each direction.
    void warn_of_target(bool left_over) {
        const MeasuredError& error = *result_.measured_error;
        const auto much = [&](double distance) {
            return fmt::format("{:.3g}, {:.3g} times the tolerance", distance, distance / tolerance_);
        };
        if (error.backward > tolerance_)
            result_.warnings.push_back(fmt::format("the mesh is up to {} away from the target", much(error.backward)));
        if (!(error.forward > tolerance_)) return;
        std::string text = fmt::format("the target is up to {} away from the mesh", much(error.forward));
        if (error.backward <= tolerance_)
            text += fmt::format(", though every part of the mesh is within {:.3g} of the target", error.backward);
        if (!left_over)
            text +=
                ": what the control mesh does not cover stays out of reach, however fine the mesh; cut it off the "
                "target, or let the control mesh cover it";
        result_.warnings.push_back(text);
    }

    /// Warns if heights at a control vertex differ between faces, as on UV seams. The surface is torn there, and no
    /// refinement brings the triangles that bridge the gap within the tolerance.
    void warn_of_torn_heights() {
        const auto height = [&](HalfedgeId h) {
            if constexpr (std::is_same_v<Family, QuadFamily>) return map_.height(h, 0, 0);
            const std::uint32_t corner = h.value % 3;
            return map_.height(HalfedgeId(h.value - corner), corner == 1, corner == 2);
        };
        double jump = 0;
        VertexId where;
        std::vector<std::array<double, 2>> range(
            mesh_.vertex_count(), {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
        for (std::uint32_t h = 0; h < mesh_.halfedge_count(); ++h) {
            if (mesh_.is_hole(mesh_.face(HalfedgeId(h)))) continue;
            const VertexId v = mesh_.origin(HalfedgeId(h));
            auto& [low, high] = range[v.value];
            const double here = height(HalfedgeId(h));
            low = std::min(low, here), high = std::max(high, here);
            if (high - low > jump) jump = high - low, where = v;
        }
        if (!(jump > tolerance_)) return;
        const Vec3d at = mesh_.position(where);
        result_.warnings.push_back(fmt::format(
            "the height image lifts the faces around a control vertex on a UV seam, the one at ({:.4g}, {:.4g}, "
            "{:.4g}), by heights that differ by {:.3g}, {:.3g} times the tolerance: the surface is torn there, and the "
            "mesh bridges it; let the heights agree across seams",
            at.x, at.y, at.z, jump, jump / tolerance_));
    }

    void prepare() override {
        patches_ = std::make_unique<typename Family::Patches>(mesh_, context_);
        map_.patches = patches_.get();
        if (mesh_.has_uvs() && (options_.uvs || options_.displacement))
            map_.uv = std::make_unique<UvSurface<Family>>(mesh_, result_.warnings);
        map_.heights = options_.displacement;
        if (map_.heights) map_.ranges.emplace(*map_.heights);
        map_.amplitude = options_.amplitude;
        if (options_.target) map_.target = std::make_unique<TriangleBvh>(*options_.target, context_);
        map_.target_mesh = options_.target;
        context_.report("build", 0.5);
        hierarchy_.emplace(mesh_);
        context_.report("build", 0.9);
        estimator_.emplace(map_, options_.estimator, aim_, options_.max_triangles != 0);
    }

    void refine() override { this->refine_by(*estimator_, patches_->memory_bytes(), k_patch_bytes); }

    void place(std::span<const Site> sites, std::span<Vec3d> positions, std::string_view stage, double share) override {
        for_each_batch(patches_.get(), static_cast<std::uint32_t>(sites.size()), 32, context_, stage, 0, share,
                       [&](std::uint32_t i) { positions[i] = map_.vertex(sites[i]); });
    }
    void limit_normals(std::span<const Site> sites, std::span<Vec3d> normals) const override {
        for_each_batch(
            patches_.get(), static_cast<std::uint32_t>(sites.size()), 32, {}, {}, 0, 1,
            [&](std::uint32_t i) { normals[i] = patches_->vertex(sites[i].root, sites[i].at, sites[i].level).normal; });
    }

    void fan_errors(std::span<const FaceId> faces, std::span<double> errors) override {
        if constexpr (std::is_same_v<Family, QuadFamily>) {
            if (!fan_error_) fan_error_.emplace(map_, *estimator_, fans_, corners_);
            const auto count = static_cast<std::uint32_t>(faces.size());
            for_each_batch(patches_.get(), count, 4, {}, {}, 0, 1, [&](std::uint32_t i) {
                const FaceId f = faces[i];
                // Within a budget the worst fans are split first, so their errors must be tight.
                errors[i] = certified() ? fan_error_->certified(f, aim_, options_.max_triangles == 0)
                                        : fan_error_->measured(f, aim_);
            });
        }
    }

    void measure() override {
        // Certified results are not repaired: their measured errors may be too large, and that is no reason to split.
        const bool mend =
            options_.tolerance && options_.max_triangles == 0 && !refinement_->left_over() && !certified();
        result_.measured_error = detail::measure<Family>(
            result_.mesh, [this](std::uint32_t t) { return origin(t); }, map_, options_.measure_samples,
            mend ? tolerance_ : std::numeric_limits<double>::infinity(), measured_errors_, context_);
        std::ranges::transform(measured_errors_, result_.triangle_error.begin(), round_up);
    }

    bool may_repair() const override { return !refinement_->budget_spent(); }

    bool repair(int round) override {
        // If splitting no longer helps, as where the map jumps, it ends.
        stalled_ += result_.measured_error->hausdorff > k_progress * last_error_;
        last_error_ = result_.measured_error->hausdorff;
        if (stalled_ == 2) return false;
        return Base::repair(round);
    }
    double error_of(std::uint32_t t) const override { return measured_errors_[t]; }

    bool left_over() const override { return refinement_->left_over() || estimator_->gave_up(); }

    bool is_bound(std::uint32_t t) const override {
        const LeafId leaf = exported_.leaves[t];
        return leaf.valid() ? refinement_->basis(leaf) == ErrorBasis::bound : certified();
    }
    void certify() override {
        if (!map_.plain()) return;
        const MeshSliding granted(result_.mesh.triangles, result_.mesh.positions);
        result_.certified_error =
            this->largest_error([&](std::span<const std::uint32_t> triangles, double floor, std::span<double> errors) {
                for_each_batch(patches_.get(), static_cast<std::uint32_t>(triangles.size()), 32, {}, {}, 0, 1,
                               [&](std::uint32_t i) { errors[i] = bound(triangles[i], floor, granted); });
            });
    }
    /// The smaller of two bounds: without sliding over edges, and with the sliding that the mesh allows.
    double bound(std::uint32_t t, double floor, const MeshSliding& granted) const {
        const LeafId of = exported_.leaves[t];
        if (!of.valid()) return fan_error_->certified(exported_.faces[t], floor, false);
        const CellTriangle leaf = origin(t).cell;
        EdgeSliding first, second = granted.of(t, estimator_->soft_edges(leaf));
        auto& bounder = estimator_->bounder();
        if (!second.any()) return bounder.certified_error(leaf, floor);
        if (refinement_->basis(of) != ErrorBasis::bound) std::swap(first, second);
        const double error = bounder.certified_error(leaf, floor, first);
        return error <= floor ? error : std::min(error, bounder.certified_error(leaf, floor, second));
    }

    void add_attributes() override {
        if (options_.target && options_.tolerance && result_.measured_error) warn_of_target(refinement_->left_over());
        if (options_.displacement && options_.tolerance) warn_of_torn_heights();
        if (estimator_->gave_up())
            result_.warnings.push_back(
                "somewhere the mapped surface jumps (two sheets of the target are equally near, or heights differ "
                "across a seam or a crease): refinement stopped there, far below the tolerance");
        this->warn_of_fine_control_mesh();
        Base::add_attributes();
    }

    std::vector<Vec2d> corner_uvs() override {
        const auto count = static_cast<std::uint32_t>(result_.mesh.triangles.size());
        std::vector<Vec2d> uvs(3 * std::size_t{count});
        for_each_batch(map_.uv->patches(), count, 128, context_, "attributes", 0, 0.7, [&](std::uint32_t t) {
            for (std::size_t k = 0; k < 3; ++k) uvs[3 * std::size_t{t} + k] = map_.uv->at(this->corner_site(t, k));
        });
        return uvs;
    }

    void add_normals() override {
        if (map_.plain()) return Base::add_normals();
        geometric_normals(result_.mesh);
        this->split_creases();
    }

    std::unique_ptr<typename Family::Patches> patches_;
    SurfaceMap<Family> map_;
    std::optional<LeafEstimator<Family>> estimator_;
    std::optional<FanError> fan_error_;
    std::vector<double> measured_errors_;  ///< by triangle; floats would not hold lengths above 1e38
    double last_error_ = std::numeric_limits<double>::infinity();  ///< measured before the last repair
    int stalled_ = 0;                                              ///< repairs that have not helped
};

}  // namespace

}  // namespace tetrakis::detail

tetrakis::Tessellation tetrakis::tessellate(const ControlMesh& mesh, const TessellateOptions& options,
                                            const RunContext& context) {
    detail::check(mesh, options);
    return with_threads(context, [&] {
        if (!scheme_support(mesh, options.scheme, options.rules).patches)
            return detail::tessellate_by_limits(mesh, options, context);
        if (options.scheme.info().pieces == SurfacePieces::quartic_box)
            return detail::PatchTessellator<LoopFamily>(mesh, options, context).run();
        return detail::PatchTessellator<QuadFamily>(mesh, options, context).run();
    });
}
