#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_kind.hpp"
#include "edge_sharpness.hpp"
#include "root_lattices.hpp"

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A vertex at a level that goes without saying, in the one frame that is its own; roots are corner cells, or triangles
/// by their half-edges.
using VertexKey = RootPlace;

struct StencilEntry {
    VertexKey key;
    double weight;
};

/// A ring of keys with its tags, counter-clockwise, in the order of RingLimit's weights.
struct KeyRing {
    std::vector<VertexKey> keys;
    int faces = 0;
    bool boundary = false;
    float vertex_sharpness = 0, child_vertex_sharpness = 0;
    /// Per edge: now, the near half one level on, the far half one level on. Empty where no edge is sharp.
    std::vector<float> sharpness, child, outer_child;

    void clear() {
        keys.clear();
        sharpness.clear();
        child.clear();
        outer_child.clear();
        faces = 0;
        boundary = false;
        vertex_sharpness = child_vertex_sharpness = 0;
    }
};

/// Catmull-Clark on corner cells; lattice level l is scheme level l + 1. A vertex' own frame:
/// control vertex: (0, 0) of its vertex_halfedge; face point: (N, N) of the face's first half-edge; edge midpoint:
/// (N, 0) of the edge's first half-edge; on an edge: (x, 0) of the half-edge that starts at the nearer end (on a
/// boundary without such a half-edge (0, y) of the cell there); on a spoke: (N, y) of the half-edge it leaves.
class QuadStencils {
  public:
    static constexpr SchemeKind scheme = SchemeKind::catmull_clark;
    explicit QuadStencils(const ControlMesh& mesh);

    VertexKey canonical(VertexKey at, int level) const;
    void ring(VertexKey key, int level, KeyRing& ring) const;
    /// Weights on the vertices of level - 1; level >= 1.
    void stencil(VertexKey key, int level, KeyRing& scratch, std::vector<StencilEntry>& out) const;
    /// Positions at level 0.
    /// Of a vertex of level 0, in base().
    std::uint32_t base_number(VertexKey key) const;
    std::span<const Vec3d> base() const { return base_; }

  private:
    const ControlMesh* mesh_;
    EdgeSharpness sharpness_;
    std::vector<Vec3d> base_;  ///< vertices, faces, edges
};

/// Loop on face triangles; lattice level = scheme level. A vertex' own frame: control vertex: (0, 0) of its
/// vertex_halfedge; on an edge: (x, 0) of the edge's first half-edge; inside: (x, y) of the face's first half-edge. The
/// frame of a half-edge h has x along h and y along prev(h) reversed.
class TriangleStencils {
  public:
    static constexpr SchemeKind scheme = SchemeKind::loop;
    explicit TriangleStencils(const ControlMesh& mesh);

    VertexKey canonical(VertexKey at, int level) const;
    void ring(VertexKey key, int level, KeyRing& ring) const;
    void stencil(VertexKey key, int level, KeyRing& scratch, std::vector<StencilEntry>& out) const;
    std::uint32_t base_number(VertexKey key) const;
    std::span<const Vec3d> base() const { return mesh_->positions(); }

  private:
    const ControlMesh* mesh_;
    EdgeSharpness sharpness_;
    struct Frames {
        std::uint32_t vertex, edge;  // the half-edges whose frames those of its origin and its edge are
    };
    std::vector<Frames> frames_;  // per half-edge
};

/// The rule that takes a ring's vertex to the next level, as weights on the ring's keys.
void vertex_rule_stencil(SchemeKind scheme, const KeyRing& ring, std::vector<StencilEntry>& out);

/// Tags of a vertex inside a control edge: pieces i - 1 and i of h's edge at scheme level `level` meet there, and are
/// the ring's edges `before` and `after`.
void edge_point_tags(const EdgeSharpness& sharpness, HalfedgeId h, int level, std::uint64_t i, int before, int after,
                     int edges, KeyRing& ring);
/// Tags of a control vertex, `level` the scheme level.
void control_vertex_tags(const ControlMesh& mesh, const EdgeSharpness& sharpness, VertexId v, int level, KeyRing& ring);

}  // namespace tetrakis::detail
