#include "../../hier/mesh/mesh_numbering.hpp"
#include "../../hier/mesh/mesh_split.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../io/mesh_codecs.hpp"
#include "../surface/local_frame.hpp"
#include "measure.hpp"
#include "tessellate_run.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <utility>

namespace tetrakis::detail {

namespace {

/// The control mesh, each face with its own material, so that materials of refined faces name the control face.
ControlMesh with_faces_as_materials(const ControlMesh& mesh, bool uvs) {
    ControlMeshData data = mesh.data();
    data.face_material.resize(mesh.face_count());
    std::iota(data.face_material.begin(), data.face_material.end(), 0u);
    data.materials.assign(mesh.face_count(), "");
    data.face_group.clear();
    data.groups.clear();
    if (!uvs) {
        data.uvs.clear();
        data.uv_lines.clear();
        data.face_uvs.clear();
    }
    return ControlMesh::build(std::move(data));
}

class LevelTessellator final : public TessellationRun {
  public:
    LevelTessellator(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context)
        : TessellationRun(mesh, options, context),
          marked_(with_faces_as_materials(mesh, options.uvs)),
          without_uvs_(with_faces_as_materials(mesh, false)) {}

  private:
    /// Makes one level after the other until one is within the tolerance or the next has too many triangles.
    void refine() override {
        for (int level = options_.min_level;; ++level) {
            TriangleMesh next = make(level);
            left_over_ = level != options_.min_level && options_.max_triangles != 0 &&
                         next.triangles.size() > options_.max_triangles;
            if (left_over_) break;
            result_.mesh = std::move(next);
            result_.triangle_face = std::exchange(result_.mesh.triangle_material, {});
            result_.triangle_error.assign(result_.mesh.triangles.size(), 0.0f);
            result_.measured_error.reset();
            result_.deepest_level = level;
            if (options_.tolerance) {
                check_coarsest();
                Stopwatch watch;
                const bool ends = is_near();
                estimate_seconds_ += watch.lap();
                if (ends) break;
            }
            left_over_ = level == options_.max_level && options_.tolerance;
            if (level == options_.max_level) break;
        }
        if (options_.tolerance) {
            Stopwatch watch;
            measure();
            estimate_seconds_ += watch.lap();
        }
        if (!options_.measure) result_.measured_error.reset();
    }
    void export_mesh() override {}  // refine() has done it
    bool repair(int) override { return false; }
    bool left_over() const override { return left_over_; }
    void add_attributes() override { split_creases(); }

    PolygonMesh points(const ControlMesh& mesh, int level, bool limit, bool normals = false) const {
        return tetrakis::refine(mesh, options_.scheme.info(), level,
                                {.rules = options_.rules, .limit = limit, .normals = normals, .context = context_});
    }

    /// The limit points of a level, its faces cut into triangles; their materials are the control faces.
    TriangleMesh make(int level) {
        context_.report("refine", 0);
        const bool normals = options_.normals;
        PolygonMesh from = points(marked_, level, true, normals);
        if (level == options_.min_level)  // all levels give the same warnings
            for (std::string& warning : from.warnings)
                if (std::ranges::count(result_.warnings, warning) == 0) result_.warnings.push_back(std::move(warning));
        if (from.face_count() == 0) return {};
        ControlMeshData data;
        data.positions = std::move(from.positions);
        data.face_offsets = std::move(from.face_offsets);
        data.face_vertices = std::move(from.face_vertices);
        data.uvs = std::move(from.uvs);
        data.face_uvs = std::move(from.face_uvs);
        data.face_material = std::move(from.face_material);
        data.materials = std::move(from.materials);
        // Where holes were left out, faces may share only a vertex: it is doubled for the cut and merged afterwards.
        std::vector<std::uint32_t> first = split_to_manifold(data).origin;
        const ControlMesh cut = triangulate(ControlMesh::build(std::move(data), context_), context_);
        TriangleMesh result = cut_faces(ControlMeshData(cut.data()));
        while (first.size() < result.positions.size()) first.push_back(count_of(first.size()));
        const Numbering merged(first);
        gather(result.positions, merged.kept);
        for (auto& triangle : result.triangles)
            for (std::uint32_t& v : triangle) v = merged.number[v];
        result.materials.clear();
        result.normals = std::move(from.normals);
        // Faces without an ear become fans around their mean, a new vertex that has no limit normal.
        if (normals && result.normals.size() != result.positions.size()) geometric_normals(result);
        return result;
    }

