#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../lattices/root_lattices.hpp"
#include "../rules/limit_point.hpp"
#include "../rules/rule_limit.hpp"
#include "../rules/rule_refiner.hpp"

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Levels of a mesh, made whole by the rules of its scheme, one after the other on demand. This is the general way to
/// the points of sites: of corner cells, of triangles, or of cells of vertex quadtrees (written as sites). Each level
/// takes four times the time and the memory of the level before.
///
/// Keeps references to the mesh, the scheme and the roots. All calls are safe from several threads.
class WholeLevels {
  public:
    /// @param roots    of a dual scheme; otherwise empty
    /// @param context  only its memory limit is used
    /// @throws Error  invalid_input: a mesh that the scheme cannot take
    WholeLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const VertexRoots& roots,
                const RunContext& context);

    struct Level {
        RuleStep step;  ///< step from the level before, with this level's mesh but without its stencils
        std::vector<Vec3d> points;
        std::vector<LimitPoint> limits;  ///< by vertex; valid where `has_limit` is not 0
        std::vector<char> has_limit;
        // Vertices by place of the lattices, and the argument `halfedge` of RootLattices::vertices().
        std::vector<int> vertex, corner;
    };
    /// @throws Error  invalid_input: the scheme cannot take the mesh; unsupported: the level is too large; memory_limit
    const Level& level(int level);
    /// Fills Level::limits of these vertices. The limit of a vertex does not depend on the other ones in the call.
    /// @throws Error  unsupported: the scheme has no limit mask for one of them
    void find_limits(int level, std::span<const int> vertices);
    /// The vertex of a level at a site of this level. The site must be written at its lowest level.
    int vertex(const Site& site, int level) const;

  private:
    void check_size(int level) const;
    const Level& make(int level);
    int lattice_level(int level) const;
    std::uint32_t segments(int level) const;
    void find_lattice(int level, const Level* above, Level& next);

    const ControlMesh& mesh_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    const VertexRoots& roots_;
    FanLattice lattice_;
    std::uint64_t max_memory_bytes_;
    ParallelBlocks runner_;
    std::optional<RootLattices> net_;  ///< set when the first level of lattices is made
    std::mutex mutex_;
    LimitSearch search_;
    std::array<std::unique_ptr<Level>, k_max_level + 2> levels_;
};

}  // namespace tetrakis::detail
