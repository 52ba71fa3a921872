#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../schemes/core/masks.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../rules/limit_point.hpp"

#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// A vertex of a level of sqrt(3) refinement and those around it, counter-clockwise: from the one with the least
/// half-edge, or on the boundary from one end to the other.
struct Sqrt3Ring {
    Vec3d point{0};
    std::vector<Vec3d> around;
    bool closed = true;
    std::vector<std::pair<std::size_t, float>> sharp;  ///< which of these sharp edges go to, and how sharp they are
    float vertex_sharpness = 0;

    VertexRule rule() const {
        if (is_sharp(vertex_sharpness) || sharp.size() > 2) return VertexRule::corner;
        constexpr VertexRule k_rules[] = {VertexRule::smooth, VertexRule::dart, VertexRule::crease};
        return k_rules[sharp.size()];
    }
    /// Whether some sharpness will run out.
    bool is_finite() const;
};

/// The sqrt(3) scheme's rules on the rings of simple steps' levels; keeps its masks.
class Sqrt3Rules {
  public:
    /// The tag of a vertex that is left of it at a level.
    static float vertex_sharpness(const ControlMesh& mesh, const Sqrt3Vertex& v, int level);
    static Vec3d centre(const std::array<Vec3d, 3>& corners) {
        Vec3d sum(0);
        for (const Vec3d& p : corners) sum += (1.0 / 3) * p;
        return sum;
    }
    /// Of a smooth vertex.
    /// @param around  the sum of those around it, in their order
    static Vec3d masked(const RingMask& mask, const Vec3d& point, const Vec3d& around) {
        return mask.vertex * point + mask.edge * around;
    }
    /// The point of a kept edge that is smooth beside `near`, between the opposite corners of its faces: the centre of
    /// the flipped triangle. From either side the same bits.
    static Vec3d beside_smooth(const Vec3d& near, const Vec3d& opposite, const Vec3d& beyond);
    /// The point of a sharp edge beside `near`, whose crease goes on to `beyond` on its other side (nothing: it ends).
    static Vec3d beside(const Vec3d& near, const Vec3d& far, const Vec3d* beyond);
    /// The vertex at the next level.
    Vec3d moved(const Sqrt3Ring& ring, bool cuts);
    /// Tangents only where the surface is smooth; elsewhere the normal is the mean of those of the faces around. From
    /// the ring of a level before the first of two steps, of a smooth vertex away from cut edges of any; not where a
    /// sharp edge goes to a dart, which the first step moves.
    LimitPoint limit(const Sqrt3Ring& ring);
    /// Its position alone.
    Vec3d limit_position(const Sqrt3Ring& ring);

  private:
    struct Masks {
        RingMask vertex, limit;
        std::vector<double> cosine, sine;  ///< of the ring's directions
    };
    /// Weights of those around a dart, from its sharp edge on.
    struct DartMasks {
        double vertex = 1;
        std::vector<double> limit, tangent1, tangent2;
    };
    const Masks& masks(std::size_t valence);
    const DartMasks& dart_masks(std::size_t valence);
    LimitPoint dart_limit(const Sqrt3Ring& ring);
    Sqrt3Ring after_two_steps(const Sqrt3Ring& ring);
    Sqrt3Ring settled(Sqrt3Ring ring);

    std::vector<Masks> masks_;  // per valence, empty until they are asked for
    std::map<std::size_t, DartMasks> darts_;
};

}  // namespace tetrakis::detail
