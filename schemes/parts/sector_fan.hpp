#pragma once

#include "../core/fan_labels.hpp"
#include "../core/rule_step.hpp"

#include <glm/vec2.hpp>

#include <span>
#include <vector>

namespace tetrakis {

/// A mesh of `rings` rings around the middle. Its vertices have the numbers of their labels.
struct SectorFan {
    FanLabels labels;
    RuleMesh mesh;
    /// Per sector the half-edge at which a search starts: primal, it leaves the centre along the ray; dual, it leaves
    /// the corner within the middle face; dual boundary, the boundary edge itself; pentagons, the boundary edge ahead.
    std::vector<int> start;

    SectorFan(FanLattice lattice, const FanShape& shape, int rings);
};

/// Coordinates of a label in the plane around the middle, if all sectors are alike and straight. Labels of the regular
/// lattice get their undistorted coordinates.
glm::dvec2 fan_place(const FanLabels& labels, FanLabel label);

/// Finds the vertices of other meshes that correspond to a fan's labels, face by face.
class FanSearch {
  public:
    explicit FanSearch(const FanLabels& labels);
    /// The vertices of `mesh`, in the order of the labels.
    /// @param start  half-edges as in SectorFan::start
    /// @throws std::logic_error  the fan reaches beyond the mesh, or the faces there are not those of the lattice
    std::vector<int> find(const RuleMesh& mesh, std::span<const int> start) const;

    const FanLabels labels;

  private:
    /// A face, entered by half-edge `to`, the twin of `from` in an earlier face; from < 0: start half-edge -1 - from.
    struct Face {
        int from, to;
    };
    SectorFan fan_;
    std::vector<int> number_;  ///< per vertex of the fan: its number in `labels`, or -1
    std::vector<Face> faces_;
};
inline std::vector<int> find_fan(const RuleMesh& mesh, std::span<const int> start, const FanLabels& labels) {
    return FanSearch(labels).find(mesh, start);
}

/// The finer half-edge along a crease that a dual step makes at the origin of a crease half-edge h: the one before
/// `along`, the finer half-edge of h (RuleStep::child_crease). At a corner it leaves the corner's own point,
/// elsewhere the crease's last point before the vertex.
int crease_end_halfedge(const RuleMesh& fine, int along);

/// Start half-edges, as in SectorFan::start, of the same neighbourhood one level down.
std::vector<int> child_start(const SectorFan& fan, const RuleStep& step);

}  // namespace tetrakis
