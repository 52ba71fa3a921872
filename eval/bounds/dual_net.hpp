#pragma once

#include "../../hier/forest/vertex_forest.hpp"
#include "dual_corners.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// The mesh of a vertex forest's leaves with all that lies between them: its faces, and after them the points where
/// creases end as if they were faces.
struct DualNet {
    DualFaces faces;                   ///< with corners
    std::vector<std::uint32_t> point;  ///< per face the point of DualCorners that it lies around, or none
    std::vector<std::uint8_t> open;    ///< per face whether its last corner is not beside the first
    std::size_t face_count = 0;        ///< the faces that there are

    std::size_t size() const { return point.size(); }
};
DualNet dual_net(const VertexForest& forest, const DualCorners& corners);

}  // namespace tetrakis::detail
