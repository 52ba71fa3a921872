#pragma once

#include "../../hier/base/vec.hpp"
#include "hexagon_mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace tetrakis::detail {

/// What is around the vertices of a level of honeycomb refinement: limits and normals.
class HexagonFans {
  public:
    /// @param mesh  must live as long, where it is; made for limits
    explicit HexagonFans(const HexagonMesh& mesh);

    /// Whether a vertex has the surroundings that every smooth one has after two steps. Its limit can be asked for
    /// then.
    bool is_plain(std::uint32_t v) const;
    /// Before the limits of plain vertices with that many edges are asked for, on any thread.
    void need_weights(std::size_t valence);
    /// Nothing where the vertex is not plain.
    /// @param net  the level's points
    std::optional<Vec3d> limit(std::uint32_t v, const Vec3d* net) const;
    /// The limit of any vertex that is not tagged, from the level after the next, where it is plain: that part of both
    /// is made for it. Needs its weights, too.
    Vec3d limit_below(std::uint32_t v, const Vec3d* net) const;
    /// From the faces: the scheme has no tangents.
    Vec3d normal(std::uint32_t v, const Vec3d* net) const;

    const std::vector<std::uint32_t>& face_of() const { return face_of_; }
    bool is_tagged(std::uint32_t v) const { return tagged_[v] != 0; }

  private:
    template <class Visit>
    bool walk(std::uint32_t v, Visit&& visit) const;
    Vec3d moved(std::uint32_t v, const Vec3d* net) const;
    void points_of(std::uint32_t face, const Vec3d* net, std::vector<Vec3d>& points) const;

    const HexagonMesh& mesh_;
    std::vector<std::uint32_t> face_of_;        ///< by half-edge
    std::vector<char> tagged_;                  ///< by vertex
    std::vector<std::vector<double>> weights_;  ///< of the limit, by valence
};

}  // namespace tetrakis::detail
