#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_options.hpp"
#include "../rules/polygon_mesh.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace tetrakis {

/// Schemes that run as half-steps (binary steps) on the 4-8 mesh; their names are those of scheme_table().
enum class FactoredScheme {
    catmull_clark,
    four_eight,
    doo_sabin,
    doo_sabin_catmull_clark,
    midedge,
    midedge_simplest,
    averaging,
    biquartic,
};
std::span<const FactoredScheme> factored_schemes();
std::string_view name(FactoredScheme scheme);
/// The scheme of that name; empty if there is none, or if it has no factored form.
std::optional<FactoredScheme> factored_scheme_from_name(std::string_view name);
/// Whether AdaptiveFactoredMesh supports the scheme: Catmull-Clark and all forms of Doo-Sabin and midedge do.
bool half_steps_adapt(FactoredScheme scheme);

/// The present role of a vertex of the 4-8 mesh.
enum class FactoredVertex : std::uint8_t {
    active,    ///< a point of the scheme: the points of the next steps depend on it
    inactive,  ///< the centre of a block, at the mean of the block's corners; other points use it only as this mean
    unused,    ///< no triangle has it
};

/// A scheme in half-steps (Velho; refine/README.md). Each half-step cuts the blocks of a 4-8 mesh at their centres. Two
/// half-steps give the points of the classical step to rounding error (repeated averaging: two more than averagings).
/// Every mesh on the way is a conforming triangle mesh. A vertex always keeps its number, also when it becomes
/// inactive.
///
/// Primal schemes (catmull-clark, 4-8) start from the control faces. Half-steps 1, 3, ... insert a point in each face
/// and move the old vertices (face and corner rule). Half-steps 2, 4, ... insert a point on each edge (edge rule); for
/// Catmull-Clark this rule needs the vertices before they moved, which are stored until then. 4-8 averages in both
/// half-steps alike. If it has faces other than quads, it starts from the tetrakis mesh (faces cut from their centres,
/// blocks across the edges), and the first half-step cuts edges. All vertices are active.
///
/// Dual schemes start from the tetrakis mesh, whose centres are inactive. Half-steps 1, 3, ... insert the midpoint of
/// each edge between active vertices. Half-steps 2, 4, ... insert the new points, each between an old corner and the
/// centre of its block. Then only these are active; old vertices, midpoints and centres remain as the centres of their
/// faces. The sides of the new faces are not edges of the mesh yet: the next half-step inserts them with their
/// midpoints. At a boundary, half a cell is added outside of the old one; a crease is a boundary on each side. An
/// interior vertex between only two faces is no centre of a face, so it is unused afterwards.
///
/// Repeated averaging of m steps has m + 2 half-steps in a level. It starts like a dual scheme: the first half-step
/// turns the centres into points, the second inserts the midpoints of edges, and all vertices are active. Each further
/// half-step is an averaging, from the corners of a face to its centre. The first averaging makes a point for each quad
/// of the split mesh, the second one for each vertex of the split mesh, and so on. After an odd number of averagings
/// only the points in the quads are active; the vertices are the centres of the dual faces, whose interior sides are
/// not edges yet. After an even number only the vertices are active, and the quads' points are their centres. Copies of
/// the boundary (AveragingBoundary::replicate) lie on their vertices until the first averaging, then around the mesh
/// until the level is complete: triangles() includes them, mesh() does not. For m = 2, boundaries, creases and corners
/// follow Catmull-Clark's rules in the last half-step. With AveragingBoundary::recede the outer faces vanish together
/// with their points; between averagings some faces may touch in a vertex only.
///
/// Tags act when a point that follows them is made. Catmull-Clark: blends of smooth, crease and corner rules in the
/// first half-step for old vertices, in the second for new points on edges. Dual schemes: boundary and crease points
/// (and tagged corners) in the second. Sharpness decreases once per level.
///
/// There are positions only, no UVs. Catmull-Clark and 4-8 leave holes out of mesh() and keep materials and groups; for
/// the other schemes holes are faces.
class FactoredMesh {
  public:
    /// @param mesh              control mesh; it is not used after the call
    /// @param max_memory_bytes  limit for the meshes, as half_step() estimates them; 0: no limit
    /// @param rules             averaging: averaging_steps and averaging_boundary; biquartic: averaging_boundary
    /// @throws Error  invalid_input: averaging_steps is not from 0 to 64; unsupported: too many elements
    FactoredMesh(const ControlMesh& mesh, FactoredScheme scheme, std::uint64_t max_memory_bytes = 0,
                 const RuleOptions& rules = {});
    ~FactoredMesh();
    FactoredMesh(FactoredMesh&&) noexcept;
    FactoredMesh& operator=(FactoredMesh&&) noexcept;

    /// One more half-step. Cost: O(triangles), primal schemes in parallel; the same bytes for any number of threads.
    /// @throws Error  unsupported: more elements than can be counted; memory_limit; invalid_input:
    ///                AveragingBoundary::recede would use up the whole mesh in this level. The mesh is then unchanged
    void half_step();
    /// Checks whether `count` more half-steps fit, before any of them is made, from the counts of elements now. Creases
    /// and boundaries add elements, so half_step() may need a little more. If a boundary recedes, only the next
    /// half-step is checked.
    /// @throws Error  unsupported, memory_limit, as the first half_step() that does not fit would
    void check_half_steps(int count) const;
    int half_steps() const;
    int half_steps_per_level() const;  ///< half-steps in one step of the scheme

    std::span<const Vec3d> positions() const;  ///< positions of all vertices
    FactoredVertex state(std::uint32_t vertex) const;
    /// The 4-8 mesh: vertex numbers, counter-clockwise. Empty while a primal scheme is at its control faces.
    std::vector<std::array<std::uint32_t, 3>> triangles() const;

    /// The 4-8 mesh for output: unused vertices are left out, and the others renumbered. While a primal scheme is at
    /// its control faces, the mesh of these.
    /// @param numbers  receives, for each vertex of the result, its number here (see state()), in increasing order
    PolygonMesh mesh(std::vector<std::uint32_t>* numbers = nullptr) const;
    /// The scheme's own mesh after the last complete step.
    PolygonMesh active_mesh() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
