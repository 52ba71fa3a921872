#pragma once

#include "../../hier/base/vec.hpp"
#include "mesh_sliding.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// A face of a mesh, flattened: its corners are projected onto the plane perpendicular to its mean normal. It gives
/// errors with EdgeSliding, as TriangleDistance does for triangles.
class ConvexFace {
  public:
    ConvexFace() = default;
    explicit ConvexFace(std::span<const Vec3d> corners);

    /// Whether the corners in their order are a convex polygon; errors exist only then.
    bool convex() const { return convex_; }
    /// Largest distance of a corner from the plane. Every triangulation of the face is that close to the flat polygon,
    /// point over point. It is twice that if flaps (see EdgeSliding) of at most 45 degrees are unfolded over an edge.
    double height() const { return height_; }
    /// @param fold, flap  at the edge from corner k to the next one, for the triangle there of the face's triangulation
    /// @param normal      unit normal of that triangle
    void set_sliding(std::size_t k, double fold, double flap, const Vec3d& normal);

    const Vec3d& local(const Vec3d& p) const { return p; }
    /// Factor by which to_face() and to_edge() have been divided.
    double stretch() const { return (1 + fold_) * (1 + 0.25 * fold_ * fold_); }
    double to_face(const Vec3d& p) const;
    double to_edge(const Vec3d& p, std::size_t k) const;

  private:
    struct Edge {
        Vec3d along{0}, out{0};  ///< of unit length, in the plane
        double length = 0;
        bool slides = false;
        double fold = 0, flap = 0;
    };
    bool turns_once() const;
    double edge_distance(const Vec3d& p, std::size_t k) const;
    /// Whether the foot of p, at distance `off` from the line of edge k, lies in the flaps there.
    bool in_flaps(const Vec3d& p, std::size_t k, double off) const;

    std::vector<Vec3d> corner_;
    std::vector<Edge> edge_;
    Vec3d normal_{0};
    double height_ = 0, fold_ = 0;
    bool convex_ = false;
};

}  // namespace tetrakis::detail
