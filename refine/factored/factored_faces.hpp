#pragma once

#include "../../schemes/parts/face_split.hpp"
#include "factored_mesh.hpp"

#include <string>

namespace tetrakis::detail {

/// A family of factored schemes, which FactoredMesh uses. It works on the tetrakis mesh of the scheme's own mesh: a
/// centre in each face and, after the half-step that inserts them, a midpoint on each edge.
class FactoredFaces {
  public:
    virtual ~FactoredFaces() = default;

    void half_step() {
        check_room(halfedges(), done_, k_next);
        make_half_step();
    }
    virtual int half_steps_per_level() const { return 2; }
    /// Throws if one of the next `count` half-steps would throw for want of room, as far as counts tell.
    virtual void check_half_steps(int count) const;
    FactoredVertex state(std::uint32_t v) const { return state_[v]; }
    virtual std::vector<std::array<std::uint32_t, 3>> triangles() const;
    virtual PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const;
    virtual PolygonMesh active_mesh() const;

    std::span<const Vec3d> positions() const { return positions_; }
    void limit_memory(std::uint64_t bytes) { max_memory_bytes_ = bytes; }

  protected:
    static constexpr std::string_view k_next = "the next half-step";
    virtual void make_half_step() = 0;
    struct Room {
        std::uint64_t growth;  ///< largest number of half-edges that it makes of one
        std::uint64_t bytes;   ///< bytes per half-edge of the level at its start, with a mesh() of the result
    };
    /// The room that a half-step needs after `done` half-steps of the level.
    virtual Room room(int done) const = 0;
    /// Starts from the control mesh, without centres.
    explicit FactoredFaces(const ControlMesh& control);
    /// Inserts a centre in each face, at the mean of its corners.
    void put_centres();
    /// Numbers of the points of the split mesh: at vertices, then on edges, then in faces.
    std::vector<std::uint32_t> places() const;

    std::uint64_t halfedges() const { return static_cast<std::uint64_t>(mesh_.halfedge_count()); }
    /// A step makes four half-edges of one, more at creases and boundaries.
    static constexpr std::uint64_t k_growth = 4;
    /// Bytes per half-edge with its point, triangle and stencil row; the same for the half-edges of the next mesh.
    static constexpr std::uint64_t k_per_halfedge = 240, k_per_finer = k_growth * k_per_halfedge;
    /// @throws Error  unsupported
    static void check_halfedge_count(std::uint64_t halfedges, std::uint64_t growth, std::string_view which);

    std::uint32_t add(const Vec3d& p) {
        positions_.push_back(p);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }
    /// A mesh of polygons, whose vertex v is number vertex[v] of positions_.
    PolygonMesh polygons(const RuleMesh& faces, std::span<const std::uint32_t> vertex,
                         std::vector<std::uint32_t>* numbers = nullptr) const;
    PolygonMesh polygons(std::span<const std::array<std::uint32_t, 3>> triangles,
                         std::vector<std::uint32_t>* numbers) const;
    /// Adds the data of a face of mesh_ to a result; false if the result leaves the face out.
    virtual bool take(PolygonMesh& /*to*/, int /*face*/) const { return true; }
    virtual int face_of_triangle(std::size_t /*triangle*/) const { return 0; }

    void insert_midpoints();
    Vec3d mean_of_corners(int face) const;
    /// Moves each centre to the mean of the corners of its face.
    void rest_centres();
    /// Makes the split mesh the mesh of the next level, without centres.
    void take_split(const HalfSharpness& halves);
    void set_states(bool active_centres = false);

    std::vector<Vec3d> positions_;
    RuleMesh mesh_;
    std::vector<std::uint32_t> vertex_, centre_;  ///< numbers of the mesh's vertices and of its faces' centres
    std::vector<std::uint32_t> midpoint_;         ///< numbers of the edges' midpoints; empty until these are inserted
    std::vector<FactoredVertex> state_;
    int done_ = 0;       ///< half-steps of this level
    bool whole_ = true;  ///< whether the mesh's edges are edges of the 4-8 mesh: not after a dual step

  private:
    /// @throws Error  unsupported, memory_limit
    void check_room(std::uint64_t halfedges, int done, std::string_view which) const;

    std::uint64_t max_memory_bytes_ = 0;
};

std::unique_ptr<FactoredFaces> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredFaces> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredFaces> make_factored_averaging(const ControlMesh& mesh, const RuleOptions& rules);

}  // namespace tetrakis::detail
