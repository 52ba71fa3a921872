#include "tetrakis/refine/adaptive_sqrt3.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/huge_memory.hpp"
#include "tetrakis/hier/sqrt3_levels.hpp"
#include "tetrakis/refine/sqrt3_net.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

// Rings of faces around split ones that their vertices depend on: one for the fan of a vertex of the level, and those
// of the finer ones, whose sum is that of 1 / sqrt(3) + 1 / 3 + ..., less than three. More are tried where irregular
// vertices need it.
constexpr int k_rings = 3;

/// Numbers of the mesh's vertices, and its triangles.
struct Numbering {
    detail::PoolVector<std::uint32_t> number;    ///< per vertex of the levels
    detail::PoolVector<std::uint32_t> vertices;  ///< the other way round
};

Numbering add_leaves(const Sqrt3Levels& levels, const ControlMeshData& data, std::size_t leaf_count,
                     const Sqrt3MeshOptions& options, Sqrt3Mesh& out) {
    using detail::reserve_large;
    Numbering result;
    reserve_large(result.number, levels.vertices.size());
    result.number.assign(levels.vertices.size(), detail::Sqrt3Net::no_number);
    if (options.leaves) reserve_large(out.leaves, leaf_count);
    const int half_level = options.halves_are_finer ? 1 : 0;
    std::vector<std::uint32_t>& corners = out.mesh.face_vertices;
    reserve_large(corners, 3 * leaf_count);
    reserve_large(out.mesh.face_offsets, leaf_count + 1);
    // Of a closed surface: half as many vertices as triangles, and two more on a sphere; of others some more.
    const std::size_t vertex_count = leaf_count / 2 + leaf_count / 64 + 2;
    reserve_large(result.vertices, vertex_count);
    if (options.vertices) reserve_large(out.vertices, vertex_count);
    const bool with_levels = options.vertices || !options.limit;
    if (with_levels) reserve_large(out.levels, vertex_count);
    out.mesh.face_offsets.push_back(0);
    levels.for_each_leaf([&](int k, std::uint32_t face, bool half, FaceId control_face) {
        const auto add = [&](std::uint32_t vertex, int level) {
            std::uint32_t& v = result.number[vertex];
            if (v == detail::Sqrt3Net::no_number) {
                v = static_cast<std::uint32_t>(result.vertices.size());
                result.vertices.push_back(vertex);
                if (options.vertices) out.vertices.push_back(levels.vertices[vertex]);
                if (with_levels) out.levels.push_back(level);
            }
            if (with_levels) out.levels[v] = std::max(out.levels[v], level);
            corners.push_back(v);
        };
        const Sqrt3Level& level = levels.levels[static_cast<std::size_t>(k)];
        if (half) {
            add(level.vertex[face], k + half_level);
            add(level.vertex[Sqrt3Level::next(face)], k + half_level);
            add(levels.apex(k, face), k + 1);
        } else {
            for (std::uint32_t h = 3 * face; h < 3 * face + 3; ++h) add(level.vertex[h], k);
        }
        if (options.leaves) out.leaves.push_back(levels.leaf(k, face, half, control_face));
        out.mesh.face_offsets.push_back(static_cast<std::uint32_t>(corners.size()));
        if (!data.face_material.empty()) out.mesh.face_material.push_back(data.face_material[control_face.value]);
        if (!data.face_group.empty()) out.mesh.face_group.push_back(data.face_group[control_face.value]);
    });
    return result;
}

void report(const detail::Sqrt3Net& net, const Sqrt3Levels& levels, const RunContext& context) {
    context.report("vertices", static_cast<double>(net.level()) / static_cast<double>(levels.levels.size()));
}

/// The levels, and what is needed to make their points.
void check_memory(const Sqrt3Levels& levels, const RunContext& context) {
    constexpr std::uint64_t k_per_vertex = 2 * sizeof(Vec3d) + 5 * sizeof(std::uint32_t);
    const std::uint64_t bytes = levels.memory_bytes() + levels.vertices.size() * k_per_vertex;
    if (context.max_memory_bytes == 0 || bytes <= context.max_memory_bytes) return;
    throw Error(ErrorCode::memory_limit,
                "the mesh depends on " + std::to_string(levels.vertices.size()) + " points of its levels, which take " +
                    std::to_string(bytes) + " bytes, more than the limit of " +
                    std::to_string(context.max_memory_bytes) + "; coarsen first, or raise the limit");
}

/// Points of the net, each vertex at its level. Whether there was all that they depend on.
bool add_net(const Sqrt3Levels& levels, const Numbering& numbering, const RunContext& context, Sqrt3Mesh& out) {
    detail::Sqrt3Net net(levels);
    // Vertices by level.
    std::vector<std::vector<std::uint32_t>> at(levels.levels.size());
    for (std::uint32_t v = 0; v < out.levels.size(); ++v) at[static_cast<std::size_t>(out.levels[v])].push_back(v);
    out.mesh.positions.resize(out.levels.size());
    for (;; net.step({})) {
        report(net, levels, context);
        for (const std::uint32_t v : at[static_cast<std::size_t>(net.level())]) {
            if (!net.has(numbering.vertices[v])) return false;
            out.mesh.positions[v] = net.point(numbering.vertices[v]);
        }
        if (net.at_last()) return true;
    }
}

bool add_limits(const Sqrt3Levels& levels, const Numbering& numbering, const Sqrt3MeshOptions& options,
                Sqrt3Mesh& out) {
    const bool normals = options.normals;
    detail::Sqrt3Net net(levels);
    detail::resize_large(out.mesh.positions, numbering.vertices.size());
    if (normals) detail::resize_large(out.mesh.normals, numbering.vertices.size());
    detail::PoolVector<std::uint8_t> found(numbering.vertices.size(), 0);
    for (bool last = false; !last;) {
        report(net, levels, options.context);
        last = net.at_last();
        net.step({numbering.number, out.mesh.positions, out.mesh.normals, found});
    }
    return std::find(found.begin(), found.end(), 0) == found.end();
}

}  // namespace

Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options) {
    return sqrt3_mesh(forest, options, [](const Sqrt3Levels&, std::span<const std::uint32_t>) {});
}

Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options,
                     const std::function<void(const Sqrt3Levels&, std::span<const std::uint32_t>)>& show) {
    const ControlMesh& mesh = forest.mesh();
    const bool limits = options.limit || options.normals;
    for (int rings = k_rings;; ++rings) {
        const Sqrt3Levels levels(forest.lattice(), forest.split(), rings, limits, options.context);
        check_memory(levels, options.context);
        Sqrt3Mesh out;
        const Numbering numbering = add_leaves(levels, mesh.data(), forest.leaf_count(), options, out);
        out.mesh.materials = mesh.data().materials;
        out.mesh.groups = mesh.data().groups;
        const bool all = (!limits || add_limits(levels, numbering, options, out)) &&
                         (options.limit || add_net(levels, numbering, options.context, out));
        if (all) {
            show(levels, numbering.vertices);
            return out;
        }
        if (levels.complete) throw std::logic_error("a vertex of an adaptive sqrt3 mesh that its levels do not have");
    }
}

}  // namespace tetrakis
