#include "../../hier/mesh/mesh_split.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../surface/local_frame.hpp"
#include "measure.hpp"
#include "tessellate_run.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tetrakis::detail {

namespace {

/// The control mesh with each face of a material of its own, which then tells where faces of its levels come from.
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
          without_uvs_(with_faces_as_materials(mesh, false)) {
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) has_holes_ = has_holes_ || mesh.is_hole(FaceId(f));
    }

  private:
    struct Level {
        TriangleMesh mesh;
        std::vector<std::uint32_t> face;  ///< per triangle: the control face
        std::vector<std::string> warnings;
    };

    /// Level by level until one is within the tolerance; most of the others are ruled out by the next one's vertices.
    void refine() override {
        Level next = make(marked_, options_.min_level, options_.normals);
        for (int level = options_.min_level;; ++level) {
            take(std::move(next), level);
            const bool is_last = level == options_.max_level;
            if (options_.tolerance) check_coarsest();
            if (!is_last) next = make(marked_, level + 1, options_.normals);
            if (options_.tolerance) {
                Stopwatch watch;
                const bool within = (is_last || is_within_aim_of(next)) && is_within_aim();
                estimate_seconds_ += watch.lap();
                if (within) break;
            }
            left_over_ = is_last ? options_.tolerance.has_value() : is_too_much(next);
            if (!is_last && !left_over_) continue;
            if (options_.tolerance) measure();  // for the errors of its triangles
            break;
        }
        if (!options_.measure) result_.measured_error.reset();
    }
    void export_mesh() override {}  // done with each level
    bool repair(int) override { return false; }
    bool left_over() const override { return left_over_; }
    void add_attributes() override { split_creases(); }

    /// Whether such a distance, or measured error, leaves nothing to refine.
    bool is_near(double distance) const { return distance <= off_above_; }
    bool is_within_aim() {
        measure();
        return is_near(result_.measured_error->hausdorff);
    }
    /// The vertices of a level lie on the limit surface, so that none may be farther away.
    bool is_within_aim_of(const Level& level) const {
        if (result_.mesh.triangles.empty()) return true;
        std::vector<ClosestPoint> nearest(level.mesh.positions.size());
        TriangleBvh(result_.mesh, context_).closest(level.mesh.positions, nearest, context_);
        return std::ranges::all_of(nearest, [&](const ClosestPoint& point) { return is_near(point.distance); });
    }
    bool is_too_much(const Level& level) const {
        return options_.max_triangles != 0 && level.mesh.triangles.size() > options_.max_triangles;
    }

    /// A level on the limit surface, its faces cut into triangles.
    Level make(const ControlMesh& mesh, int level, bool normals) const {
        context_.report("refine", 0);
        PolygonMesh from =
            tetrakis::refine(mesh, options_.scheme.info(), level,
                             {.rules = options_.rules, .limit = true, .normals = normals, .context = context_});
        Level result;
        result.warnings = std::move(from.warnings);
        result.mesh.normals = std::move(from.normals);
        if (from.face_count() == 0) return result;
        ControlMeshData data;
        data.positions = std::move(from.positions);
        data.face_offsets = std::move(from.face_offsets);
        data.face_vertices = std::move(from.face_vertices);
        data.uvs = std::move(from.uvs);
        data.face_uvs = std::move(from.face_uvs);
        data.face_material = std::move(from.face_material);
        data.materials = std::move(from.materials);
        // Where holes were left out, faces may touch in a vertex alone: two while they are cut, one afterwards.
        const auto vertex_count = static_cast<std::uint32_t>(data.positions.size());
        const std::vector<std::uint32_t> origin =
            has_holes_ ? split_to_manifold(data).origin : std::vector<std::uint32_t>();
        const auto copies = has_holes_ ? static_cast<std::uint32_t>(origin.size()) - vertex_count : 0;
        const auto whole = [&](std::uint32_t v) {
            if (v < vertex_count) return v;
            return v < vertex_count + copies ? origin[v] : v - copies;
        };
        const ControlMesh cut = triangulate(ControlMesh::build(std::move(data), context_), context_);
        const ControlMeshData& triangles = cut.data();
        result.mesh.positions = triangles.positions;
        const auto first_copy = result.mesh.positions.begin() + vertex_count;
        result.mesh.positions.erase(first_copy, first_copy + copies);
        result.mesh.uvs = triangles.uvs;
        result.face = triangles.face_material;
        result.mesh.triangles.resize(cut.face_count());
        if (cut.has_uvs()) result.mesh.triangle_uvs.resize(cut.face_count());
        for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                result.mesh.triangles[t][k] = whole(triangles.face_vertices[3 * t + k]);
                if (cut.has_uvs()) result.mesh.triangle_uvs[t][k] = triangles.face_uvs[3 * t + k];
            }
        // A face that has no ear has become a fan around its mean.
        if (normals && result.mesh.normals.size() != result.mesh.positions.size()) geometric_normals(result.mesh);
        return result;
    }

    void take(Level&& level, int number) {
        result_.mesh = std::move(level.mesh);
        result_.triangle_face = std::move(level.face);
        result_.triangle_error.assign(result_.mesh.triangles.size(), 0.0f);
        result_.measured_error.reset();
        result_.deepest_level = number;
        // All levels have the same.
        if (number == options_.min_level)
            for (std::string& warning : level.warnings)
                if (std::ranges::count(result_.warnings, warning) == 0) result_.warnings.push_back(std::move(warning));
    }

    /// Against the mesh of a level some steps further, each of which has about four times as many triangles.
    void measure() override {
        if (result_.measured_error) return;
        const std::size_t count = result_.mesh.triangles.size();
        if (count == 0) {
            result_.measured_error.emplace();
            return;
        }
        const int steps = reference_bits(count, 0);
        check_reference_memory(std::uint64_t{count} << 2 * steps, context_);
        context_.report("measure", 0);
        const Level reference = make(without_uvs_, result_.deepest_level + steps, false);
        measure_triangles(reference.mesh, result_, options_.measure_samples / 2, context_);
    }

    ControlMesh marked_, without_uvs_;
    bool has_holes_ = false, left_over_ = false;
};

}  // namespace

Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options,
                                  const RunContext& context) {
    return LevelTessellator(mesh, options, context).run();
}

Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                                  const std::string& why_not_adaptive) {
    const std::string scheme(options.scheme.name());
    if (options.estimator == EstimatorKind::certified)
        throw Error(ErrorCode::unsupported,
                    "there is no certified bound for " + scheme + " on this mesh: " + why_not_adaptive +
                        "; use the measured estimator",
                    mesh.data().source);
    Tessellation result = tessellate_by_levels(mesh, options, context);
    result.warnings.insert(result.warnings.begin(),
                           scheme + " was refined by whole levels, as it cannot be adaptive here: " + why_not_adaptive);
    return result;
}

}  // namespace tetrakis::detail
