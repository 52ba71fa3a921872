#pragma once

#include "../../hier/base/vec.hpp"

#include <span>

namespace tetrakis::detail {

/// Normal of a vertex without tangents, from the faces around it: the mean of their normals at its corners. If those
/// vanish or cancel, the mean of the normals of the whole faces; if these cancel too, one face's normal.
class FaceNormals {
  public:
    /// The unit normal at a corner between its next and previous point; zero if the three points lie on a line.
    static Vec3d at_corner(const Vec3d& corner, const Vec3d& next, const Vec3d& previous) {
        const Vec3d ahead = next - corner, behind = previous - corner, cross = glm::cross(ahead, behind);
        // A crease that runs straight through its vertex has no corner there.
        constexpr double k_flat = 1e-10;
        const bool turns = glm::length(cross) > k_flat * glm::length(ahead) * glm::length(behind);
        return turns ? unit_or_zero(cross) : Vec3d(0);
    }

    /// @param points  points of a face; the vertex is point number `corner`
    void add(std::span<const Vec3d> points, std::size_t corner) {
        const std::size_t size = points.size();
        corners_ += at_corner(points[corner], points[(corner + 1) % size], points[(corner + size - 1) % size]);
        Vec3d area(0);
        for (std::size_t i = 1; i + 1 < size; ++i) area += glm::cross(points[i] - points[0], points[i + 1] - points[0]);
        const Vec3d normal = unit_or_zero(area);
        faces_ += normal;
        // The choice must not depend on the order of the faces.
        if (one_ == Vec3d(0) || (normal != Vec3d(0) && is_before(one_, normal))) one_ = normal;
    }
    Vec3d normal() const {
        const Vec3d corners = unit_of_sum(corners_), faces = unit_of_sum(faces_);
        return corners != Vec3d(0) ? corners : faces != Vec3d(0) ? faces : one_;
    }

  private:
    static bool is_before(const Vec3d& a, const Vec3d& b) {
        return a.z != b.z ? a.z < b.z : a.y != b.y ? a.y < b.y : a.x < b.x;
    }

    Vec3d corners_{0}, faces_{0}, one_{0};
};

}  // namespace tetrakis::detail
