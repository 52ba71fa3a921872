#pragma once

#include "../../schemes/parts/face_split.hpp"
#include "factored_mesh.hpp"

#include <string>

namespace tetrakis::detail {

/// A family of factored schemes behind FactoredMesh, on the tetrakis mesh of a scheme's own mesh: a centre in each face
/// and, after the half-step for them, a midpoint on each edge.
class FactoredFaces {
  public:
    virtual ~FactoredFaces() = default;

    void half_step() {
        check_room(halfedges(), done_, k_next);
        make_half_step();
    }
    virtual int half_steps_per_level() const { return 2; }
    /// What half_step() would throw for want of room in one of the next `count`, as far as counts tell.
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
        std::uint64_t growth;  ///< half-edges that it makes of one, at most
        std::uint64_t bytes;   ///< for each half-edge that the level began with, with a mesh() of it
    };
    /// What the half-step after `done` ones of a level takes.
    virtual Room room(int done) const = 0;
    /// Without centres.
    explicit FactoredFaces(const ControlMesh& control);
    /// Into all faces, where they rest.
    void put_centres();
    /// Numbers of the split's points: at vertices, edges and faces.
    std::vector<std::uint32_t> places() const;

    std::uint64_t halfedges() const { return static_cast<std::uint64_t>(mesh_.halfedge_count()); }
    /// A step makes four half-edges of one, and more at creases and boundaries.
    static constexpr std::uint64_t k_growth = 4;
    /// Bytes for each with its point, triangle and stencil row; for those of the next mesh.
    static constexpr std::uint64_t k_per_halfedge = 240, k_per_finer = k_growth * k_per_halfedge;
    /// @throws Error  unsupported
    static void check_halfedge_count(std::uint64_t halfedges, std::uint64_t growth, std::string_view which);

    std::uint32_t add(const Vec3d& p) {
        positions_.push_back(p);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }
    /// Faces of positions_ as a mesh.
    PolygonMesh polygons(const RuleMesh& faces, std::span<const std::uint32_t> vertex,
                         std::vector<std::uint32_t>* numbers = nullptr) const;
    PolygonMesh polygons(std::span<const std::array<std::uint32_t, 3>> triangles,
                         std::vector<std::uint32_t>* numbers) const;
    /// Takes along what belongs to a face of mesh_; false where it is none of the mesh that is made.
    virtual bool take(PolygonMesh& /*to*/, int /*face*/) const { return true; }
    virtual int face_of_triangle(std::size_t /*triangle*/) const { return 0; }

    void insert_midpoints();
    Vec3d mean_of_corners(int face) const;
    /// Centres rest at the mean of the corners around them.
    void rest_centres();
    /// The split mesh is the next level's, without centres.
    void take_split(const HalfSharpness& halves);
    void set_states(bool active_centres = false);

    std::vector<Vec3d> positions_;
    RuleMesh mesh_;
    std::vector<std::uint32_t> vertex_, centre_;  ///< numbers of the mesh's vertices and of its faces' centres
    std::vector<std::uint32_t> midpoint_;         ///< of edges; empty until the half-step that makes them
    std::vector<FactoredVertex> state_;
    int done_ = 0;       ///< half-steps of this level
    bool whole_ = true;  ///< the mesh's edges are edges of the 4-8 mesh: not after a dual step

  private:
    /// @throws Error  unsupported, memory_limit
    void check_room(std::uint64_t halfedges, int done, std::string_view which) const;

    std::uint64_t max_memory_bytes_ = 0;
};

std::unique_ptr<FactoredFaces> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredFaces> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredFaces> make_factored_averaging(const ControlMesh& mesh, const RuleOptions& rules);

}  // namespace tetrakis::detail