    void measure() override {
        if (result_.measured_error) return;
        if (result_.mesh.triangles.empty()) {
            result_.measured_error.emplace();
            return;
        }
        measure_triangles(reference(reference_steps()), result_, options_.measure_samples / 2, context_);
    }
    /// Whether the level is within the tolerance. The means of its faces are enough to refuse most levels.
    bool is_near() {
        if (has_centers() && !result_.mesh.triangles.empty()) {
            const std::vector<Vec3d> means = means_of(points(without_uvs_, result_.deepest_level, false));
            std::vector<ClosestPoint> nearest(means.size());
            TriangleBvh(result_.mesh, context_).closest(means, nearest, context_);
            if (std::ranges::max(nearest, {}, &ClosestPoint::distance).distance > off_above_) return false;
        }
        measure();
        return result_.measured_error->hausdorff <= off_above_;
    }
    /// Whether the mean of a face's net points lies on the limit surface, as in honeycomb refinement, which keeps it.
    /// Else faces of the reference have the mean of limit points, and the reference gets one more level instead.
    bool has_centers() const { return options_.scheme.info().family == MeshFamily::hexagons; }
    int reference_steps() const {
        return std::max(1, reference_bits(result_.mesh.triangles.size(), 0) - (has_centers() ? 1 : 0));
    }
    /// The limit points of a level `steps` further on, its faces as fans around their centers.
    TriangleMesh reference(int steps) const {
        check_reference_memory(std::uint64_t{3} * result_.mesh.triangles.size() << (2 * steps - 1), context_);
        context_.report("measure", 0);
        const int level = result_.deepest_level + steps;
        PolygonMesh limits = points(without_uvs_, level, true);
        const std::vector<Vec3d> centers = means_of(has_centers() ? points(without_uvs_, level, false) : limits);
        TriangleMesh mesh;
        mesh.positions = std::move(limits.positions);
        mesh.triangles.reserve(limits.face_vertices.size());
        for (std::uint32_t f = 0; f < limits.face_count(); ++f) {
            const auto center = static_cast<std::uint32_t>(mesh.positions.size());
            const std::span corners = corners_of(limits, f);
            for (std::size_t k = 0; k < corners.size(); ++k)
                mesh.triangles.push_back({corners[k], corners[(k + 1) % corners.size()], center});
            mesh.positions.push_back(centers[f]);
        }
        return mesh;
    }
    static std::span<const std::uint32_t> corners_of(const PolygonMesh& mesh, std::uint32_t f) {
        return std::span(mesh.face_vertices)
            .subspan(mesh.face_offsets[f], mesh.face_offsets[f + 1] - mesh.face_offsets[f]);
    }
    static std::vector<Vec3d> means_of(const PolygonMesh& faces) {
        std::vector<Vec3d> means;
        for (std::uint32_t f = 0; f < faces.face_count(); ++f) {
            const std::span corners = corners_of(faces, f);
            Vec3d sum(0);
            for (const std::uint32_t v : corners) sum += faces.positions[v];
            means.push_back(sum / static_cast<double>(corners.size()));
        }
        return means;
    }

    ControlMesh marked_, without_uvs_;
    bool left_over_ = false;
};

}  // namespace

Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                                  const std::string& why_not_adaptive) {
    const std::string scheme(options.scheme.name());
    if (!why_not_adaptive.empty() && options.estimator == EstimatorKind::certified)
        throw Error(ErrorCode::unsupported,
                    "there is no certified bound for " + scheme + " on this mesh: " + why_not_adaptive +
                        "; use the measured estimator",
                    mesh.data().source);
    Tessellation result = LevelTessellator(mesh, options, context).run();
    if (!why_not_adaptive.empty())
        result.warnings.insert(
            result.warnings.begin(),
            scheme + " was refined by whole levels, as it cannot be adaptive here: " + why_not_adaptive);
    return result;
}

}  // namespace tetrakis::detail
