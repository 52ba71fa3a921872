#include "rule_refinement.hpp"

namespace tetrakis {

PolygonMesh refine_by_rules(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RuleOptions& options) {
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
