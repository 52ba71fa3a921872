#pragma once

#include <compare>
#include <map>
#include <vector>

namespace tetrakis {

/// The regular mesh of a scheme, around the point whose neighbourhood is mapped to itself by a step.
enum class FanLattice {
    triangles,  ///< around a vertex, triangles
    quads,      ///< around a vertex, quads
    dual,       ///< around a face, quads: dual schemes
    pentagons,  ///< around a boundary vertex of hexagons, the two faces along the boundary
};

/// A neighbourhood with one extraordinary point in the middle. A corner of a dual scheme, which has one face after a
/// step, is a corner between quads.
struct FanShape {
    int faces = 0;          ///< around the vertex (primal), or corners of the face (dual, interior)
    bool boundary = false;  ///< the vertex is on the boundary (primal); half a lattice along a boundary edge (dual)
    bool corner = false;    ///< the vertex is tagged a corner
    bool dart = false;      ///< the edges on the first ray are sharp (primal, interior)
    double angle = 0;       ///< the corner's own angle; 0: none
    bool hexagons = false;  ///< one ring of hexagons, not quads, surrounds the face (dual, interior)

    friend auto operator<=>(const FanShape&, const FanShape&) = default;
};

/// Place of a vertex in a fan. Primal: a steps along ray `sector`, then b along the next ray, a >= 1; the centre is
/// {0, 0, 0}. Pentagons: a steps along the boundary from the vertex (sector 0 in its direction, 1 against it), b = 1
/// across the face; b > 1 between the two. Dual: from corner `sector` of the middle face, a steps out beyond the side
/// before it and b beyond the side after it; at a boundary a steps away from the middle of the edge along the boundary
/// (sector 0 in its direction, 1 against it) and b steps inwards. Hexagons: {s, 1, 1} is beyond the edge that leaves
/// corner s, {s, 0, 1} and {s, 1, 0} are beside that in the hexagons beyond the sides after and before the corner.
struct FanLabel {
    int sector = 0, a = 0, b = 0;
    friend auto operator<=>(const FanLabel&, const FanLabel&) = default;
};

/// The labels of a fan's inner rings, numbered by ring, then by (a, b) within the ring, then by sector.
class FanLabels {
  public:
    FanLabels(FanLattice lattice, const FanShape& shape, int rings);

    const std::vector<FanLabel>& all() const { return labels_; }
    int size() const { return static_cast<int>(labels_.size()); }
    /// Number of a label, which need not be canonical; -1 if it is outside.
    int find(FanLabel label) const;
    FanLabel canonical(FanLabel label) const;
    /// The label on the other side of the boundary fan's axis.
    FanLabel mirrored(FanLabel label) const;

    FanLattice lattice() const { return lattice_; }
    const FanShape& shape() const { return shape_; }
    int rings() const { return rings_; }
    int ring_of(FanLabel label) const;

  private:
    FanLattice lattice_;
    FanShape shape_;
    int rings_;
    std::vector<FanLabel> labels_;
    std::map<FanLabel, int> number_;
};

}  // namespace tetrakis
