#pragma once

#include "../../eval/lod/view.hpp"

#include <cstdint>

namespace tetrakis::viewer {

/// Directions to the lights, of length one.
struct Lights {
    Vec3d key, fill, rim;
};
/// The lights that tetrakis::render() has where it looks from this camera.
Lights lights_of(const lod::Camera& camera);

/// How a frame is drawn.
struct Look {
    lod::Camera camera;
    double nearest = 1, farthest = 1e4;  ///< what is drawn, along the camera's direction
    Lights lights;
    bool wireframe = false;
};

/// A view's two buffers on the graphics card, and how they are drawn. Needs a current context of OpenGL 3.3 as long as
/// it lives.
class GpuTerrain {
  public:
    /// Makes buffers of the view's capacity; keeps a reference to the view.
    /// @throws Error  unsupported: the driver does not take the shaders, and why
    explicit GpuTerrain(const lod::View& view);
    ~GpuTerrain();
    GpuTerrain(const GpuTerrain&) = delete;
    GpuTerrain& operator=(const GpuTerrain&) = delete;

    /// Copies what an update has changed, and nothing else.
    /// @param eye  the camera's at the update: vertices morph by their distance to it
    /// @return     how many bytes that were
    std::uint64_t upload(const lod::Update& update, const Vec3d& eye);
    /// Fills the viewport: the sky, and the ground before it.
    void draw(const Look& look) const;

  private:
    const lod::View& view_;
    unsigned ground_ = 0, sky_ = 0;  // programs
    unsigned arrays_ = 0, no_arrays_ = 0, vertices_ = 0, triangles_ = 0;
    Vec3d morph_eye_{};
    double morph_scale_ = 0;
};

}  // namespace tetrakis::viewer
