#pragma once

#include "../core/rule_mesh.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// Some faces of a mesh as a mesh of its own, and where they are from. Vertices, faces and half-edges keep their order:
/// where the part has all that a rule looks at, the rule adds the same numbers in the same order as in the whole.
struct MeshPart {
    RuleMesh mesh;
    std::vector<int> vertex;  ///< of the whole, per vertex of the part; increasing
    std::vector<int> face;    ///< of the whole, per face of the part; increasing

    /// The part's half-edge for one of the whole; none outside.
    int halfedge(const RuleMesh& whole, int h) const;
};

/// Cuts parts out of meshes; keeps its scratch memory.
class MeshPartFinder {
  public:
    /// Looks for the faces within so many rings (faces that share a vertex) of the seed vertices; more where they would
    /// touch in a vertex alone. Cost: that of the part (once per mesh size that of the mesh).
    void look(const RuleMesh& mesh, std::span<const int> seeds, int rings);
    /// What the last look found, the nearest first: faces, and their vertices.
    const std::vector<int>& faces() const { return faces_; }
    const std::vector<int>& vertices() const { return vertices_; }
    bool has_face(int face) const { return face_kept_[face] == stamp_; }
    /// Where in these one of them is.
    int face_place(int face) const { return face_place_[face]; }
    int vertex_place(int vertex) const { return vertex_place_[vertex]; }

    /// A look, and its faces as a part.
    MeshPart find(const RuleMesh& mesh, std::span<const int> seeds, int rings);

  private:
    std::vector<int> faces_, vertices_;
    std::vector<unsigned> vertex_seen_, face_kept_;  // stamps
    std::vector<int> vertex_place_, face_place_;     // or places in the part
    unsigned stamp_ = 0;
};

}  // namespace tetrakis::detail
