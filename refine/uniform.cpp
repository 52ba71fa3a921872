#include "tetrakis/refine/uniform.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/level_points.hpp"
#include "tetrakis/refine/mesh_level.hpp"
#include "tetrakis/refine/uv_mesh.hpp"

#include <limits>
#include <string>

namespace tetrakis {

namespace {

using detail::LevelCounts;
using detail::MeshLevel;

struct Refined {
    MeshLevel level;
    std::vector<Vec3d> points;
};

class UniformRefinement {
  public:
    UniformRefinement(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options)
        : mesh_(mesh), scheme_(scheme), levels_(levels), options_(options) {}

    PolygonMesh run() {
        check_counts();
        const bool rings = options_.limit || options_.normals;
        Refined refined = refine(mesh_, levels_, rings, detail::PointRule::scheme, "refine");
        PolygonMesh result;
        result.face_vertices = std::move(refined.level.origin);
        result.positions = std::move(refined.points);
        if (rings) {
            // Rings are of quads: the limit of an unrefined mesh comes from its first level, whose first vertices are
            // the old ones.
            const bool one_more = scheme_ == SchemeKind::catmull_clark && levels_ == 0;
            if (one_more) {
                refined = refine(mesh_, 1, true, detail::PointRule::scheme, "limit");
            } else {
                refined.level.origin = std::move(result.face_vertices);
                refined.points = std::move(result.positions);
            }
            project(refined, one_more, result);
            if (!one_more) result.face_vertices = std::move(refined.level.origin);
        }
        if (mesh_.has_uvs()) refine_uvs(result);
        keep_surface(result);
        return result;
    }

  private:
    int face_size() const { return scheme_ == SchemeKind::catmull_clark ? 4 : 3; }

    void check_counts() const {
        if (levels_ < 0) throw Error(ErrorCode::invalid_input, "the number of levels is negative");
        if (scheme_ == SchemeKind::loop && !mesh_.all_triangles())
            throw Error(ErrorCode::invalid_input, "Loop subdivision needs a mesh of triangles; triangulate it first",
                        mesh_.data().source);
        LevelCounts counts{mesh_.vertex_count(), mesh_.edge_count(), mesh_.face_count(), mesh_.halfedge_count()};
        std::uint64_t before = 0, bytes = 0;
        // Half-edges are numbered in 32 bits, and edges with one bit more for the side.
        constexpr std::uint64_t k_most = std::numeric_limits<std::uint32_t>::max();
        const bool rings = options_.limit || options_.normals;
        for (int level = 0;; ++level) {
            const bool last = level == levels_;
            if (counts.halfedges >= k_most || counts.vertices >= k_most || counts.edges >= k_most / 2)
                throw Error(ErrorCode::unsupported,
                            std::to_string(levels_) + " levels give more elements than 32-bit " +
                                "numbers can count; level " + std::to_string(level) + " has " +
                                std::to_string(counts.halfedges) + " face corners",
                            mesh_.data().source);
            const std::uint64_t links = 8 * counts.halfedges + 4 * (counts.edges + counts.vertices) +
                                        (mesh_.edge_count() > 0 ? 4 * counts.edges + 5 * counts.vertices : 0);
            const std::uint64_t here = 24 * counts.vertices + 4 * counts.halfedges + (last && !rings ? 0 : links);
            bytes = std::max(bytes, before + here);
            before = here;
            if (last) break;
            counts = next_counts(counts, scheme_);
        }
        if (rings) bytes += 48 * counts.vertices;
        if (mesh_.has_uvs()) bytes += 40 * counts.vertices + 4 * counts.halfedges;
        bytes += 12 * counts.faces;
        const std::uint64_t limit = options_.context.max_memory_bytes;
        if (limit != 0 && bytes > limit)
            throw Error(ErrorCode::memory_limit,
                        std::to_string(levels_) + " levels need about " + std::to_string(bytes >> 20) +
                            " MiB, and the limit is " + std::to_string(limit >> 20) + " MiB; ask for fewer levels",
                        mesh_.data().source);
    }

