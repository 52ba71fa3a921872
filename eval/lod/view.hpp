#pragma once

#include "../../hier/base/ids.hpp"
#include "../../hier/base/vec.hpp"
#include "../lod_surfaces/surface.hpp"
#include "../surface/triangle_mesh.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis::lod {

struct Camera {
    Vec3d eye{};
    Vec3d direction{0, 1, 0};  ///< of any length but zero
    Vec3d up{0, 0, 1};         ///< need not be square to the direction; any other one where it is along it
    double vertical_fov = 1;   ///< radians, between 0 and pi
    std::uint32_t width = 1920, height = 1080;  ///< pixels, not zero
};

/// A ball in which errors count more: around a player, or where things collide.
struct Region {
    Vec3d center{};
    double radius = 0;
    double boost = 1;  ///< errors of what touches the ball are multiplied by this; from 1 on
};

/// What an update may cost.
struct Budget {
    double pixel_error = 1;  ///< triangles whose error looks larger are split; positive
    /// The largest number of triangles, at most View::max_leaves(). The roots stay in any case.
    std::uint32_t leaves = std::numeric_limits<std::uint32_t>::max();
    /// An update ends soon after this, between two changes, and the next one goes on; 0: no limit. Triangles beyond
    /// `leaves` are merged first, and after View::set_origin() and View::set_regions() all vertices are written,
    /// however long that takes. Where pixel_error, the field of view or regions change each time, what was decided by
    /// earlier ones is brought to an end first.
    double milliseconds = 0;
};

struct ViewOptions {
    /// Room for so many triangles is made at once, and never more, but that the roots have room. Fewer fit where most
    /// of them are along a boundary, because these have more vertices.
    std::uint32_t max_leaves = 200'000;
    std::uint64_t max_bytes = 0;      ///< fewer leaves if these would take more; 0: no limit
    std::uint32_t max_ranges = 4096;  ///< of one buffer in one update; the nearest ones are joined
    double outside_weight = 0.25;     ///< errors out of sight count this much; from 0 to 1
    double hysteresis = 0.8;  ///< triangles are merged where the error looks this small a part of the limit; 0.1 to 0.8
};

/// A vertex as graphics cards get it. Its shader shows mix(position, on_edge, w) with
/// w = clamp((distance to the eye / (error * Update::morph_scale) - k_morph_begin) / (1 - k_morph_begin), 0, 1),
/// so that splits and merges are hardly seen to happen. A shader moves no vertex farther than Update::pixel_error from
/// its place, and between two updates not faster than the README's lemma says.
struct Vertex {
    std::array<float, 3> position;       ///< relative to View::origin()
    std::array<float, 3> on_edge;        ///< on the edge that it halves: the same frame
    std::array<std::int16_t, 2> normal;  ///< octahedral, 32767 is 1 (Meyer et al. 2010)
    std::array<float, 2> uv;
    float error;  ///< of the diamond that it halves, boosted; infinite for vertices of roots, which do not move
};
static_assert(sizeof(Vertex) == 40);
inline constexpr double k_morph_begin = 0.85;

using Triangle = std::array<std::uint32_t, 3>;  ///< vertices, counter-clockwise; all zero: not in use

/// What an update did, and what of the buffers has changed since the one before.
struct Update {
    struct Range {
        std::uint32_t first = 0, count = 0;
    };
    std::span<const Range> vertices, triangles;  ///< ascending; valid until the next update
    std::uint32_t splits = 0, merges = 0;        ///< diamonds; none for what a jump of the camera gives up at once
    std::uint32_t leaves = 0;
    /// No error of a triangle that can be split looks larger than so many pixels; out of sight, times outside_weight.
    /// The budget's, or more where its leaves did not suffice; infinite where its time did not, and where they did not
    /// suffice for a triangle whose box the eye is in.
    double pixel_error = 0;
    double morph_scale = 0;  ///< for shaders: length / length; positive
    bool complete = true;    ///< the time did suffice
    /// Diamonds that the surface does not know yet; they stay as they are, and pixel_error is that of the others. Where
    /// any are, it may be that they change with the next update though the camera does not.
    std::uint32_t waiting = 0;
};

/// A surface as one camera needs it: a conforming triangle mesh in two buffers, changed by each update() where the
/// camera's way asks for it. A diamond is looked at again when the camera has moved so far that the decision about it
/// may be another: a camera that stands still costs nothing, and a moving one as much as changes. One that jumps so far
/// that half of the triangles are to be merged begins with the roots.
///
/// A triangle is at the place of its leaf's slot, which stays the same while the leaf is there, unless a third of the
/// slots is free: then the last leaves move to free ones. A leaf is split where its diamond's error, seen from the
/// nearest point of the diamond's box, is more than the budget's pixels; where the leaves do not suffice the largest
/// errors come first. As bounds are nested, what is split depends on the camera alone where neither leaves nor time
/// bind, but for hysteresis and the few per cent of an error that let a camera go on before the next look.
///
/// Views are for one thread each; any number may share a surface.
class View {
  public:
    /// The roots. Keeps a reference to the surface.
    /// @throws Error  invalid_input: options out of their ranges; memory_limit: max_bytes are too few for the roots
    explicit View(const Surface& surface, const ViewOptions& options = {});
    explicit View(const Surface&&, const ViewOptions& = {}) = delete;
    ~View();
    View(View&&) noexcept;
    View& operator=(View&&) noexcept;

    /// @throws Error  invalid_input: a camera with a number that is not finite or beyond 1e60, without direction,
    ///                extent or pixels, a pixel error that is not positive, negative milliseconds. The view is then
    ///                unchanged.
    /// Cost: O(changes), and a few looks at diamonds for each; all of them are looked at where the view's opening, its
    /// pixels or the pixel error change, or regions do.
    Update update(const Camera& camera, const Budget& budget = {});

    /// All diamonds are looked at and all vertices written by the next update: O(leaves).
    /// @throws Error  invalid_input: a radius or boost that is out of its range
    void set_regions(std::vector<Region> regions);

    /// Positions are relative to it, so that single precision suffices near it. All vertices change: O(vertices).
    /// Vertices that the surface does not know any more keep the precision that they had with the old one.
    /// @throws Error  invalid_input: a coordinate that is not finite or beyond 1e30
    Vec3d origin() const;
    void set_origin(const Vec3d& origin);

    std::span<const Vertex> vertices() const;     ///< not all of them are in use
    std::span<const Triangle> triangles() const;  ///< not all of them are in use
    std::uint32_t leaf_count() const;
    std::uint32_t max_leaves() const;  ///< options.max_leaves, or what max_bytes let
    /// vertices() and triangles() are never longer than these. Triangles beyond triangles().size() are not to be drawn.
    std::uint32_t vertex_capacity() const;
    std::uint32_t triangle_capacity() const;
    std::uint64_t memory_bytes() const;

    /// The triangles as they are, without morphing: positions in the surface's own frame and precision, normals, uvs.
    /// O(vertices + triangles). Vertices that the surface does not know any more are as precise as in vertices().
    TriangleMesh mesh() const;
    /// Leaves as they are, in no order: the site of each corner.
    std::vector<std::array<Site, 3>> leaves() const;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Where a shader shows a vertex, relative to the view's origin, for an eye that is relative to it, too.
Vec3d shown_position(const Vertex& vertex, const Vec3d& eye, double morph_scale);

}  // namespace tetrakis::lod
