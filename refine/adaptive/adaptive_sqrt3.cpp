#include "adaptive_sqrt3.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/sqrt3_levels.hpp"
#include "sqrt3_net.hpp"
#include "sqrt3_parts.hpp"

#include <algorithm>
#include <array>
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

// What may be raised beside the mesh at once: much more than evenly refined leaves need, and some more to begin with.
constexpr std::uint64_t k_bytes_per_leaf = 256, k_base_bytes = std::uint64_t{32} << 20;
constexpr std::size_t k_least_part = 64;  // leaves

/// Numbers of the mesh's vertices, and its triangles.
struct Numbering {
    detail::PoolVector<std::uint32_t> number;       ///< per vertex of the levels
    detail::RawPoolVector<std::uint32_t> vertices;  ///< the other way round
};

/// Calls visit(vertex, level) for the corners of a leaf.
template <class Visit>
void for_each_corner(const Sqrt3Levels& levels, const detail::Sqrt3LevelLeaf& leaf, bool halves_are_finer,
                     Visit&& visit) {
    const int k = leaf.level;
    const Sqrt3Level& level = levels.levels[leaf.level];
    if (leaf.half) {
        const int half_level = halves_are_finer ? k + 1 : k;
        visit(level.vertex[leaf.face], half_level);
        visit(level.vertex[Sqrt3Level::next(leaf.face)], half_level);
        visit(levels.apex(k, leaf.face), k + 1);
    } else {
        for (std::uint32_t h = 3 * leaf.face; h < 3 * leaf.face + 3; ++h) visit(level.vertex[h], k);
    }
}

