#pragma once

#include "../../hier/base/vec.hpp"
#include "mesh_sliding.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// A face of a mesh laid flat: its corners dropped onto the plane across its mean normal. Errors by EdgeSliding, as
/// TriangleDistance has them for triangles.
class ConvexFace {
  public:
    ConvexFace() = default;
    explicit ConvexFace(std::span<const Vec3d> corners);

    /// Whether the corners are those of a convex polygon, in their order. Errors need it.
    bool convex() const { return convex_; }
    /// How far the corners are from the plane at most. Every triangulation of them is that close to the flat polygon,
    /// point over point; unfolded over an edge, by flaps (see EdgeSliding) of 45 degrees at most, twice that.
    double height() const { return height_; }
    /// @param fold, flap  of the edge from corner k to the next one, against a triangle of the face's own triangulation
    /// @param normal      of that triangle
    void set_sliding(std::size_t k, double fold, double flap, const Vec3d& normal);

    const Vec3d& local(const Vec3d& p) const { return p; }
    /// What errors have been divided by.
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
    /// Whether the foot of a point so far from an edge's line lies in the flaps there.
    bool in_flaps(const Vec3d& p, std::size_t k, double off) const;

    std::vector<Vec3d> corner_;
    std::vector<Edge> edge_;
    Vec3d normal_{0};
    double height_ = 0, fold_ = 0;
    bool convex_ = false;
};

}  // namespace tetrakis::detail
