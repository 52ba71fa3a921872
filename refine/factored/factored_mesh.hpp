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

/// The schemes that run as binary half-steps on the 4-8 mesh; their names are those of scheme_table().
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
/// The scheme of that name; empty where there is none, or it has no factored form.
std::optional<FactoredScheme> factored_scheme_from_name(std::string_view name);
/// Whether AdaptiveFactoredMesh takes the scheme: Catmull-Clark, Doo-Sabin and midedge.
bool half_steps_adapt(FactoredScheme scheme);

/// What a vertex of the 4-8 mesh is at the moment.
enum class FactoredVertex : std::uint8_t {
    active,    ///< a point of the scheme: the next points are made from it
    inactive,  ///< the centre of a block: it rests at the mean of the block's corners, and no point depends on it but
               ///< through that mean
    unused,    ///< no triangle has it
};

/// A scheme in binary steps (Velho; refine/README.md): each half-step cuts the blocks of a 4-8 mesh at their
/// centres, and two (of repeated averaging: two more than averagings) give the classical step's points to rounding
/// error. Every mesh on the way is a conforming triangle mesh. A vertex keeps its number for ever, also when it becomes
/// inactive.
///
/// Primal schemes (catmull-clark, 4-8) start from the control faces. Half-steps 1, 3, ... put a point into every face
/// and move the old vertices (face and corner rule); half-steps 2, 4, ... put one on every edge (edge rule), which for
/// Catmull-Clark still uses the corners as they were before they moved: they are kept until then. 4-8 averages in both
/// half-steps alike; on other faces than quads it starts from the tetrakis mesh (faces cut from their centres, blocks
/// across the edges), whose first half-step is one that cuts edges. All vertices are active.
///
/// Dual schemes start from the tetrakis mesh, whose centres are inactive. Half-steps 1, 3, ... put the midpoint on
/// every edge between active vertices, half-steps 2, 4, ... the new points between each old corner and the centre of
/// its block. Then only these are active; old vertices, midpoints and centres stay as the centres of their faces. The
/// sides of the new faces are not edges of the mesh yet: the next half-step puts them in, with their midpoints. At a
/// boundary, half a cell is added outside of the old one; a crease is a boundary on each side. An inner vertex between
/// two faces alone is no centre of a face, and is unused afterwards.
///
/// Repeated averaging of m steps has m + 2 half-steps in a level. It starts like a dual scheme: the first half-step
/// makes the centres points, the second puts the midpoints on the edges, and all are active. Each of the others is an
/// averaging, from the corners of a face to its centre: the first puts a point into every quad of the split mesh, the
/// next puts those of the split mesh's vertices between them, and so on. After an odd number of averagings only the
/// points in the quads are active, the vertices being the centres of the dual faces (whose sides are not edges yet
/// inside the mesh); after an even number only the vertices, with the quads' points as their centres. Copies of the
/// boundary (AveragingBoundary::replicate) lie on their vertices until the first averaging, and then around the mesh
/// until the level is done: triangles() has them, mesh() has not. Two steps take Catmull-Clark's rules at boundaries,
/// creases and corners in the last half-step. With AveragingBoundary::recede the outer faces go as their points do
/// (between averagings some may touch in a vertex alone).
///
/// Tags act when a point that follows them is made: Catmull-Clark's blends of smooth, crease and corner rules for old
/// vertices in the first half-step, for new points on edges in the second, dual boundary and crease points (and tagged
/// corners) in the second. Sharpness goes down once per level.
///
/// Positions only: no UVs. Catmull-Clark and 4-8 leave holes out of mesh() and take materials and groups along; for the
/// others holes are faces.
class FactoredMesh {
  public:
    /// @param mesh              control mesh; is not kept beyond the call
    /// @param max_memory_bytes  what the meshes may take, as half_step() estimates it; 0: no limit
    /// @param rules             averaging: averaging_steps and averaging_boundary; biquartic: averaging_boundary
    /// @throws Error  invalid_input: averaging_steps < 0
    FactoredMesh(const ControlMesh& mesh, FactoredScheme scheme, std::uint64_t max_memory_bytes = 0,
                 const RuleOptions& rules = {});
    ~FactoredMesh();
    FactoredMesh(FactoredMesh&&) noexcept;
    FactoredMesh& operator=(FactoredMesh&&) noexcept;

    /// One more half-step. Cost: O(triangles), primal schemes in parallel; the same bytes for any number of threads.
    /// @throws Error  unsupported: more elements than can be counted; memory_limit; invalid_input: AveragingBoundary::
    ///                recede would use up the whole mesh in this level; the mesh is then as it was
    void half_step();
    /// Whether so many more will find room, before any of them is made: by the counts that follow from those of now.
    /// Where creases and boundaries add elements, half_step() may find a little more; where a boundary recedes, only
    /// the next half-step is looked at.
    /// @throws Error  unsupported, memory_limit, as the first half_step() that has no room would
    void check_half_steps(int count) const;
    int half_steps() const;
    int half_steps_per_level() const;  ///< that make a step of the scheme

    std::span<const Vec3d> positions() const;  ///< of all vertices
    FactoredVertex state(std::uint32_t vertex) const;
    /// The 4-8 mesh: vertex numbers, counter-clockwise. Empty as long as a primal scheme is at the control faces.
    std::vector<std::array<std::uint32_t, 3>> triangles() const;

    /// The 4-8 mesh for use, vertices renumbered without the unused ones; as long as a primal scheme is at its control
    /// faces, these.
    /// @param numbers  receives the number here (state()) of each vertex of the result, in increasing order
    PolygonMesh mesh(std::vector<std::uint32_t>* numbers = nullptr) const;
    /// The scheme's own mesh, of the last whole step.
    PolygonMesh active_mesh() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