Numbering add_leaves(const Sqrt3Levels& levels, const ControlMeshData& data, std::size_t leaf_count,
                     const Sqrt3MeshOptions& options, Sqrt3Mesh& out) {
    Numbering result;
    detail::reserve_large(result.number, levels.vertices.size());
    result.number.assign(levels.vertices.size(), detail::Sqrt3Net::no_number);
    detail::resize_large(result.vertices, levels.vertices.size() + 1);
    if (options.leaves) detail::reserve_large(out.leaves, leaf_count);
    detail::resize_large(out.mesh.face_vertices, 3 * leaf_count);
    detail::resize_large(out.mesh.face_offsets, leaf_count + 1);
    for (std::size_t f = 0; f <= leaf_count; ++f) out.mesh.face_offsets[f] = static_cast<std::uint32_t>(3 * f);
    const bool with_levels = options.vertices || !options.limit;
    // Of a closed surface: half as many vertices as triangles, and two more on a sphere; of others some more.
    if (with_levels) detail::reserve_large(out.levels, leaf_count / 2 + leaf_count / 64 + 2);
    std::uint32_t* corner = out.mesh.face_vertices.data();
    std::uint32_t count = 0;
    levels.for_each_leaf([&](int k, std::uint32_t face, bool half, FaceId control_face) {
        const detail::Sqrt3LevelLeaf leaf{face, static_cast<std::uint8_t>(k), half};
        for_each_corner(levels, leaf, options.halves_are_finer, [&](std::uint32_t vertex, int level) {
            // Not by a branch, which could not be foretold.
            std::uint32_t& v = result.number[vertex];
            const bool is_new = v == detail::Sqrt3Net::no_number;
            result.vertices[count] = vertex;
            v = is_new ? count : v;
            count += is_new ? 1 : 0;
            *corner++ = v;
            if (!with_levels) return;
            if (is_new) out.levels.push_back(level);
            out.levels[v] = std::max(out.levels[v], level);
        });
        if (options.leaves) out.leaves.push_back(levels.leaf(k, face, half, control_face));
        if (!data.face_material.empty()) out.mesh.face_material.push_back(data.face_material[control_face.value]);
        if (!data.face_group.empty()) out.mesh.face_group.push_back(data.face_group[control_face.value]);
    });
    result.vertices.resize(count);
    if (options.vertices) {
        detail::reserve_large(out.vertices, count);
        for (const std::uint32_t vertex : result.vertices) out.vertices.push_back(levels.vertices[vertex]);
    }
    out.mesh.materials = data.materials;
    out.mesh.groups = data.groups;
    detail::resize_large(out.mesh.positions, result.vertices.size());
    if (options.normals) detail::resize_large(out.mesh.normals, result.vertices.size());
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

/// Points of the net, each vertex at its level, as far as there is what they depend on.
/// @param number  of vertices of the levels: which one of the mesh it is
/// @param found   per vertex of the mesh: set where it has got its point
void add_net(const Sqrt3Levels& levels, std::span<const std::uint32_t> number, const RunContext& context,
             Sqrt3Mesh& out, std::span<std::uint8_t> found) {
    detail::Sqrt3Net net(levels);
    // Vertices by level.
    std::vector<std::vector<std::uint32_t>> at(levels.levels.size());
    for (std::uint32_t i = 0; i < number.size(); ++i)
        if (number[i] != detail::Sqrt3Net::no_number) at[static_cast<std::size_t>(out.levels[number[i]])].push_back(i);
    for (;; net.step({})) {
        report(net, levels, context);
        for (const std::uint32_t i : at[static_cast<std::size_t>(net.level())]) {
            if (!net.has(i)) continue;
            out.mesh.positions[number[i]] = net.point(i);
            found[number[i]] = 1;
        }
        if (net.at_last()) return;
    }
}

/// The same on the limit surface.
void add_limits(const Sqrt3Levels& levels, std::span<const std::uint32_t> number, const RunContext& context,
                Sqrt3Mesh& out, std::span<std::uint8_t> found) {
    detail::Sqrt3Net net(levels);
    for (bool last = false; !last;) {
        report(net, levels, context);
        last = net.at_last();
        net.step({number, out.mesh.positions, out.mesh.normals, found});
    }
}

enum class Pass { limits, net };
std::vector<Pass> passes(const Sqrt3MeshOptions& options) {
    if (options.limit) return {Pass::limits};
    return options.normals ? std::vector{Pass::limits, Pass::net} : std::vector{Pass::net};
}

/// Whether all were found.
bool add_points(Pass pass, const Sqrt3Levels& levels, std::span<const std::uint32_t> number, const RunContext& context,
                Sqrt3Mesh& out, std::span<std::uint8_t> found) {
    (pass == Pass::limits ? add_limits : add_net)(levels, number, context, out, found);
    return std::all_of(number.begin(), number.end(),
                       [&](std::uint32_t v) { return v == detail::Sqrt3Net::no_number || found[v] != 0; });
}

/// Calls make(levels) with more and more rings raised until it returns true.
template <class Make>
void with_rings(const Sqrt3Lattice& lattice, const Sqrt3Split& split, bool limits, const RunContext& context,
                const Make& make) {
    for (int rings = k_rings;; ++rings) {
        const Sqrt3Levels levels(lattice, split, rings, limits, context);
        check_memory(levels, context);
        if (make(levels)) return;
        if (levels.complete) throw std::logic_error("a vertex of an adaptive sqrt3 mesh that its levels do not have");
    }
}

using Show = std::function<void(const Sqrt3Levels&, std::span<const std::uint32_t>)>;

Sqrt3Mesh mesh_at_once(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options, const RunContext& context,
                       const Show& show) {
    Sqrt3Mesh out;
    with_rings(
        forest.lattice(), forest.split(), options.limit || options.normals, context, [&](const Sqrt3Levels& levels) {
            out = {};
            const Numbering numbering = add_leaves(levels, forest.mesh().data(), forest.leaf_count(), options, out);
            for (const Pass pass : passes(options)) {
                detail::PoolVector<std::uint8_t> found(numbering.vertices.size(), 0);
                if (!add_points(pass, levels, numbering.number, context, out, found)) return false;
            }
            show(levels, numbering.vertices);
            return true;
        });
    return out;
}

/// The same, with what lies around raised for some leaves at a time: points depend on nothing else.
/// @param context  what may be raised at once
Sqrt3Mesh mesh_in_parts(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options, RunContext context,
                        const Show& show) {
    const Sqrt3Levels levels(forest.lattice(), forest.split(), 0, false, options.context);
    Sqrt3Mesh out;
    const Numbering numbering = add_leaves(levels, forest.mesh().data(), forest.leaf_count(), options, out);
    detail::Sqrt3Parts parts(levels);
    const std::uint64_t most = options.context.max_memory_bytes, taken = levels.memory_bytes() + parts.memory_bytes();
    const auto refuse = [&](const std::string& what) {
        throw Error(ErrorCode::memory_limit, "the levels of the mesh's " + std::to_string(forest.leaf_count()) +
                                                 " triangles take " + std::to_string(taken) + " bytes" + what +
                                                 ", more than the limit of " + std::to_string(most) +
                                                 "; coarsen first, or raise the limit");
    };
    if (most != 0 && taken >= most) refuse("");
    if (most != 0) context.max_memory_bytes = std::min(context.max_memory_bytes, most - taken);
    context.max_memory_bytes /= 2;  // the rest is for what allocators keep of one part while the next is made
    const std::span<const detail::Sqrt3LevelLeaf> leaves = parts.leaves();
    std::size_t size = (leaves.size() + 1) / 2;
    for (const Pass pass : passes(options)) {
        detail::PoolVector<std::uint8_t> found(numbering.vertices.size(), 0);
        const auto add_part = [&](std::span<const detail::Sqrt3LevelLeaf> part) {
            const Sqrt3Split split = parts.split_for(part);
            with_rings(forest.lattice(), split, pass == Pass::limits, context, [&](const Sqrt3Levels& raised) {
                detail::PoolVector<std::uint32_t> number(raised.vertices.size(), detail::Sqrt3Net::no_number);
                for (const detail::Sqrt3LevelLeaf& leaf : part) {
                    std::array<std::uint32_t, 3> corner;
                    std::size_t k = 0;
                    for_each_corner(levels, leaf, options.halves_are_finer, [&](std::uint32_t vertex, int level) {
                        const std::uint32_t v = numbering.number[vertex];
                        const bool is_asked = found[v] == 0 && (pass == Pass::limits || level == out.levels[v]);
                        corner[k++] = is_asked ? v : detail::Sqrt3Net::no_number;
                    });
                    k = 0;
                    for_each_corner(raised, {parts.find(leaf, raised), leaf.level, leaf.half}, options.halves_are_finer,
                                    [&](std::uint32_t vertex, int) {
                                        if (const std::uint32_t v = corner[k++]; v != detail::Sqrt3Net::no_number)
                                            number[vertex] = v;
                                    });
                }
                return add_points(pass, raised, number, context, out, found);
            });
        };
        for (std::size_t begin = 0; begin < leaves.size();) {
            options.context.report("vertices", static_cast<double>(begin) / static_cast<double>(leaves.size()));
            size = std::min(size, leaves.size() - begin);
            try {
                add_part(leaves.subspan(begin, size));
                begin += size;
            } catch (const Error& e) {
                if (e.code() != ErrorCode::memory_limit) throw;
                if (size <= k_least_part) refuse(", and what lies around a few of them takes the rest");
                size = (size + 1) / 2;
            }
        }
    }
    show(levels, numbering.vertices);
    return out;
}

}  // namespace

