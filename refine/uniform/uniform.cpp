#include "uniform.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../attributes/used_values.hpp"
#include "../attributes/uv_mesh.hpp"
#include "../attributes/vertex_attributes.hpp"
#include "../rules/corner_angles.hpp"
#include "grid_refinement.hpp"
#include "refined_points.hpp"
#include "uniform_cost.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace tetrakis {

namespace {

class UniformRefinement {
  public:
    UniformRefinement(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options)
        : mesh_(mesh),
          scheme_(scheme),
          levels_(levels),
          options_(options),
          normals_(options.normals && !options.linear),
          limit_(options.limit && !options.linear),
          whole_faces_(scheme == SchemeKind::loop || detail::all_quads(mesh)) {}

    PolygonMesh run(detail::RefinedPoints* keep) {
        detail::check_attributes(mesh_, options_.attributes);
        check_memory();
        PolygonMesh result;
        // Roots are of one size: control faces of others are kept as they are, and their limits come from the first
        // level, whose first vertices are theirs.
        const bool polygons = levels_ == 0 && scheme_ == SchemeKind::catmull_clark && !whole_faces_;
        make_points(polygons, result, keep);
        if (mesh_.has_uvs()) refine_uvs(polygons, result);
        keep_surface(result, keep);
        return result;
    }

  private:
    std::uint32_t face_size() const { return scheme_ == SchemeKind::catmull_clark ? 4 : 3; }

    void check_memory() const {
        detail::UniformCost cost =
            detail::uniform_cost(mesh_, {scheme_, levels_, sizeof(double), limit_, normals_, mesh_.has_uvs()});
        // What PolygonMesh has besides: where faces begin, what they are made of, attributes.
        const ControlMeshData& data = mesh_.data();
        constexpr std::uint64_t k_number = sizeof(std::uint32_t);
        cost.bytes +=
            cost.faces * k_number * (1 + (data.face_material.empty() ? 0 : 1) + (data.face_group.empty() ? 0 : 1));
        if (!options_.attributes.empty()) cost.bytes += cost.vertices * sizeof(Vec3d);
        for (const VertexAttribute& attribute : options_.attributes)
            cost.bytes += cost.vertices * sizeof(float) * static_cast<std::uint64_t>(attribute.width);
        // Holes are taken out of copies.
        if (!data.holes.empty() || data.boundary_rule == BoundaryRule::none)
            cost.bytes += k_number * (2 * cost.corners + cost.faces);
        detail::check_memory(mesh_, levels_, cost, options_.context);
    }

    /// The options below this call: memory has been looked at as a whole, threads are those of the running arena.
    UniformOptions unlimited() const {
        UniformOptions options = options_;
        options.context.max_memory_bytes = 0;
        options.context.threads = 0;
        return options;
    }

    /// Points, what goes with them, and the faces' corners.
    void make_points(bool polygons, PolygonMesh& result, detail::RefinedPoints* keep) const {
        detail::RefinedPoints points;
        if (polygons) {
            points = points_of_polygons();
            result.face_vertices = mesh_.data().face_vertices;
        } else {
            const auto refiner = std::make_shared<UniformRefiner<double>>(mesh_, scheme_, levels_, unlimited());
            points.count = refiner->vertex_count();
            points.refine = [refiner](auto control, auto positions, auto normals) {
                refiner->refine(control, positions, normals);
            };
            result.face_vertices.resize(static_cast<std::size_t>(refiner->face_count()) * face_size());
            refiner->faces(result.face_vertices);
        }
        points.make(mesh_, normals_, result);
        result.attributes = detail::refine_by_threes(
            options_.attributes, mesh_.vertex_count(), points.count,
            [&](std::span<const Vec3d> in, std::span<Vec3d> out) { points.refine(in, out, {}); });
        if (keep != nullptr) *keep = std::move(points);
    }

    /// The control mesh's own, or their limits.
    detail::RefinedPoints points_of_polygons() const {
        detail::RefinedPoints points{.count = mesh_.vertex_count()};
        std::shared_ptr<UniformRefiner<double>> refiner;
        if (limit_ || normals_) refiner = std::make_shared<UniformRefiner<double>>(mesh_, scheme_, 1, unlimited());
        points.refine = [refiner, limit = limit_](auto control, auto positions, auto normals) {
            if (limit || !normals.empty()) {
                std::vector<Vec3d> finer(refiner->vertex_count()), finer_normals(normals.empty() ? 0 : finer.size());
                refiner->refine(control, finer, finer_normals);
                std::copy_n(finer.begin(), positions.size(), positions.begin());
                std::copy_n(finer_normals.begin(), normals.size(), normals.begin());
            }
            if (!limit) std::copy(control.begin(), control.end(), positions.begin());
        };
        return points;
    }

