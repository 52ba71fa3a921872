#pragma once

#include "../core/rule_mesh.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// Some faces of a larger mesh as a mesh, with their numbers there. Vertices, faces and half-edges keep their order:
/// a rule whose whole support is in the part adds the same numbers in the same order as in the larger mesh.
struct MeshPart {
    RuleMesh mesh;
    std::vector<int> vertex;  ///< per vertex of the part its number in the larger mesh; increasing
    std::vector<int> face;    ///< per face of the part its number in the larger mesh; increasing

    /// The part's half-edge for half-edge `h` of the larger mesh `whole`; RuleMesh::none if it is not in the part.
    int halfedge(const RuleMesh& whole, int h) const;
};

/// Cuts parts out of meshes; its scratch memory is reused from call to call.
class MeshPartFinder {
  public:
    /// Collects the faces within `rings` rings (of faces that share a vertex) around the seed vertices, and more faces
    /// where two of them would touch in a vertex alone. Cost: that of the part; that of the mesh for a larger one.
    void look(const RuleMesh& mesh, std::span<const int> seeds, int rings);
    /// The faces that the last look() found, nearest first, and their vertices.
    const std::vector<int>& faces() const { return faces_; }
    const std::vector<int>& vertices() const { return vertices_; }
    bool has_face(int face) const { return face_kept_[face] == stamp_; }
    /// Index of such a face in faces(), of a vertex in vertices(); after find(): in the part.
    int face_place(int face) const { return face_place_[face]; }
    int vertex_place(int vertex) const { return vertex_place_[vertex]; }

    /// Calls look() and makes a part of the faces found.
    MeshPart find(const RuleMesh& mesh, std::span<const int> seeds, int rings);

  private:
    std::vector<int> faces_, vertices_;
    std::vector<unsigned> vertex_seen_, face_kept_;  // stamps
    std::vector<int> vertex_place_, face_place_;     // see face_place()
    unsigned stamp_ = 0;
};

}  // namespace tetrakis::detail