void require_sqrt3_limits(const ControlMesh& mesh) {
    for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
        const VertexId v(i);
        const HalfedgeId leaving = mesh.vertex_halfedge(v);
        if (!leaving.valid() || mesh.is_boundary(v) || mesh.face_valence(v) != 2 || mesh.sharpness(v) > 0) continue;
        const float one = mesh.sharpness(mesh.edge(leaving)), other = mesh.sharpness(mesh.edge(mesh.prev(leaving)));
        if (std::min(one, other) > 0 || std::max(one, other) < k_sharpness_infinity) continue;
        throw Error(
            ErrorCode::unsupported,
            "sqrt3 has no limit at vertex " + std::to_string(i) +
                ", where a crease ends between two triangles; tag the vertex as a corner, or leave out the limit",
            mesh.data().source);
    }
}

Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options) {
    return sqrt3_mesh(forest, options, [](const Sqrt3Levels&, std::span<const std::uint32_t>) {});
}

Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options,
                     const std::function<void(const Sqrt3Levels&, std::span<const std::uint32_t>)>& show) {
    if (options.limit || options.normals) require_sqrt3_limits(forest.mesh());
    RunContext context = options.context;
    const std::uint64_t most = k_base_bytes + k_bytes_per_leaf * forest.leaf_count();
    context.max_memory_bytes = context.max_memory_bytes == 0 ? most : std::min(most, context.max_memory_bytes);
    return with_threads(options.context, [&] {
        try {
            return mesh_at_once(forest, options, context, show);
        } catch (const Error& e) {
            if (e.code() != ErrorCode::memory_limit) throw;
        }
        context.progress = nullptr;
        return mesh_in_parts(forest, options, context, show);
    });
}

}  // namespace tetrakis
