#pragma once

#include "../../refine/rules/polygon_mesh.hpp"
#include "../../refine/rules/rule_refiner.hpp"

namespace tetrakis {

/// The control mesh refined by any scheme of the table with RuleRefiner, as a mesh: points and faces only, holes and
/// isolated vertices among them. For UVs, groups and speed see refine().
/// @throws Error  as RuleRefiner
inline PolygonMesh refine_by_rules(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                   const RuleOptions& options = {}) {
    const RuleRefiner refiner(mesh, scheme, levels, {.rules = options});
    PolygonMesh result;
    result.positions.resize(refiner.vertex_count());
    refiner.refine(mesh.positions(), result.positions);
    const RuleMesh& last = refiner.last();
    result.face_offsets.push_back(0);
    for (int f = 0; f < last.face_count(); ++f) {
        for (const int v : last.corners(f)) result.face_vertices.push_back(static_cast<std::uint32_t>(v));
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
    }
    return result;
}

}  // namespace tetrakis
