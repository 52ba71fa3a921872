#pragma once

#include "../base/ids.hpp"
#include "../base/run_context.hpp"
#include "../base/vec.hpp"

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

/// How a mesh's boundary is refined; the numbers are those of OpenSubdiv's tag.
enum class BoundaryRule {
    none = 0,             ///< faces that touch the boundary are dropped from the surface (their points still weigh in)
    edge_and_corner = 1,  ///< boundary edges are sharp, and so are boundary vertices with exactly one face
    edge_only = 2,        ///< boundary edges are sharp
};

/// How UVs are interpolated: OpenSubdiv's face-varying rules, by their numbers in the tag. Charts end at seams and at
/// the mesh boundary. The rules 1 to 3 fix UVs: each those of the rule before it, and more.
enum class FaceVaryingRule {
    smooth_all = 0,     ///< borders of charts are smooth curves
    corners_only = 1,   ///< corners of charts, which have one face, stay fixed
    corners_plus1 = 2,  ///< so do the UVs of a vertex where three charts or more meet
    corners_plus2 = 3,  ///< so do ends of seams inside the mesh, and the UVs opposite a chart's corner
    boundaries = 4,     ///< borders of charts are linear
    linear_all = 5,     ///< UVs are linear everywhere
};

/// How finite sharpness passes from an edge to its halves.
enum class CreaseMethod { uniform, chaikin };

/// Sharpness from which an edge or vertex counts as infinitely sharp (OpenSubdiv's convention).
inline constexpr float k_infinite_sharpness = 10.0f;

/// Everything a control mesh is made from. Plain arrays; sizes in the comments (V vertices, F faces, H face corners).
struct ControlMeshData {
    std::vector<Vec3d> positions;              ///< V points, any unit of length
    std::vector<std::uint32_t> face_offsets;   ///< F + 1; corners of face f are [face_offsets[f], face_offsets[f + 1])
    std::vector<std::uint32_t> face_vertices;  ///< H vertex numbers, counter-clockwise seen from outside

    struct EdgeTag {
        std::uint32_t a, b;  ///< the edge's vertices
        float sharpness;     ///< >= 0; k_infinite_sharpness and above: infinite
        std::uint64_t line = 0;
    };
    struct VertexTag {
        std::uint32_t vertex;
        float sharpness;
        std::uint64_t line = 0;
    };
    std::vector<EdgeTag> creases;
    std::vector<VertexTag> corners;
    /// Interior angle of a sector at a corner: of the faces between two neighbouring sharp edges. `face` is any of
    /// them. Loop, tuned Loop and Catmull-Clark have rules for it (schemes/rules/loop.hpp, catmull_clark.hpp).
    struct AngleTag {
        std::uint32_t vertex, face;
        double angle;  ///< radians, in (0, 2 pi) and not pi
        std::uint64_t line = 0;
    };
    std::vector<AngleTag> corner_angles;
    std::vector<std::uint32_t> holes;       ///< faces that are refined with the others but are not part of the surface
    std::vector<std::uint64_t> hole_lines;  ///< line numbers of `holes`, or empty

    std::vector<Vec2d> uvs;                   ///< distinct texture coordinates; empty: no UV layer
    std::vector<std::uint32_t> face_uvs;      ///< H numbers into `uvs`, or empty
    std::vector<Vec3d> normals;               ///< normals as read (never used to build the surface)
    std::vector<std::uint32_t> face_normals;  ///< H numbers into `normals`, or empty

    std::vector<std::uint32_t> face_material;  ///< F numbers into `materials`, or empty
    std::vector<std::string> materials;
    std::vector<std::uint32_t> face_group;  ///< F numbers into `groups`, or empty
    std::vector<std::string> groups;

    BoundaryRule boundary_rule = BoundaryRule::edge_and_corner;
    FaceVaryingRule face_varying_rule = FaceVaryingRule::corners_only;
    CreaseMethod crease_method = CreaseMethod::uniform;

    std::uint32_t first_number = 0;  ///< number of the first vertex, face, ... in messages; 1 if `source` counts from 1
    std::string source;              ///< file the data came from, for messages; may be empty
    std::vector<std::uint64_t> vertex_lines;  ///< V line numbers in `source`, or empty
    std::vector<std::uint64_t> face_lines;    ///< F line numbers in `source`, or empty
    std::vector<std::uint64_t> uv_lines;      ///< line numbers of `uvs` in `source`, or empty
    std::vector<std::string> warnings;        ///< from reading and repairing, one sentence each
};

/// A polygon mesh with half-edges, tags and attributes: the input of every scheme. Immutable.
///
/// Half-edges are face corners: half-edge h starts at `face_vertices[h]`, so `next` and `prev` are arithmetic; `twin`
/// comes from one sort. The mesh is an oriented 2-manifold with boundary.
class ControlMesh {
  public:
    ControlMesh() = default;

    /// Checks the data and builds the half-edges. O(H), parallel; the same mesh for any number of threads.
    /// @throws Error invalid_input: any fault that find_faults() (mesh_check.hpp) lists; the message quotes the first
    ///               few and counts the rest; memory_limit, cancelled
    static ControlMesh build(ControlMeshData data, const RunContext& context = {});

