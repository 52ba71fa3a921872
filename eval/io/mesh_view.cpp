#include "mesh_view.hpp"

#include "../../hier/base/error.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_sort.h>

#include <cmath>
#include <cstring>
#include <numeric>

namespace tetrakis::detail {

namespace {

// An array of triples as an array of numbers.
std::span<const std::uint32_t> flat(const std::vector<std::array<std::uint32_t, 3>>& triples) {
    static_assert(sizeof(std::array<std::uint32_t, 3>) == 3 * sizeof(std::uint32_t));
    return triples.empty() ? std::span<const std::uint32_t>{} : std::span(triples.front().data(), 3 * triples.size());
}

[[noreturn]] void reject(const std::string& text) { throw Error(ErrorCode::invalid_input, "mesh to write: " + text); }

template <class V>
void check_finite(std::span<const V> values, const char* what) {
    for (std::size_t i = 0; i < values.size(); ++i)
        for (int axis = 0; axis < V::length(); ++axis)
            if (!std::isfinite(values[i][axis])) reject(fmt::format("{} {} is not finite", what, i));
}

void check_range(std::span<const std::uint32_t> indices, std::size_t count, const char* what) {
    for (std::size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= count)
            reject(fmt::format("{} number {} is {}, but there are {}", what, i, indices[i], count));
}

}  // namespace

MeshView::MeshView(const TriangleMesh& mesh)
    : positions(mesh.positions),
      normals(mesh.normals),
      uvs(mesh.uvs),
      corners(flat(mesh.triangles)),
      corner_uvs(flat(mesh.triangle_uvs)),
      corner_normals(flat(mesh.triangle_normals)),
      face_material(mesh.triangle_material),
      face_group(mesh.triangle_group),
      materials(mesh.materials),
      groups(mesh.groups) {}

MeshView::MeshView(const PolygonMesh& mesh)
    : positions(mesh.positions),
      normals(mesh.normals),
      uvs(mesh.uvs),
      corners(mesh.face_vertices),
      corner_uvs(mesh.face_uvs),
      face_offsets(mesh.face_offsets),
      face_material(mesh.face_material),
      face_group(mesh.face_group),
      materials(mesh.materials),
      groups(mesh.groups) {}

void MeshView::check() const {
    if (!face_offsets.empty() && (face_offsets.front() != 0 || face_offsets.back() != corners.size()))
        reject("the face offsets do not span the face corners");
    for (std::size_t f = 0; f + 1 < face_offsets.size(); ++f)
        if (face_offsets[f + 1] < face_offsets[f] + std::uint64_t{3})
            reject(fmt::format("face {} has fewer than three corners", f));
    if (face_offsets.empty() && corners.size() % 3 != 0) reject("no face offsets, and corners that are not triangles");
    if (!corner_normals.empty() && corner_normals.size() != corners.size())
        reject(fmt::format("{} normal indices for {} face corners", corner_normals.size(), corners.size()));
    if (has_normals() && corner_normals.empty() && normals.size() != positions.size())
        reject(fmt::format("{} normals for {} vertices", normals.size(), positions.size()));
    if (has_uvs() && corner_uvs.size() != corners.size())
        reject(fmt::format("{} texture coordinate indices for {} face corners", corner_uvs.size(), corners.size()));
    const auto per_face = [&](std::span<const std::uint32_t> numbers, const char* what) {
        if (!numbers.empty() && numbers.size() != face_count())
            reject(fmt::format("{} {} numbers for {} faces", numbers.size(), what, face_count()));
    };
    per_face(face_material, "material");
    per_face(face_group, "group");
    check_range(corners, positions.size(), "vertex index");
    check_range(corner_uvs, uvs.size(), "texture coordinate index");
    check_range(corner_normals, normals.size(), "normal index");
    check_range(face_material, materials.size(), "face material");
    check_range(face_group, groups.size(), "face group");
    check_finite(positions, "position");
    check_finite(normals, "normal");
    check_finite(uvs, "texture coordinate");
}

SplitVertices::SplitVertices(const MeshView& mesh, bool uvs) : count(mesh.positions.size()) {
    constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    const bool by_uv = uvs && mesh.has_uvs(), by_normal = !mesh.corner_normals.empty();
    if (!by_uv && !by_normal) return;
    const auto vertex_count = static_cast<std::uint32_t>(mesh.positions.size());
    if (by_normal) vertex_normal.assign(vertex_count, 0);
    if (by_uv) vertex_uv.assign(vertex_count, k_no_uv);
    corner_vertex.resize(mesh.corners.size());
    std::vector<std::uint8_t> met(vertex_count, 0);
    std::vector<std::uint32_t> next_copy(vertex_count, k_none);  // chains from a vertex through its copies
    for (std::size_t c = 0; c < mesh.corners.size(); ++c) {
        // Normals and UVs are compared by value: equal ones may have different indices.
        const auto same = [&](std::uint32_t v) {
            return (!by_normal || vertex_normal[v] == mesh.corner_normals[c] ||
                    mesh.normals[vertex_normal[v]] == mesh.normals[mesh.corner_normals[c]]) &&
                   (!by_uv || vertex_uv[v] == mesh.corner_uvs[c] ||
                    mesh.uvs[vertex_uv[v]] == mesh.uvs[mesh.corner_uvs[c]]);
        };
        std::uint32_t v = mesh.corners[c];
        if (met[v] == 0) {
            met[v] = 1;
            if (by_normal) vertex_normal[v] = mesh.corner_normals[c];
            if (by_uv) vertex_uv[v] = mesh.corner_uvs[c];
        }
        while (!same(v)) {
            if (next_copy[v] == k_none) {
                if (count >= k_none - 1)
                    throw Error(ErrorCode::unsupported,
                                "too many vertices, split at seams and creases, for the format");
                next_copy[v] = static_cast<std::uint32_t>(count++);
                next_copy.push_back(k_none);
                if (by_normal) vertex_normal.push_back(mesh.corner_normals[c]);
                if (by_uv) vertex_uv.push_back(mesh.corner_uvs[c]);
                copy_of.push_back(mesh.corners[c]);
            }
            v = next_copy[v];
        }
        corner_vertex[c] = v;
    }
}

void join_split_vertices(TriangleMesh& mesh) {
    const auto count = static_cast<std::uint32_t>(mesh.positions.size());
    const auto compare = [&](const std::vector<Vec3d>& values, std::uint32_t a, std::uint32_t b) {
        return std::memcmp(&values[a], &values[b], sizeof(Vec3d));
    };
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    oneapi::tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const int by_bits = compare(mesh.positions, a, b);
        return by_bits != 0 ? by_bits < 0 : a < b;
    });
    std::vector<std::uint32_t> target(count);
    bool one_normal = true;
    for (std::uint32_t i = 0; i < count; ++i) {
        const bool fresh = i == 0 || compare(mesh.positions, order[i - 1], order[i]) != 0;
        target[order[i]] = fresh ? order[i] : target[order[i - 1]];
        if (!mesh.normals.empty() && compare(mesh.normals, target[order[i]], order[i]) != 0) one_normal = false;
    }
    if (!one_normal) mesh.triangle_normals = mesh.triangles;
    const bool reduce_normals = one_normal && !mesh.normals.empty();
    std::uint32_t kept = 0;
    for (std::uint32_t v = 0; v < count; ++v) {
        if (target[v] != v) {
            target[v] = target[target[v]];  // the first vertex there has a lower index, so its new one is known
            continue;
        }
        mesh.positions[kept] = mesh.positions[v];
        if (reduce_normals) mesh.normals[kept] = mesh.normals[v];
        target[v] = kept++;
    }
    mesh.positions.resize(kept);
    if (reduce_normals) mesh.normals.resize(kept);
    for (auto& triangle : mesh.triangles)
        for (std::uint32_t& v : triangle) v = target[v];
}

}  // namespace tetrakis::detail
