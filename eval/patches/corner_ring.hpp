#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../../schemes/core/short_list.hpp"
#include "../surface/surface_point.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A corner of a Catmull-Clark or Loop cell, with the points and tags around it that the rules use. A ring determines
/// the ring of the next level: the vertex point, the edge points around it and, for Catmull-Clark, the face points.
struct CornerRing {
    /// An edge at the centre.
    struct Spoke {
        Vec3d point{0};       ///< its other end
        Vec3d face{0};        ///< quads: the far corner of the face between this spoke and the next
        float sharpness = 0;  ///< of the edge (infinity at a boundary)
        float near_half = 0;  ///< sharpness of its half at the centre, one level further down
        float far_half = 0;   ///< of its half at the other end
    };
    SchemeKind scheme = SchemeKind::loop;
    Vec3d centre{0};
    float sharpness = 0;        ///< of the centre
    bool boundary = false;      ///< the first and last spokes are boundary edges
    bool chaikin = false;       ///< sharpness is refined by Chaikin's method
    int cell = 0;               ///< the cell lies between spokes `cell` (to its next corner) and `cell` + 1
    std::vector<Spoke> spokes;  ///< counter-clockwise

    int size() const { return static_cast<int>(spokes.size()); }
    int faces() const { return size() - (boundary ? 1 : 0); }
    int wrap(int i) const { return (i % size() + size()) % size(); }
    const Spoke& spoke(int i) const { return spokes[static_cast<std::size_t>(wrap(i))]; }

    /// Fills the spokes' near_half from their sharpness.
    void halve();
    /// Face point of the face between a spoke and the next one; quads.
    Vec3d face_point(int spoke) const;
    Vec3d edge_point(int spoke) const;
    Vec3d vertex_point() const;
    /// The ring one level further down, around the same vertex.
    CornerRing child() const;

    /// Whether no tag is semi-sharp, so that all later levels have the same tags.
    bool is_stationary() const;
    /// Whether the centre is interior, and neither it nor a spoke is sharp.
    bool is_smooth() const;
    /// The faces between two sharp spokes, among them the face after spoke `at`; empty if fewer than two are sharp.
    struct Sector {
        int first, faces;  ///< the first spoke (at most `at`, maybe negative); number of faces
        bool corner;       ///< the centre, or a third spoke, is sharp
    };
    std::optional<Sector> sector(int at) const;
    std::optional<Sector> sector() const { return sector(cell); }
    /// Limit position, normal, and tangents of the cell's sector. The tangents are zero at interior vertices of valence
    /// 2, and at ends of creases whose analysis gives no tangents. @throws std::invalid_argument  there is no limit
    /// mask
    SurfacePoint limit() const;
    void add_points(std::vector<Vec3d>& points) const;
};

/// The points around a corner outside its cell.
using OuterPoints = ShortList<Vec3d, 8>;

/// Ring of the midpoint of a cell's side. Its spoke 0 leads towards the centre of `to`; spoke 1 leads into the cell,
/// which is on the left.
/// @param from, to              the rings of the side's ends, one level up
/// @param from_child, to_child  child() of these
CornerRing side_ring(const CornerRing& from, const CornerRing& to, const CornerRing& from_child,
                     const CornerRing& to_child);

/// The ring of the control vertex that half-edge `h` leaves; its cell is on the left of `h`.
/// @param face_points  by face, for Catmull-Clark. Spoke::face is chosen such that the quad's corners have this mean
CornerRing control_ring(const ControlMesh& mesh, SchemeKind scheme, HalfedgeId h,
                        std::span<const Vec3d> face_points = {});

/// Sharpness of the half at a half-edge's origin, one level below the control mesh.
float half_sharpness(const ControlMesh& mesh, HalfedgeId h);

/// A cell of Loop or Catmull-Clark by the rings of its corners, counter-clockwise.
template <std::size_t Corners>
struct CellRings {
    std::array<CornerRing, Corners> corner;

    /// Sharpness of the side from corner k to the next one.
    float side_sharpness(std::size_t k) const { return corner[k].spoke(corner[k].cell).sharpness; }

    /// The four quarters. Corner k of quarter k is corner k of the cell. For triangles [3] is the central one; its
    /// corner k is the midpoint of the side opposite corner k.
    std::array<CellRings, 4> children() const;
    /// All points of the rings; the limit surface over the cell lies in their convex hull.
    std::vector<Vec3d> points() const;
    std::size_t memory_bytes() const;
};

/// Calls visit(h) for the half-edges that leave a vertex, counter-clockwise, from its first one on.
template <class Visit>
void for_each_outgoing(const ControlMesh& mesh, VertexId v, Visit&& visit) {
    const HalfedgeId start = mesh.vertex_halfedge(v);
    HalfedgeId h = start;
    do {
        visit(h);
        h = mesh.ccw_outgoing(h);
    } while (h.valid() && h != start);
}

}  // namespace tetrakis::detail
