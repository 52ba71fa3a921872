#pragma once

#include "../core/fan_labels.hpp"
#include "../core/rule_step.hpp"

#include <glm/vec2.hpp>

#include <span>
#include <vector>

namespace tetrakis {

/// A mesh of `rings` rings around the middle, whose vertices are numbered as FanLabels does.
struct SectorFan {
    FanLabels labels;
    RuleMesh mesh;
    /// Per sector a half-edge to walk from: primal, it leaves the centre along the ray; dual, it leaves the corner
    /// within the middle face; dual boundary, the boundary edge itself; pentagons, the edge ahead.
    std::vector<int> start;

    SectorFan(FanLattice lattice, const FanShape& shape, int rings);
};

/// Where a label lies in the plane, seen from above and from the middle, if all sectors are alike and straight; the
/// regular lattice as it is.
glm::dvec2 fan_place(const FanLabels& labels, FanLabel label);

/// Finds the vertices that have a fan's labels in other meshes, face by face.
class FanSearch {
  public:
    explicit FanSearch(const FanLabels& labels);
    /// In the order of the labels.
    /// @param start  half-edges as those of SectorFan
    /// @throws std::logic_error  the mesh ends, or its faces are no lattice
    std::vector<int> find(const RuleMesh& mesh, std::span<const int> start) const;

    const FanLabels labels;

  private:
    /// A face, entered by a half-edge `to`: the twin of `from` in a face before it; below 0: a start, the first is -1.
    struct Face {
        int from, to;
    };
    SectorFan fan_;
    std::vector<int> number_;  ///< of the fan's vertices: by the labels
    std::vector<Face> faces_;
};
inline std::vector<int> find_fan(const RuleMesh& mesh, std::span<const int> start, const FanLabels& labels) {
    return FanSearch(labels).find(mesh, start);
}

/// What a dual step makes of the vertex that a crease's half-edge leaves: of the finer half-edge along that crease
/// (RuleStep::child_crease), the one before it. At a boundary corner it leaves the corner's own point, elsewhere the
/// crease's last point before the vertex.
int crease_end_halfedge(const RuleMesh& fine, int along);

/// Where the same neighbourhood starts one level down.
std::vector<int> child_start(const SectorFan& fan, const RuleStep& step);

}  // namespace tetrakis
