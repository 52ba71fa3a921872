#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../io/png.hpp"
#include "../surface/triangle_mesh.hpp"

#include <optional>
#include <span>
#include <string>

namespace tetrakis {

/// A pinhole camera.
struct Camera {
    Vec3d eye{0, 0, 5};
    Vec3d target{0};  ///< a point that appears in the middle of the picture
    Vec3d up{0, 1, 0};
    double vertical_fov_degrees = 30;
};

/// View direction of a fitted camera: from the front (+z; -y if `up` is about z), turned about `up`, then raised.
struct ViewDirection {
    double azimuth_degrees = 32, elevation_degrees = 20;
    Vec3d up{0, 1, 0};
    double margin = 0.1;  ///< share of the picture left free on the tightest sides
    double vertical_fov_degrees = 28;
};

/// The closest camera with this direction that sees all points, with the projected model in the middle.
/// @param aspect  width / height
/// @throws Error  invalid_input: a margin that is not in [0, 1)
Camera fit_camera(std::span<const Vec3d> points, double aspect, const ViewDirection& view = {});

enum class Shading { smooth, flat };

/// Options of render(). Colours are sRGB in [0, 1]. The defaults suit a presentation picture.
struct RenderOptions {
    int width = 1200, height = 900;
    std::optional<Camera> camera;  ///< unset: fitted to the mesh, looking from `view`
    ViewDirection view;
    Shading shading = Shading::smooth;
    double crease_degrees = 40;  ///< smooth shading stops at edges sharper than this, unless normals are by corner

    bool wireframe = false;
    double wire_pixels = 1.1;  ///< line width, the same at any distance; lines fade on triangles of a few pixels
    Vec3f wire_colour{0.10f, 0.13f, 0.19f};

    /// Heat map: one value per triangle, e.g. Tessellation::triangle_error; empty: none.
    std::span<const float> triangle_values;
    double lowest_value = 0;
    std::optional<double> highest_value;  ///< unset: the largest of the values
    bool legend = true;
    std::string legend_title;  ///< ASCII

    Vec3f surface_colour{0.80f, 0.62f, 0.46f};
    Vec3f back_colour{0.42f, 0.46f, 0.55f};  ///< colour of back faces
    Vec3f background_top{0.965f, 0.970f, 0.980f}, background_bottom{0.870f, 0.885f, 0.905f};
    bool ground = true;  ///< draws a shadow on a ground under the model

    int supersampling = 3;       ///< n: a pixel gets n^2 camera rays
    int occlusion_samples = 24;  ///< ambient occlusion rays per pixel; 0: none
};

/// Draws a mesh by casting rays: a soft key light with shadow, fill, rim and sky light with ambient occlusion.
/// Same bytes for any number of threads.
/// @throws Error invalid_input: no triangles, an index out of range, a position not finite, sizes or values out of
///               range, a camera without direction; memory_limit; cancelled
/// Cost: about 40 rays a pixel; some seconds for a million pixels.
Image render(const TriangleMesh& mesh, const RenderOptions& options = {}, const RunContext& context = {});

}  // namespace tetrakis