    std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(data_.positions.size()); }
    std::uint32_t face_count() const {
        return data_.face_offsets.empty() ? 0 : static_cast<std::uint32_t>(data_.face_offsets.size() - 1);
    }
    std::uint32_t halfedge_count() const { return static_cast<std::uint32_t>(data_.face_vertices.size()); }
    std::uint32_t edge_count() const { return static_cast<std::uint32_t>(edge_halfedge_.size()); }

    const ControlMeshData& data() const { return data_; }
    std::span<const Vec3d> positions() const { return data_.positions; }
    const Vec3d& position(VertexId v) const { return data_.positions[v.value]; }

    std::uint32_t face_size(FaceId f) const { return data_.face_offsets[f.value + 1] - data_.face_offsets[f.value]; }
    HalfedgeId face_halfedge(FaceId f) const { return HalfedgeId(data_.face_offsets[f.value]); }

    FaceId face(HalfedgeId h) const { return FaceId(halfedge_face_[h.value]); }
    VertexId origin(HalfedgeId h) const { return VertexId(data_.face_vertices[h.value]); }
    VertexId target(HalfedgeId h) const { return origin(next(h)); }
    HalfedgeId next(HalfedgeId h) const {
        const std::uint32_t f = halfedge_face_[h.value];
        return HalfedgeId(h.value + 1 == data_.face_offsets[f + 1] ? data_.face_offsets[f] : h.value + 1);
    }
    HalfedgeId prev(HalfedgeId h) const {
        const std::uint32_t f = halfedge_face_[h.value];
        return HalfedgeId(h.value == data_.face_offsets[f] ? data_.face_offsets[f + 1] - 1 : h.value - 1);
    }
    /// The opposite half-edge; invalid on the boundary.
    HalfedgeId twin(HalfedgeId h) const { return HalfedgeId(twin_[h.value]); }
    EdgeId edge(HalfedgeId h) const { return EdgeId(halfedge_edge_[h.value]); }
    /// The edge's half-edge with the smaller number.
    HalfedgeId edge_halfedge(EdgeId e) const { return HalfedgeId(edge_halfedge_[e.value]); }
    bool is_boundary(EdgeId e) const { return !twin(edge_halfedge(e)).valid(); }
    /// Whether any edge is on the boundary. O(edges)
    bool has_boundary() const;

    /// The half-edge from which ccw_outgoing() visits all faces around v. It leaves v; at a boundary vertex it has no
    /// twin. Invalid for an isolated vertex.
    HalfedgeId vertex_halfedge(VertexId v) const { return HalfedgeId(vertex_halfedge_[v.value]); }
    /// Next outgoing half-edge counter-clockwise around origin(h); invalid where the boundary ends the fan (the last
    /// boundary neighbour is then origin(prev(h))).
    HalfedgeId ccw_outgoing(HalfedgeId h) const { return twin(prev(h)); }
    /// Next outgoing half-edge clockwise; invalid at the boundary.
    HalfedgeId cw_outgoing(HalfedgeId h) const {
        const HalfedgeId t = twin(h);
        return t.valid() ? next(t) : HalfedgeId{};
    }
    bool is_boundary(VertexId v) const {
        const HalfedgeId h = vertex_halfedge(v);
        return h.valid() && !twin(h).valid();
    }
    bool is_isolated(VertexId v) const { return !vertex_halfedge(v).valid(); }
    /// Number of faces around v.
    std::uint32_t face_valence(VertexId v) const { return vertex_face_count_[v.value]; }
    /// Number of edges at v: face_valence, plus one at the boundary.
    std::uint32_t valence(VertexId v) const { return face_valence(v) + (is_boundary(v) ? 1 : 0); }

    /// Sharpness with the boundary rule applied: infinity for boundary edges and for tags of k_infinite_sharpness or
    /// more, else the tag. Rounded to float, as OpenSubdiv does.
    float sharpness(EdgeId e) const { return edge_sharpness_[e.value]; }
    /// As above; infinity at boundary vertices with a single face under BoundaryRule::edge_and_corner.
    float sharpness(VertexId v) const { return vertex_sharpness_[v.value]; }
    /// Tagged angle of the sector at origin(h) that contains face(h); 0 if there is no tag, or the vertex is no corner.
    double corner_angle(HalfedgeId h) const { return corner_angle_.empty() ? 0 : corner_angle_[h.value]; }
    bool has_corner_angles() const { return !corner_angle_.empty(); }
    /// Not part of the surface: tagged as a hole, or touching the boundary under BoundaryRule::none.
    bool is_hole(FaceId f) const { return hole_[f.value] != 0; }

    BoundaryRule boundary_rule() const { return data_.boundary_rule; }
    FaceVaryingRule face_varying_rule() const { return data_.face_varying_rule; }
    CreaseMethod crease_method() const { return data_.crease_method; }
    /// The box of all vertices that belong to a face; isolated ones are left out.
    Box3d bounding_box() const;
    bool has_uvs() const { return !data_.face_uvs.empty(); }
    std::uint32_t uv_index(HalfedgeId h) const { return data_.face_uvs[h.value]; }
    bool all_triangles() const { return all_triangles_; }

    /// Warnings met while reading or building (isolated vertices, zero-area faces, ...), one sentence each.
    const std::vector<std::string>& warnings() const { return warnings_; }

  private:
    friend class ControlMeshBuilder;
    ControlMeshData data_;
    std::vector<std::uint32_t> halfedge_face_, twin_, halfedge_edge_, edge_halfedge_;
    std::vector<std::uint32_t> vertex_halfedge_, vertex_face_count_;
    std::vector<float> edge_sharpness_, vertex_sharpness_;
    std::vector<double> corner_angle_;
    std::vector<std::uint8_t> hole_;
    std::vector<std::string> warnings_;
    bool all_triangles_ = false;
};

/// Infinite sharpness as the mesh stores it.
inline constexpr float k_sharpness_infinity = std::numeric_limits<float>::infinity();

}  // namespace tetrakis
