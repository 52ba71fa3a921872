#pragma once

#include "../../eval/lod/view.hpp"

#include <cstdint>

namespace tetrakis::viewer {

/// Unit directions to the lights.
struct Lights {
    Vec3d key, fill, rim;
};
/// The lights of tetrakis::render() for this camera.
Lights lights_of(const lod::Camera& camera);

/// How a frame is drawn.
struct Look {
    lod::Camera camera;
    double nearest = 1, farthest = 1e4;  ///< depths of the clipping planes
    Lights lights;
    bool wireframe = false;
};

/// Copies a view's two buffers to the graphics card and draws them. An OpenGL 3.3 context must be current as long as
/// the object lives.
class GpuTerrain {
  public:
    /// Makes buffers of the view's capacity. Keeps a reference to the view.
    /// @throws Error  unsupported: the driver does not accept the shaders (the message says why)
    explicit GpuTerrain(const lod::View& view);
    ~GpuTerrain();
    GpuTerrain(const GpuTerrain&) = delete;
    GpuTerrain& operator=(const GpuTerrain&) = delete;

    /// Copies only the ranges that an update has changed.
    /// @param eye  the camera's eye at the update: vertices morph by their distance from it
    /// @return     number of bytes copied
    std::uint64_t upload(const lod::Update& update, const Vec3d& eye);
    /// Fills the viewport with the sky and the ground in front of it.
    void draw(const Look& look) const;

  private:
    const lod::View& view_;
    unsigned ground_ = 0, sky_ = 0;  // programs
    unsigned arrays_ = 0, no_arrays_ = 0, vertices_ = 0, triangles_ = 0;
    Vec3d morph_eye_{};
    double morph_scale_ = 0;
};

}  // namespace tetrakis::viewer
