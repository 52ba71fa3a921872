#pragma once

#include "../../../hier/base/vec.hpp"
#include "../../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

// Adaptive refinement of chosen triangles, by this library and by OpenMesh's composite subdividers.
namespace tetrakis::bench {

/// Which triangles a round splits. The circle lies in the plane z = 0, where the surface is flat and its triangulation
/// regular, so that a vertex has the same position in all schemes and at all levels.
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
    bool sqrt3;  ///< false: Loop
    int rounds;  ///< each round splits the selected triangles of its level
    Selection selection;
};

struct AdaptiveResult {
    std::uint64_t vertices = 0, faces = 0;
    double moment = 0;  ///< mean square of the vertices' distances from the origin
};

/// The constructor finds the faces that each round splits. prepare() and refine() then repeat the refinement.
struct AdaptivePeer {
    virtual ~AdaptivePeer() = default;
    virtual void prepare() = 0;  ///< makes the control mesh with all data that the subdivider needs
    virtual void refine() = 0;
    virtual AdaptiveResult result() const = 0;
};
std::unique_ptr<AdaptivePeer> openmesh_adaptive(const AdaptiveTask& task);

}  // namespace tetrakis::bench
