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
    Vec3d direction{0, 1, 0};  ///< any length but zero
    Vec3d up{0, 0, 1};         ///< need not be perpendicular to `direction`; if parallel, another one is used
    double vertical_fov = 1;   ///< radians, between 0 and pi
    std::uint32_t width = 1920, height = 1080;  ///< pixels, not zero
};

/// A ball in which errors have more weight, for example around a player or where objects collide.
struct Region {
    Vec3d center{};
    double radius = 0;
    double boost = 1;  ///< factor for the errors of diamonds whose box touches the ball; at least 1
};

/// Limits of an update.
struct Budget {
    double pixel_error = 1;  ///< triangles with a larger error on screen are split; positive
    /// The largest number of triangles, at most View::max_leaves(). Root triangles stay even if there are more of them.
    std::uint32_t leaves = std::numeric_limits<std::uint32_t>::max();
    /// An update ends soon after this time, and the next update continues its work; 0: no limit. Two tasks are always
    /// finished: merges down to `leaves` triangles, and writing all vertices after View::set_origin() or
    /// View::set_regions(). If pixel_error, the field of view or the regions change with each update, work that their
    /// earlier values caused may be finished first.
    double milliseconds = 0;
};

struct ViewOptions {
    /// Memory for this many triangles (at least for the roots) is reserved at once and never grows. Fewer fit if most
    /// of them are along a boundary, where there are more vertices to a triangle.
    std::uint32_t max_leaves = 200'000;
    std::uint64_t max_bytes = 0;      ///< lowers max_leaves if needed; 0: no limit
    std::uint32_t max_ranges = 4096;  ///< of one buffer in one update; beyond that the nearest are joined
    double outside_weight = 0.25;     ///< factor for errors out of sight; from 0 to 1
    double hysteresis = 0.8;  ///< triangles are merged below this part of the allowed pixel error; from 0.1 to 0.8
};

/// A vertex in the layout for the GPU. The shader shows mix(position, on_edge, w) with
/// w = clamp((distance to the eye / (error * Update::morph_scale) - k_morph_begin) / (1 - k_morph_begin), 0, 1),
/// so that splits and merges are hardly visible. A shader moves no vertex farther than Update::pixel_error from its
/// `position`; the lemma in README.md bounds the motion between two updates.
struct Vertex {
    std::array<float, 3> position;       ///< relative to View::origin()
    std::array<float, 3> on_edge;        ///< point of the edge that it bisects, in the same frame
    std::array<std::int16_t, 2> normal;  ///< octahedral, 32767 is 1 (Meyer et al. 2010)
    std::array<float, 2> uv;
    float error;  ///< of the diamond around it, times the regions' boost; infinite for root vertices: they do not move
};
static_assert(sizeof(Vertex) == 40);
inline constexpr double k_morph_begin = 0.85;

using Triangle = std::array<std::uint32_t, 3>;  ///< vertices, counter-clockwise; all zero: not in use

/// Result of an update, and the parts of the buffers that have changed since the previous one.
struct Update {
    struct Range {
        std::uint32_t first = 0, count = 0;
    };
    std::span<const Range> vertices, triangles;  ///< ascending; valid until the next update
    std::uint32_t splits = 0, merges = 0;  ///< diamonds; triangles that a restart from the roots discards are no merges
    std::uint32_t leaves = 0;
    /// Bound in pixels on the errors on screen of all triangles that can be split; out of sight, times outside_weight.
    /// It is the budget's, or larger if its leaves did not suffice. It is infinite if the time did not suffice, or if
    /// there were too few leaves to split a triangle whose box contains the eye.
    double pixel_error = 0;
    double morph_scale = 0;  ///< for shaders (see Vertex): a ratio of lengths; positive
    bool complete = true;    ///< whether the time sufficed
    /// Number of diamonds whose bounds the surface has not loaded yet; pixel_error ignores them. While there are any,
    /// the next update may change the mesh even if the camera stands still.
    std::uint32_t waiting = 0;
};

/// View-dependent mesh of a surface for one camera: a conforming triangle mesh in two buffers, adapted by update(). A
/// diamond is evaluated again only when the camera has moved so far that the decision about it may change. So a camera
/// that stands still costs nothing, and the cost of a moving one is proportional to the changes. After a jump so far
/// that half of the triangles have to be merged, the mesh is rebuilt from the roots.
///
/// A triangle's index is its leaf's slot. It stays the same while the leaf exists, unless a third of the slots is free:
/// then the last leaves move to free slots. A leaf is split if its diamond's error, at the distance of the nearest
/// point of the diamond's box, exceeds the budget's pixels; if leaves are too few, the largest errors come first.
/// Bounds are nested. So the mesh depends on the camera alone if neither leaves nor time limit it, but for hysteresis
/// and a margin of a few per cent in the errors, within which a camera moves without new evaluations.
///
/// A view is for one thread at a time; const calls may run on several at once while no other one runs. Any number of
/// views may share a surface.
class View {
  public:
    /// Starts with the root triangles. Keeps a reference to the surface.
    /// @throws Error  invalid_input: options out of their ranges; memory_limit: max_bytes are too few for the roots
    explicit View(const Surface& surface, const ViewOptions& options = {});
    explicit View(const Surface&&, const ViewOptions& = {}) = delete;
    ~View();
    View(View&&) noexcept;
    View& operator=(View&&) noexcept;

    /// @throws Error  invalid_input: a camera with a number that is not finite or beyond 1e60, without direction,
    ///                extent or pixels, a pixel error that is not positive, negative milliseconds. The view is then
    ///                unchanged.
    /// Cost: O(changes), with a few evaluations of diamonds for each. All diamonds are evaluated again if the field of
    /// view, the picture's size, the pixel error or the regions change.
    Update update(const Camera& camera, const Budget& budget = {});

    /// The next update evaluates all diamonds again and writes all vertices: O(leaves). Each evaluation, then and
    /// later, looks at all regions.
    /// @throws Error  invalid_input: a radius or boost that is out of its range
    void set_regions(std::vector<Region> regions);

    /// Vertices are relative to the origin, so that single precision suffices near it. A new one changes all vertices:
    /// O(vertices). Vertices that the surface has unloaded keep the precision that they had with the old origin.
    /// @throws Error  invalid_input: a coordinate that is not finite or beyond 1e30
    Vec3d origin() const;
    void set_origin(const Vec3d& origin);

    /// The buffers, in which not all elements are in use. They stay in their places as long as the view lives; update()
    /// and set_origin() change their contents and lengths.
    std::span<const Vertex> vertices() const;
    std::span<const Triangle> triangles() const;
    std::uint32_t leaf_count() const;
    std::uint32_t max_leaves() const;  ///< options.max_leaves, or as many as max_bytes allows; at least the roots
    /// vertices() and triangles() are never longer than these. Triangles beyond triangles().size() are not to be drawn.
    std::uint32_t vertex_capacity() const;
    std::uint32_t triangle_capacity() const;
    std::uint64_t memory_bytes() const;

    /// The present triangles without morphing: positions in the surface's own frame and precision, normals, uvs.
    /// O(vertices + triangles). Vertices that the surface has unloaded are only as precise as in vertices().
    TriangleMesh mesh() const;
    /// Sites of the three corners of each present leaf, that with the right angle last; in the order of triangles(),
    /// without those that are not in use.
    std::vector<std::array<Site, 3>> leaves() const;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Position at which a shader shows a vertex. The result and `eye` are relative to the view's origin.
Vec3d shown_position(const Vertex& vertex, const Vec3d& eye, double morph_scale);

}  // namespace tetrakis::lod
