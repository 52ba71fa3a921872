#pragma once

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <string>
#include <vector>

// Control meshes, as OBJ, on which any scheme can be tested, and their refined meshes as triangles.
namespace tetrakis::test {

/// A cube with a roof on one side: vertices with three, four and five edges.
inline constexpr const char* k_closed =
    "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv 0.2 0 1.7\n"
    "f 1 3 4 2\nf 1 2 6 5\nf 4 3 7 8\nf 3 1 5 7\nf 2 4 8 6\nf 5 6 9\nf 6 8 9\nf 8 7 9\nf 7 5 9\n";

/// A tube of quads, wider in the middle: a boundary without corners.
inline constexpr const char* k_tube =
    "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 1.3 0 1\nv 0 1.3 1\nv -1.3 0 1\nv 0 -1.3 1\nv 0.8 0 2\nv 0 0.8 2\n"
    "v -0.8 0 2\nv 0 -0.8 2\n"
    "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n";

/// Faces cut into fans.
inline TriangleMesh triangles_of(const PolygonMesh& mesh) {
    TriangleMesh result;
    result.positions = mesh.positions;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        for (std::uint32_t i = mesh.face_offsets[f] + 1; i + 1 < mesh.face_offsets[f + 1]; ++i)
            result.triangles.push_back(
                {mesh.face_vertices[mesh.face_offsets[f]], mesh.face_vertices[i], mesh.face_vertices[i + 1]});
    return result;
}

/// Limit points of levels 1 to `levels`, one after the other, with normals if the options ask for them.
inline PolygonMesh limits_of(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                             RefineOptions options = {}) {
    options.limit = true;
    PolygonMesh all;
    for (int level = 1; level <= levels; ++level) {
        const PolygonMesh uniform = refine(mesh, scheme, level, options);
        all.positions.insert(all.positions.end(), uniform.positions.begin(), uniform.positions.end());
        all.normals.insert(all.normals.end(), uniform.normals.begin(), uniform.normals.end());
    }
    return all;
}

/// A scheme with one choice of its rule options, for tests of all such choices.
struct SchemeVariant {
    std::string name;
    const SchemeInfo* scheme;
    RuleOptions options{};
};

inline std::vector<SchemeVariant> scheme_variants() {
    std::vector<SchemeVariant> result;
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.name == "averaging") {
            for (int m = 0; m <= 5; ++m) {
                result.push_back({"averaging " + std::to_string(m), &scheme, {}});
                result.back().options.averaging_steps = m;
            }
            continue;
        }
        result.push_back({std::string(scheme.name), &scheme, {}});
    }
    const auto with = [&](const char* name, const char* what, auto&& change) {
        result.push_back({std::string(name) + ", " + what, find_scheme(name), {}});
        change(result.back().options);
    };
    with("loop", "Warren's weights", [](RuleOptions& o) { o.loop_weights = LoopWeights::warren; });
    for (const char* name : {"loop", "tuned-loop", "catmull-clark"}) {
        with(name, "cosine", [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::cosine; });
        with(name, "brief", [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::brief; });
    }
    with("loop", "Hoppe's creases", [](RuleOptions& o) { o.hoppe_crease = true; });
    with("tuned-loop", "half tuned", [](RuleOptions& o) { o.tuning = 0.5; });
    with("modified-butterfly", "reflection", [](RuleOptions& o) { o.reflect_at_boundary = true; });
    with("modified-butterfly", "ten points", [](RuleOptions& o) { o.butterfly_w = 0.01; });
    with("catmull-clark", "other weights", [](RuleOptions& o) {
        o.catmull_clark_beta = 0.3;
        o.catmull_clark_gamma = 0.1;
    });
    return result;
}

}  // namespace tetrakis::test
