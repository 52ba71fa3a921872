#pragma once

#include "../../schemes/core/rule_mesh.hpp"
#include "factored_steps.hpp"

namespace tetrakis::detail {

/// Factored schemes on the tetrakis mesh of a scheme's own mesh: a centre in each face and, after the half-step for
/// them, a midpoint on each edge.
class FactoredFaces : public FactoredSteps {
  public:
    FactoredVertex state(std::uint32_t v) const override { return state_[v]; }
    std::vector<std::array<std::uint32_t, 3>> triangles() const override;
    PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const override;
    PolygonMesh active_mesh() const override;

  protected:
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
    static void check_halfedge_count(std::uint64_t halfedges, std::uint64_t growth, std::string_view which) {
        if (halfedges > k_most_halfedges / growth) refuse_count(halfedges * growth, 31, which);
    }

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

    static constexpr std::uint32_t k_most_halfedges = 0x7FFF'FFFF;  // RuleMesh counts with int

    RuleMesh mesh_;
    std::vector<std::uint32_t> vertex_, centre_;  ///< numbers of the mesh's vertices and of its faces' centres
    std::vector<std::uint32_t> midpoint_;         ///< of edges; empty until the half-step that makes them
    std::vector<FactoredVertex> state_;
    bool whole_ = true;  ///< the mesh's edges are edges of the 4-8 mesh: not after a dual step
};

}  // namespace tetrakis::detail