    void refine_uvs(bool polygons, PolygonMesh& result) const {
        const bool linear = options_.linear || mesh_.face_varying_rule() == FaceVaryingRule::linear_all;
        const ControlMesh chart = uv_mesh(mesh_);
        if (polygons) {
            result.face_uvs = chart.data().face_vertices;
            for (const Vec3d& p : chart.positions()) result.uvs.emplace_back(p);
            return;
        }
        const detail::GridTopology topology(chart, scheme_, levels_,
                                            linear ? detail::PointRule::linear : detail::PointRule::scheme,
                                            options_.factored ? detail::RootPlace::corners : detail::RootPlace::faces);
        detail::GridPoints<double> points(topology);
        const double* uv = points.run(chart.positions(), nullptr, options_.context);
        result.uvs.resize(topology.last().vertex_count());
        for_each_index(static_cast<std::uint32_t>(result.uvs.size()), [&](std::uint32_t i) {
            result.uvs[i] = Vec2d(uv[3 * std::size_t{i}], uv[3 * std::size_t{i} + 1]);
        });
        result.face_uvs.resize(result.face_vertices.size());
        detail::write_faces(topology.last(), result.face_uvs, options_.context);
    }

    /// The control face that each face comes from: faces follow their root, roots their control face.
    std::uint32_t control_face(std::uint32_t face) const {
        if (levels_ == 0) return face;
        if (scheme_ == SchemeKind::loop) return face >> 2 * levels_;
        return mesh_.face(HalfedgeId(face >> 2 * (levels_ - 1))).value;
    }

    void keep_surface(PolygonMesh& result, detail::RefinedPoints* points) const {
        const auto& data = mesh_.data();
        const std::uint32_t size = face_size();
        const auto corners = static_cast<std::uint32_t>(result.face_vertices.size());
        const bool polygons = levels_ == 0;
        const std::uint32_t faces = polygons ? mesh_.face_count() : corners / size;
        bool holes = false, isolated = false;
        for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) holes |= mesh_.is_hole(FaceId(f));
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) isolated |= mesh_.is_isolated(VertexId(v));

        std::vector<std::uint32_t> source;  // of kept faces; empty: all are kept
        if (holes)
            for (std::uint32_t f = 0; f < faces; ++f)
                if (!mesh_.is_hole(FaceId(control_face(f)))) source.push_back(f);
        const std::uint32_t kept = holes ? static_cast<std::uint32_t>(source.size()) : faces;
        const auto begin_of = [&](std::uint32_t f) { return polygons ? data.face_offsets[f] : f * size; };
        const auto original = [&](std::uint32_t f) { return holes ? source[f] : f; };

        result.face_offsets.resize(kept + std::size_t{1});
        result.face_offsets[0] = 0;
        for (std::uint32_t f = 0; f < kept; ++f) {
            const std::uint32_t o = original(f);
            result.face_offsets[f + 1] = result.face_offsets[f] + (polygons ? mesh_.face_size(FaceId(o)) : size);
        }
        const auto attribute = [&](const std::vector<std::uint32_t>& per_face, std::vector<std::uint32_t>& out) {
            if (per_face.empty()) return;
            out.resize(kept);
            for_each_index(kept, [&](std::uint32_t f) { out[f] = per_face[control_face(original(f))]; });
        };
        attribute(data.face_material, result.face_material);
        attribute(data.face_group, result.face_group);
        result.materials = data.materials;
        result.groups = data.groups;
        if (holes) {
            const auto compact = [&](std::vector<std::uint32_t>& per_corner) {
                if (per_corner.empty()) return;
                std::vector<std::uint32_t> out;
                out.reserve(result.face_offsets.back());
                for (const std::uint32_t f : source) {
                    const auto begin = per_corner.begin() + begin_of(f);
                    out.insert(out.end(), begin, begin + (polygons ? mesh_.face_size(FaceId(f)) : size));
                }
                per_corner = std::move(out);
            };
            compact(result.face_vertices);
            compact(result.face_uvs);
            detail::drop_unused(result.face_uvs, result.uvs);
        }
        if (holes || isolated) detail::drop_unused_points(result, points);
    }

    const ControlMesh& mesh_;
    SchemeKind scheme_;
    int levels_;
    const UniformOptions& options_;
    bool normals_, limit_;
    bool whole_faces_;  ///< control faces are all of the size that the scheme makes
};

}  // namespace

PolygonMesh refine_uniform(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options) {
    return detail::refine_uniform_with_points(mesh, scheme, levels, options, nullptr);
}

PolygonMesh detail::refine_uniform_with_points(const ControlMesh& mesh, SchemeKind scheme, int levels,
                                               const UniformOptions& options, RefinedPoints* points) {
    if (!options.linear) refuse_corner_angles(mesh);
    return with_threads(options.context, [&] { return UniformRefinement(mesh, scheme, levels, options).run(points); });
}

}  // namespace tetrakis
