#pragma once

#include "../estimate/limit_estimator.hpp"
#include "shading_normals.hpp"
#include "tessellate.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// tessellate() for surfaces that are known by limit points alone.
namespace tetrakis::detail {

/// @throws Error  as tessellate(), with options that have been checked for what all schemes have in common
Tessellation tessellate_by_limits(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by limit points for schemes whose vertices are sites of corner cells (4-8 bisection) or of face
/// triangles (red-green quadtrees).
Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context);

/// tessellate() by limit points for dual schemes: vertices are the leaves of vertex quadtrees.
Tessellation tessellate_dual(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by limit points for the sqrt(3) scheme: triangles are the leaves of a Sqrt3Forest. Levels in options
/// and result are those of refine(), two simple steps each.
Tessellation tessellate_sqrt3(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by whole levels, for schemes that no hierarchy has (honeycomb): the first level of refine() that is
/// within the tolerance, its faces cut into triangles.
/// @param why_not_adaptive  for a warning, where a scheme's hierarchy cannot take the mesh
/// @throws Error  unsupported: the certified estimator, where that is so
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                                  const std::string& why_not_adaptive = {});

}  // namespace tetrakis::detail

/// What all ways to tessellate have in common: lengths from options, time, memory, progress.
namespace tetrakis::detail {

class Stopwatch {
  public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double seconds = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return seconds;
    }

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The course that every tessellation takes: refine, export; measure and mend until nothing is found that is off;
/// certify. A domain says how its leaves are refined, written as a mesh and measured.
class TessellationRun {
  public:
    TessellationRun(const TessellationRun&) = delete;
    TessellationRun& operator=(const TessellationRun&) = delete;
    virtual ~TessellationRun() = default;
    Tessellation run();

  protected:
    /// @param aim  share of the tolerance that errors by samples aim at; unless it is what limit points see
    TessellationRun(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                    std::optional<double> aim = {})
        : mesh_(mesh),
          options_(options),
          context_(context),
          sampled_aim_(aim.value_or(seen_share(options.scheme.info()))) {}
    bool certified() const { return options_.estimator == EstimatorKind::certified; }

    /// What refining needs. tolerance_ and aim_ are known.
    virtual void prepare() {}
    /// From the coarsest leaves on, until errors are within the aim or levels or budget end. Adds to estimate_seconds_.
    virtual void refine() = 0;
    /// The leaves as a mesh: positions, triangles, an error for each.
    virtual void export_mesh() = 0;
    /// Sets the measured error and the triangles' errors.
    virtual void measure() = 0;
    /// Whether what a measurement finds to be off may be split.
    virtual bool may_repair() const { return options_.max_triangles == 0 && !left_over(); }
    /// Splits what a measurement found above the tolerance; false where there is nothing to split.
    /// @param round  how many repairs there were before
    virtual bool repair(int round) = 0;
    /// Sets the certified error, where there is a bound.
    virtual void certify() {}
    /// All but materials and groups.
    virtual void add_attributes() = 0;
    /// Whether parts were left above the aim, for a level or a budget.
    virtual bool left_over() const = 0;

    /// @throws Error  unsupported: the result has more triangles than allowed, and is the coarsest one
    void check_coarsest() const;
    /// Gives each triangle corner its UV, three a triangle, and merges those of one vertex that are equal, bit for bit.
    void add_uvs(std::span<const Vec2d> corner_uvs);
    /// split_normals() of a result that has one normal a vertex, or none, and its triangles' control faces.
    void split_creases(const SideNormals& side = {});
    /// Says so where the control mesh is as fine as the tolerance asks: of a scheme that keeps its faces at level 0.
    void warn_of_fine_control_mesh();

    const ControlMesh& mesh_;
    const TessellateOptions& options_;
    const RunContext& context_;
    Tessellation result_;
    double tolerance_ = 0;  ///< as a length; 0: none
    double aim_ = 0;        ///< what refining aims at: the tolerance, or what rounding and sampling leave of it
    double off_above_ = 0;  ///< what measuring aims at: the tolerance, or what sampling leaves of it
    double estimate_seconds_ = 0;

  private:
    double tolerance_length() const;
    double aim_beside_rounding();
    double written_rounding() const;
    bool tolerance_reached() const;
    void add_face_attributes();

    double sampled_aim_;
};

}  // namespace tetrakis::detail
