#pragma once

#include "../../../hier/base/vec.hpp"
#include "../../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

// Adaptive refinement of triangles by hand, here and by OpenMesh's composite subdividers.
namespace tetrakis::bench {

/// Which triangles of a round are to be split. The circle lies in the plane z = 0, where the surface is flat and its
/// triangulation regular, so that a vertex has the same place in all schemes and at all levels.
enum class Selection { all, disc, circle };

inline bool selects(Selection selection, const std::array<Vec3d, 3>& corner) {
    constexpr double k_radius = 0.2941;
    if (selection == Selection::all) return true;
    std::array<double, 3> distance{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (corner[k].z != 0) return false;
        distance[k] = std::hypot(corner[k].x, corner[k].y);
    }
    const auto [nearest, farthest] = std::minmax_element(distance.begin(), distance.end());
    return selection == Selection::disc ? *farthest <= k_radius : *nearest <= k_radius && *farthest >= k_radius;
}

struct AdaptiveTask {
    const ControlMeshData& data;
    bool sqrt3;  ///< else Loop
    int rounds;  ///< of all triangles of the round's level, the selected ones are split
    Selection selection;
};

struct AdaptiveResult {
    std::uint64_t vertices = 0, faces = 0;
    double moment = 0;  ///< mean square of the vertices' distances from the origin
};

/// Found out once which faces are to be split; prepare() and refine() do it again, as often as wanted.
struct AdaptivePeer {
    virtual ~AdaptivePeer() = default;
    virtual void prepare() = 0;  ///< the control mesh with all that a subdivider needs
    virtual void refine() = 0;
    virtual AdaptiveResult result() const = 0;
};
std::unique_ptr<AdaptivePeer> openmesh_adaptive(const AdaptiveTask& task);

}  // namespace tetrakis::bench
