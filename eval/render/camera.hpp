#pragma once

#include "../../hier/base/vec.hpp"

#include <span>

namespace tetrakis {

/// A pinhole camera.
struct Camera {
    Vec3d eye{0, 0, 5};
    Vec3d target{0};  ///< what lies in the middle of the picture
    Vec3d up{0, 1, 0};
    double vertical_fov_degrees = 30;
};

/// From where a fitted camera looks: turned about `up` from the front (+z, or -y where up is z), then raised.
struct ViewDirection {
    double azimuth_degrees = 32, elevation_degrees = 20;
    Vec3d up{0, 1, 0};
    double margin = 0.1;  ///< share of the picture left free on the tightest sides
    double vertical_fov_degrees = 28;
};

/// The closest camera that sees all points, the projected model in the middle. @param aspect  width / height
Camera fit_camera(std::span<const Vec3d> points, double aspect, const ViewDirection& view = {});

}  // namespace tetrakis
