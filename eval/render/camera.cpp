#include "render.hpp"

#include "../../hier/base/error.hpp"

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include <cmath>

namespace tetrakis {

Camera fit_camera(std::span<const Vec3d> points, double aspect, const ViewDirection& view) {
    if (!(view.margin >= 0 && view.margin < 1))
        throw Error(
            ErrorCode::invalid_input,
            fmt::format("a margin of {}; it is a share of the picture, 0 or more and less than 1", view.margin));
    const Vec3d given_up = unit_or_zero(view.up), up = given_up == Vec3d(0) ? Vec3d(0, 1, 0) : given_up;
    const Vec3d front_axis = std::abs(up.z) > 0.9 ? Vec3d(0, -1, 0) : Vec3d(0, 0, 1);
    const Vec3d front = glm::normalize(front_axis - glm::dot(front_axis, up) * up);
    const Vec3d side = glm::cross(up, front);
    const double azimuth = glm::radians(view.azimuth_degrees);
    const double elevation = glm::radians(std::clamp(view.elevation_degrees, -89.0, 89.0));
    const Vec3d towards_eye =
        std::cos(elevation) * (std::cos(azimuth) * front + std::sin(azimuth) * side) + std::sin(elevation) * up;
    const Vec3d forward = -towards_eye;
    const Vec3d right = glm::normalize(glm::cross(forward, up)), above = glm::cross(right, forward);

    const Box3d box = bounding_box(points);
    const Vec3d centre = box.empty() ? Vec3d(0) : box.centre();
    const double tan_v = std::tan(glm::radians(view.vertical_fov_degrees) / 2) * (1 - view.margin);
    const double tan_h = tan_v * aspect;
    // A point is visible if |x - eye.x| <= tan_h (z - eye.z), and the same for y. For x and y separately, the eye
    // farthest forward that satisfies all inequalities is computed; the one farther back is used.
    const double k_none = -std::numeric_limits<double>::infinity();
    double right_most = k_none, left_most = k_none, top_most = k_none, bottom_most = k_none, nearest = -k_none;
    for (const Vec3d& p : points) {
        const Vec3d d = p - centre;
        const double x = glm::dot(d, right), y = glm::dot(d, above), z = glm::dot(d, forward);
        right_most = std::max(right_most, x - tan_h * z);
        left_most = std::max(left_most, -x - tan_h * z);
        top_most = std::max(top_most, y - tan_v * z);
        bottom_most = std::max(bottom_most, -y - tan_v * z);
        nearest = std::min(nearest, z);
    }
    Camera camera;
    camera.up = up;
    camera.vertical_fov_degrees = view.vertical_fov_degrees;
    const double radius = std::max(box.diagonal() / 2, std::numeric_limits<double>::min());
    if (points.empty() || !(radius > std::numeric_limits<double>::min())) {
        camera.target = centre;
        camera.eye = centre + 5.0 * towards_eye;
        return camera;
    }
    const double z = std::min({-(right_most + left_most) / (2 * tan_h), -(top_most + bottom_most) / (2 * tan_v),
                               nearest - 0.05 * radius});  // a flat model seen edge-on needs some distance too
    const Vec3d eye = 0.5 * (right_most - left_most) * right + 0.5 * (top_most - bottom_most) * above + z * forward;
    camera.eye = centre + eye;
    camera.target = camera.eye - z * forward;
    return camera;
}

}  // namespace tetrakis