    Refined refine(const ControlMesh& mesh, int levels, bool keep_links, detail::PointRule rule,
                   std::string_view stage) const {
        Refined now{detail::control_level(mesh), {mesh.positions().begin(), mesh.positions().end()}};
        for (int l = 0; l < levels; ++l) {
            options_.context.report(stage, static_cast<double>(l) / levels);
            using detail::LevelUse;
            const LevelUse use = l + 1 < levels ? LevelUse::refine : keep_links ? LevelUse::rings : LevelUse::faces;
            Refined finer{detail::refine_level(now.level, scheme_, mesh.crease_method(), use), {}};
            finer.points.resize(finer.level.vertex_count);
            detail::refine_points(now.level, scheme_, mesh.crease_method(), rule, now.points, finer.points);
            now = std::move(finer);
        }
        options_.context.report(stage, 1);
        return now;
    }

    void project(Refined& refined, bool one_more, PolygonMesh& result) const {
        const std::uint32_t count = one_more ? mesh_.vertex_count() : refined.level.vertex_count;
        std::vector<Vec3d> limits(options_.limit ? count : 0);
        if (options_.normals) result.normals.resize(count);
        for_each_block(count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
            VertexRing ring;
            for (std::uint32_t v = begin; v < end; ++v) {
                LimitPoint point{.position = refined.points[v]};
                const bool done = detail::smooth_limit(refined.level, scheme_, refined.points, v, point.position,
                                                       options_.normals ? &point.normal : nullptr);
                if (!done && refined.level.vertex_halfedge[v] != MeshLevel::none) {
                    detail::gather_ring(refined.level, scheme_, mesh_.crease_method(), refined.points, v, ring);
                    point = limit_point(scheme_, mesh_.crease_method(), ring);
                }
                if (options_.limit) limits[v] = point.position;
                if (options_.normals) result.normals[v] = point.normal;
            }
        });
        if (options_.limit)
            result.positions = std::move(limits);
        else if (!one_more)
            result.positions = std::move(refined.points);
    }

    void refine_uvs(PolygonMesh& result) const {
        const bool linear = mesh_.face_varying_rule() == FaceVaryingRule::linear_all;
        const ControlMesh chart = uv_mesh(mesh_);
        Refined refined =
            refine(chart, levels_, false, linear ? detail::PointRule::linear : detail::PointRule::scheme, "refine UVs");
        result.face_uvs = std::move(refined.level.origin);
        result.uvs.resize(refined.points.size());
        for_each_index(static_cast<std::uint32_t>(result.uvs.size()),
                       [&](std::uint32_t i) { result.uvs[i] = Vec2d(refined.points[i]); });
    }

    /// The control face that each face comes from is its number, divided: children follow their parent.
    std::uint32_t control_face(std::uint32_t face) const {
        if (levels_ == 0) return face;
        if (scheme_ == SchemeKind::loop) return face >> (2 * levels_);
        return mesh_.face(HalfedgeId(face >> (2 * (levels_ - 1)))).value;
    }

    void keep_surface(PolygonMesh& result) const {
        const auto& data = mesh_.data();
        const auto size = static_cast<std::uint32_t>(face_size());
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
            drop_unused(result.face_uvs, result.uvs);
        }
        if (holes || isolated) {
            std::vector<std::uint32_t> again =
                result.normals.empty() ? std::vector<std::uint32_t>{} : result.face_vertices;
            if (!result.normals.empty()) drop_unused(again, result.normals);
            drop_unused(result.face_vertices, result.positions);
        }
    }

    /// Removes the values that no corner names; the others keep their order.
    template <class T>
    static void drop_unused(std::vector<std::uint32_t>& corners, std::vector<T>& values) {
        std::vector<std::uint32_t> number(values.size(), 0);
        for (const std::uint32_t v : corners) number[v] = 1;
        std::uint32_t count = 0;
        for (std::size_t v = 0; v < values.size(); ++v)
            if (number[v] != 0) {
                values[count] = values[v];
                number[v] = count++;
            }
        values.resize(count);
        for (std::uint32_t& v : corners) v = number[v];
    }

    const ControlMesh& mesh_;
    SchemeKind scheme_;
    int levels_;
    const UniformOptions& options_;
};

}  // namespace

PolygonMesh refine_uniform(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options) {
    return with_threads(options.context, [&] { return UniformRefinement(mesh, scheme, levels, options).run(); });
}

}  // namespace tetrakis
