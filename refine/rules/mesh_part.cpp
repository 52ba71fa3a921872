#include "mesh_part.hpp"

#include <algorithm>

namespace tetrakis::detail {

int MeshPart::halfedge(const RuleMesh& whole, int h) const {
    const int f = whole.face(h);
    const auto at = std::lower_bound(face.begin(), face.end(), f);
    if (at == face.end() || *at != f) return RuleMesh::none;
    return mesh.face_begin(static_cast<int>(at - face.begin())) + (h - whole.face_begin(f));
}

}  // namespace tetrakis::detail
