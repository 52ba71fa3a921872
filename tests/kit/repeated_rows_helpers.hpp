#pragma once

#include "point_match.hpp"
#include "random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/rules/polygon_mesh.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

// What is refined by rows that repeat themselves, and how it is compared with what the rules make.
namespace tetrakis::test {

struct Case {
    std::string_view scheme;
    int levels;
    RuleOptions rules{};
};

inline std::vector<Case> cases() {
    RuleOptions warren, cosine, measured, two, four;
    warren.loop_weights = LoopWeights::warren;
    cosine.edge_beside_crease = EdgeBesideCrease::cosine;
    measured.measure_corner_angles = true;
    two.averaging_steps = 2;
    four.averaging_steps = 4;
    return {{"loop", 4, warren},
            {"loop", 4, cosine},
            {"loop", 4, measured},
            {"tuned-loop", 5},
            {"butterfly", 4},
            {"modified-butterfly", 5},
            {"sqrt3", 4},
            {"catmull-clark", 5, cosine},
            {"catmull-clark", 5, measured},
            {"kobbelt", 5},
            {"4-8", 5},
            {"bilinear", 5},
            {"midpoint", 4},
            {"averaging", 5, two},
            {"averaging", 5, four},
            {"doo-sabin", 5},
            {"doo-sabin-cc", 4},
            {"midedge", 5},
            {"midedge-simplest", 4},
            {"biquartic", 5}};
}

/// @param sharp_for_ever  or without anything sharp but boundaries
inline ControlMesh make_mesh(std::uint64_t seed, bool triangles, bool sharp_for_ever, bool with_uvs = false) {
    RandomMeshOptions options = random_options(seed);
    options.columns = 3 + static_cast<int>(seed % 2);
    options.rows = 3;
    // Two of three are without creases, one of them closed: what dual schemes ask for.
    if (seed % 3 != 2) options.edge_vertices = options.hole = options.crease = options.corner = 0;
    if (seed % 3 == 0) {
        options.topology = seed % 2 == 0 ? Topology::sphere : Topology::torus;
        options.removed_faces = 0;
    }
    ControlMeshData data = random_mesh_data(seed, options);
    if (!sharp_for_ever) {
        data.creases.clear();
        data.corners.clear();
    }
    for (auto& tag : data.creases) tag.sharpness = k_sharpness_infinity;
    for (auto& tag : data.corners) tag.sharpness = k_sharpness_infinity;
    if (with_uvs) add_charts(data);
    ControlMesh mesh = ControlMesh::build(std::move(data));
    return triangles ? triangulate(mesh) : mesh;
}

/// Largest distance of a point of one set from the other.
inline double farthest_apart(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    REQUIRE(a.size() == b.size());
    if (a.empty()) return 0;
    const PointMatch in_a(a), in_b(b);
    double worst = 0;
    for (const Vec3d& p : a) worst = std::max(worst, glm::length(p - b[in_b.nearest(p)]));
    for (const Vec3d& p : b) worst = std::max(worst, glm::length(p - a[in_a.nearest(p)]));
    return worst;
}

/// One point per face, other ones for faces whose corners are turned or exchanged.
inline std::vector<Vec3d> marks(const PolygonMesh& mesh, bool uvs) {
    std::vector<Vec3d> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        const std::uint32_t begin = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
        Vec3d sum(0), turn(0);
        for (std::uint32_t c = begin; c < end; ++c) {
            const std::uint32_t next = c + 1 == end ? begin : c + 1;
            const Vec3d p = uvs ? Vec3d(mesh.uvs[mesh.face_uvs[c]], 0) : mesh.positions[mesh.face_vertices[c]];
            const Vec3d q = uvs ? Vec3d(mesh.uvs[mesh.face_uvs[next]], 0) : mesh.positions[mesh.face_vertices[next]];
            sum += p;
            turn += glm::cross(p, q);
        }
        result.push_back(sum + turn);
    }
    return result;
}

inline PolygonMesh mesh_of(const RuleRefiner& refiner, const std::vector<Vec3d>& points) {
    PolygonMesh mesh;
    mesh.positions = points;
    mesh.face_offsets.push_back(0);
    for (int f = 0; f < refiner.last().face_count(); ++f) {
        for (const int v : refiner.last().corners(f)) mesh.face_vertices.push_back(static_cast<std::uint32_t>(v));
        mesh.face_offsets.push_back(static_cast<std::uint32_t>(mesh.face_vertices.size()));
    }
    return mesh;
}

/// The mesh that comes with tables of stencils; nothing where receding leaves none, or parts that only touch.
inline std::optional<PolygonMesh> by_stencils(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                              const RefineOptions& options) {
    try {
        return refine_stencils(mesh, scheme, levels, options).mesh;
    } catch (const Error&) {
        return std::nullopt;
    }
}

}  // namespace tetrakis::test
