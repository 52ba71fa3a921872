#pragma once

#include "../../refine/attributes/uv_mesh.hpp"
#include "../estimate/limit_estimator.hpp"
#include "shading_normals.hpp"
#include "tessellate.hpp"

#include <chrono>
#include <optional>
#include <span>
#include <string>

namespace tetrakis::detail {

/// tessellate() for surfaces without patches, of which only limit points are known. Expects options that tessellate()
/// has checked, except for limits of the scheme. @throws Error  as tessellate()
Tessellation tessellate_by_limits(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by limit points for schemes whose vertices are sites of corner cells (4-8 bisection) or of face
/// triangles (red-green quadtrees, sqrt(3) forests: levels in options and result are those of refine(), two simple
/// steps each).
Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context);

/// tessellate() by limit points for dual schemes: vertices are the leaves of vertex quadtrees.
Tessellation tessellate_dual(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by whole levels, for schemes without a hierarchy (honeycomb): the first level of refine() that is
/// within the tolerance, its faces cut into triangles.
/// @param why_not_adaptive  text of a warning, if the scheme's hierarchy cannot take this mesh; else empty
/// @throws Error  unsupported: the certified estimator, if `why_not_adaptive` is not empty
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                                  const std::string& why_not_adaptive = {});

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

/// The steps of every tessellation: refine; export; measure and repair until no error above the tolerance is found;
/// certify. A derived class refines its kind of leaves, exports them as a mesh and measures it.
class TessellationRun {
  public:
    TessellationRun(const TessellationRun&) = delete;
    TessellationRun& operator=(const TessellationRun&) = delete;
    virtual ~TessellationRun() = default;
    Tessellation run();

  protected:
    /// @param aim  share of the tolerance that sampled errors must keep within; by default seen_share() of the scheme
    TessellationRun(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                    std::optional<double> aim = {})
        : mesh_(mesh),
          options_(options),
          context_(context),
          sampled_aim_(aim.value_or(seen_share(options.scheme.info()))) {}
    bool certified() const { return options_.estimator == EstimatorKind::certified; }

    /// Builds the data for refine(). tolerance_ and aim_ are set before.
    virtual void prepare() {}
    /// Refines the coarsest leaves until errors are within aim_, or levels or budget end; adds to estimate_seconds_.
    virtual void refine() = 0;
    /// Writes the leaves as a mesh into result_: positions, triangles, an error for each triangle.
    virtual void export_mesh() = 0;
    /// Sets the measured error of result_ and the errors of its triangles.
    virtual void measure() = 0;
    /// Whether triangles that a measurement finds above the tolerance may be split.
    virtual bool may_repair() const { return options_.max_triangles == 0 && !left_over(); }
    /// Splits triangles that a measurement found above the tolerance; returns false if none can be split.
    /// @param round  number of repairs before this one
    virtual bool repair(int round) = 0;
    /// Sets the certified error, if there is a bound.
    virtual void certify() {}
    /// Adds all attributes but materials and groups.
    virtual void add_attributes() = 0;
    /// Whether errors above aim_ remain, because the maximum level or the budget was reached.
    virtual bool left_over() const = 0;

    /// @throws Error  unsupported: more triangles than max_triangles, which only the coarsest mesh can have
    void check_coarsest() const;
    /// Sets the UVs of triangle corners, three a triangle.
    void add_uvs(FaceUvs from);
    /// split_normals() of result_, whose normals are one a vertex, or none, and whose triangle_face is set.
    void split_creases(const SideNormals& side = {});
    /// Adds a warning if the control mesh's own faces are within the tolerance. For schemes that keep them at level 0.
    void warn_of_fine_control_mesh();

    const ControlMesh& mesh_;
    const TessellateOptions& options_;
    const RunContext& context_;
    Tessellation result_;
    double tolerance_ = 0;  ///< as a length; 0: none
    double aim_ = 0;        ///< largest error after refining: the tolerance less room for rounding and sampling
    double off_above_ = 0;  ///< largest measured error that is not repaired: the tolerance less room for sampling
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
