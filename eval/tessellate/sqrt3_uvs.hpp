#pragma once

#include "../../hier/forest/sqrt3_forest.hpp"
#include "../surface/triangle_mesh.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// Which edges a sqrt(3) forest has to keep for leaves that lie on one side of all seams: those of the UV layer (where
/// UVs are linear, of faces), of materials and of groups.
std::function<bool(EdgeId)> sqrt3_seams(const ControlMesh& mesh, bool uvs);

/// Texture coordinates at the corners of leaves: limits of the charts by the scheme (or linear), whose lattice has the
/// numbers of the mesh's own where that keeps its seams.
class Sqrt3Uvs {
  public:
    /// @param lattice  of a forest over a mesh with UVs that keeps sqrt3_seams()
    /// @throws Error   the UV layer makes no mesh
    explicit Sqrt3Uvs(const Sqrt3Lattice& lattice);
    Sqrt3Uvs(const Sqrt3Uvs&) = delete;
    Sqrt3Uvs& operator=(const Sqrt3Uvs&) = delete;

    /// Three a leaf. Parallel.
    std::vector<Vec2d> corners(std::span<const Sqrt3Leaf> leaves, const RunContext& context) const;

  private:
    ControlMesh charts_;
    bool linear_;
    Sqrt3Lattice lattice_;  // has found nothing: copied
};

}  // namespace tetrakis::detail
