#pragma once

#include "../../schemes/core/rule_mesh.hpp"
#include "factored_mesh.hpp"

#include <string>

namespace tetrakis::detail {

/// A family of factored schemes behind FactoredMesh, on the tetrakis mesh of a scheme's own mesh: a centre in each face
/// and, after the half-step for them, a midpoint on each edge.
class FactoredFaces {
  public:
    virtual ~FactoredFaces() = default;

    virtual void half_step() = 0;
    virtual int half_steps_per_level() const { return 2; }
    /// What half_step() would throw for want of room in one of the next `count`, as far as counts tell.
    virtual void check_half_steps(int count) const = 0;
    virtual FactoredVertex state(std::uint32_t v) const { return state_[v]; }
    virtual std::vector<std::array<std::uint32_t, 3>> triangles() const;
    virtual PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const;
    virtual PolygonMesh active_mesh() const;

    std::span<const Vec3d> positions() const { return positions_; }
    void limit_memory(std::uint64_t bytes) { max_memory_bytes_ = bytes; }

  protected:
    static constexpr std::string_view k_next = "the next half-step";
    /// How check_half_steps() names one of them.
    static std::string half_step_of(int i, int count) {
        return "half-step " + std::to_string(i + 1) + " of " + std::to_string(count);
    }
    /// @param which  the half-step
    /// @throws Error  memory_limit: what the half-step and a mesh() of it take together is more than the limit
    void check_memory(std::uint64_t bytes, std::string_view which) const;
    /// Without centres.
    explicit FactoredFaces(const ControlMesh& control);
    /// Into all faces, where they rest.
    void put_centres();
    /// Numbers of the split's points: at vertices, edges and faces.
    std::vector<std::uint32_t> places() const;

    std::uint64_t halfedges() const { return static_cast<std::uint64_t>(mesh_.halfedge_count()); }
    /// A step makes four half-edges of one, and more at creases and boundaries.
    static constexpr std::uint64_t k_growth = 4;
    /// @param halfedges  of the mesh that the half-step starts from
    /// @param finer      it makes the next mesh
    /// @throws Error  memory_limit
    void check_halfedge_memory(std::uint64_t halfedges, bool finer, std::string_view which) const;
    /// @param growth  half-edges that the half-step makes of one, at most
    /// @throws Error  unsupported
    static void check_halfedge_count(std::uint64_t halfedges, std::uint64_t growth, std::string_view which);

    std::uint32_t add(const Vec3d& p) {
        positions_.push_back(p);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }
    /// Faces of positions_ as a mesh.
    PolygonMesh polygons(const RuleMesh& faces, std::span<const std::uint32_t> vertex) const;
    PolygonMesh polygons(std::span<const std::array<std::uint32_t, 3>> triangles,
                         std::vector<std::uint32_t>* numbers) const;

    void insert_midpoints();
    /// Centres rest at the mean of the corners around them.
    void rest_centres();
    void set_states();

    std::vector<Vec3d> positions_;
    RuleMesh mesh_;
    std::vector<std::uint32_t> vertex_, centre_;  ///< numbers of the mesh's vertices and of its faces' centres
    std::vector<std::uint32_t> midpoint_;         ///< of edges; empty until the half-step that makes them
    std::vector<FactoredVertex> state_;
    bool whole_ = true;  ///< the mesh's edges are edges of the 4-8 mesh: not after a dual step

  private:
    std::uint64_t max_memory_bytes_ = 0;
};

std::unique_ptr<FactoredFaces> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredFaces> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredFaces> make_factored_averaging(const ControlMesh& mesh, const RuleOptions& rules);

}  // namespace tetrakis::detail
