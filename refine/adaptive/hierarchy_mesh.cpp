#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../families/hierarchy_family.hpp"
#include "../rules/triangle_cut.hpp"
#include "hierarchy.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

/// Vertices evaluated between reports. Slow rules take a tenth of a millisecond for some of them.
std::uint32_t vertices_at_once(const RunContext& context) { return context.progress ? 1u << 13 : 1u << 16; }

/// Throws if the mesh would exceed the memory limit.
void check_mesh_memory(const ToMeshOptions& options, std::uint64_t faces, std::uint64_t corners,
                       std::uint64_t vertices) {
    // The arrays of HierarchyMesh, and half as much again for temporary data.
    const std::uint64_t face = 3 * sizeof(std::uint32_t) + sizeof(LeafId) + sizeof(LeafHandle),
                        vertex = sizeof(Site) + sizeof(PointId) + sizeof(Vec3d) * (options.normals ? 2 : 1);
    detail::check_memory("a mesh of about " + std::to_string(faces) + " faces needs",
                         (corners * sizeof(std::uint32_t) + faces * face + vertices * vertex) * 3 / 2,
                         options.context.max_memory_bytes, "coarsen first, or raise the limit");
}

}  // namespace

// Positions (and normals) of all vertices. Without limits they are computed level by level, each vertex at its own.
void Hierarchy::evaluate(HierarchyMesh& result, const ToMeshOptions& options) const {
    PolygonMesh& mesh = result.mesh;
    const auto count = static_cast<std::uint32_t>(result.sites.size()), block = vertices_at_once(options.context);
    const LevelSource& source = family_->source();
    const bool limit = options.positions == MeshPositions::limit;
    detail::resize_large(mesh.positions, count);
    if (options.normals) detail::resize_large(mesh.normals, count);
    std::vector<std::uint8_t> level(count, 0);  // limits: all together at level 0
    if (!limit)
        for_each_index(count, [&](std::uint32_t v) {
            const int lowest = source.first_level(result.sites[v]);
            const int asked = options.positions == MeshPositions::level ? options.level : 0;
            level[v] = static_cast<std::uint8_t>(std::max(lowest, asked));
        });
    if (options.positions == MeshPositions::finest)
        for (std::size_t f = 0; f < result.leaves.size(); ++f) {
            const LeafView leaf = family_->view(result.leaves[f].slot);
            if (leaf.corner_count == 1) break;  // a leaf is a vertex at its own level
            for (std::uint32_t i = mesh.face_offsets[f]; i < mesh.face_offsets[f + 1]; ++i)
                level[mesh.face_vertices[i]] = std::max(level[mesh.face_vertices[i]], leaf.level);
        }
    std::array<std::vector<std::uint32_t>, 256> by_level;
    for (std::uint32_t v = 0; v < count; ++v) by_level[level[v]].push_back(v);
    std::vector<Site> sites;
    std::vector<Vec3d> positions, normals;
    std::vector<LimitPoint> points;
    std::uint32_t done = 0;
    for (std::size_t l = 0; l < by_level.size(); ++l)
        for (std::size_t begin = 0; begin < by_level[l].size(); begin += block) {
            options.context.report("vertices", static_cast<double>(done) / count);
            const auto some =
                std::span(by_level[l]).subspan(begin, std::min<std::size_t>(block, by_level[l].size() - begin));
            done += static_cast<std::uint32_t>(some.size());
            sites.clear();
            for (const std::uint32_t v : some) sites.push_back(result.sites[v]);
            positions.resize(some.size());
            normals.resize(some.size());
            if (limit) {
                if (options.normals) source.normals(sites, normals);
                source.limit_positions(sites, positions);
            } else {
                points.assign(options.normals ? some.size() : 0, {});
                if (options.normals) source.frames(sites, static_cast<int>(l), points);
                std::ranges::transform(points, normals.begin(), &LimitPoint::normal);
                source.positions(sites, static_cast<int>(l), positions);
            }
            for (std::size_t i = 0; i < some.size(); ++i) {
                mesh.positions[some[i]] = positions[i];
                if (options.normals) mesh.normals[some[i]] = normals[i];
            }
        }
}

HierarchyMesh Hierarchy::to_mesh(const ToMeshOptions& options) const {
    require_not_lost();
    if (options.positions == MeshPositions::level &&
        (options.level < 0 || options.level > family_->source().max_level()))
        throw Error(ErrorCode::invalid_input, "level " + std::to_string(options.level) + " is not between 0 and " +
                                                  std::to_string(family_->source().max_level()));
    return with_threads(options.context, [&] {
        // A lower bound for all families; the counts are known after faces().
        check_mesh_memory(options, leaf_count(), 3 * std::uint64_t{leaf_count()}, leaf_count() / 2);
        std::vector<std::uint8_t> diagonal_at_first;
        HierarchyMesh result = family_->faces(diagonal_at_first);
        PolygonMesh& out = result.mesh;
        const bool cut_faces = options.triangles && !diagonal_at_first.empty();
        std::uint64_t face_count = result.faces.size(), corner_count = out.face_vertices.size();
        if (cut_faces) {
            face_count = corner_count - 2 * face_count;
            corner_count = 3 * face_count;
        }
        check_mesh_memory(options, face_count, corner_count, result.sites.size());
        evaluate(result, options);
        if (cut_faces) {
            const detail::TriangleCut cut = detail::cut_polygons(out.face_offsets, diagonal_at_first);
            out.face_offsets = cut.offsets();
            detail::pick(cut.corners, out.face_vertices);
            detail::pick(cut.faces, result.faces);
            detail::pick(cut.faces, result.leaves);
        }
        for (LeafHandle& leaf : result.leaves) leaf = handle(leaf.slot);
        const ControlMeshData& data = mesh().data();
        const auto of_control_face = [&](const std::vector<std::uint32_t>& of, std::vector<std::uint32_t>& to) {
            for (std::size_t f = 0; f < result.faces.size() && !of.empty(); ++f)
                to.push_back(of[result.faces[f].value]);
        };
        of_control_face(data.face_material, out.face_material);
        of_control_face(data.face_group, out.face_group);
        if (!data.face_material.empty()) out.materials = data.materials;
        if (!data.face_group.empty()) out.groups = data.groups;
        options.context.report("vertices", 1);
        return result;
    });
}

}  // namespace tetrakis
