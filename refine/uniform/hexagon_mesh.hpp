#pragma once

#include "../../hier/base/vec.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "root_net.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Corners of the faces that honeycomb refinement makes.
inline constexpr std::uint32_t k_hexagon_size = 6, k_pentagon_size = 5;

/// A level of honeycomb refinement (honeycomb_step()) as flat arrays. Those of the next level follow from them by
/// arithmetic, half-edge by half-edge (in the manner of the half-edge refinement rule of Dupuy, Vanhoey 2021), and so
/// do its points: no rows of weights are made and nothing is searched. Vertices, faces and half-edges have the numbers
/// that the rules give them.
///
/// Lattices, as other schemes have them, would be the triangles of the dual mesh. But around a vertex with another
/// number of edges than three new ones would begin at every level.
class HexagonMesh {
  public:
    static constexpr std::uint32_t none = UINT32_MAX;
    /// What a next level is made for.
    enum class Use {
        levels,  ///< to be refined
        limits,  ///< limits and normals of its vertices
        faces,   ///< its faces alone: it has no twins and fans
    };

    /// @param control_face  of each face
    HexagonMesh(const RuleMesh& mesh, std::vector<std::uint32_t> control_face);

    /// The next level. Its half-edges must be fewer than 2^30.
    HexagonMesh finer(Use use) const;
    /// Its points, one for each of its vertices.
    void refine(const Vec3d* points, Vec3d* finer) const;
    /// The new corners of a face alone, from its points: as many as it has.
    void refine_face(std::span<const Vec3d> points, Vec3d* corners) const;
    /// The new corner of a face that is its number i.
    Vec3d refine_corner(std::span<const Vec3d> points, std::size_t i) const;

    std::uint32_t vertex_count() const { return vertex_count_; }
    std::uint32_t face_count() const { return static_cast<std::uint32_t>(face_begin_.size() - 1); }
    std::uint32_t halfedge_count() const { return static_cast<std::uint32_t>(origin_.size()); }

    std::uint32_t face_begin(std::uint32_t f) const { return face_begin_[f]; }
    std::uint32_t face_size(std::uint32_t f) const { return face_begin_[f + 1] - face_begin_[f]; }
    std::uint32_t origin(std::uint32_t h) const { return origin_[h]; }
    std::uint32_t twin(std::uint32_t h) const { return twin_[h]; }
    /// The face of a half-edge. O(log faces)
    std::uint32_t face(std::uint32_t h) const;
    std::uint32_t next(std::uint32_t h) const { return next_in(face(h), h); }
    std::uint32_t prev(std::uint32_t h) const { return prev_in(face(h), h); }
    /// The half-edges that leave a vertex, counter-clockwise: from the boundary on, or from the first of them.
    std::span<const std::uint32_t> leaving(std::uint32_t v) const {
        return {leaving_.data() + leaving_begin_[v], leaving_.data() + leaving_begin_[v + 1]};
    }
    const std::vector<std::uint32_t>& face_begins() const { return face_begin_; }
    const std::vector<std::uint32_t>& origins() const { return origin_; }
    const std::vector<std::uint32_t>& control_faces() const { return control_face_; }
    /// Its faces, given away.
    RootNet::Faces take_faces() { return {std::move(face_begin_), std::move(origin_), std::move(control_face_)}; }

    /// An edge (its first half-edge) or vertex that is sharp. Boundary edges are.
    struct Sharp {
        std::uint32_t number;
        float sharpness;
    };
    std::span<const Sharp> sharp_edges() const { return sharp_edges_; }        ///< ascending
    std::span<const Sharp> sharp_vertices() const { return sharp_vertices_; }  ///< ascending
    /// A vertex that is sharp or has sharp edges.
    struct Tagged {
        std::uint32_t vertex;
        VertexRule rule;
        bool semi_sharp;        ///< the vertex or one of the edges
        std::uint32_t ends[2];  ///< a crease's, beyond its two edges
    };
    std::span<const Tagged> tagged() const { return tagged_; }  ///< ascending

  private:
    HexagonMesh() = default;
    std::uint32_t next_in(std::uint32_t f, std::uint32_t h) const {
        return h + 1 < face_begin_[f + 1] ? h + 1 : face_begin_[f];
    }
    std::uint32_t prev_in(std::uint32_t f, std::uint32_t h) const {
        return h > face_begin_[f] ? h - 1 : face_begin_[f + 1] - 1;
    }
    void find_tagged();
    std::vector<std::uint32_t> add_polygons(HexagonMesh& fine) const;
    void set_leaving(std::span<const std::uint32_t> polygon, HexagonMesh& fine) const;

    std::uint32_t vertex_count_ = 0;
    std::vector<std::uint32_t> face_begin_{0}, origin_, twin_, leaving_begin_, leaving_, control_face_;
    std::vector<Sharp> sharp_edges_, sharp_vertices_;
    std::vector<Tagged> tagged_;
    /// Cosine and sine of the corners' turns, by the size of a face.
    using Turns = std::map<std::uint32_t, std::vector<std::pair<double, double>>>;
    std::shared_ptr<const Turns> turns_;
};

}  // namespace tetrakis::detail
