#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../distance/hausdorff.hpp"
#include "../surface/scheme_choice.hpp"
#include "../surface/triangle_mesh.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace tetrakis {

struct HeightImage;  // eval/surface/height_image.hpp

/// Which estimator decides where to refine (eval/README.md, Errors).
enum class EstimatorKind {
    /// Cheap two-sided filters, then closest points and normal rays against the limit surface or a target. Of surfaces
    /// without patches: the limit points that each triangle's edges and inside have one and two levels further down.
    measured,
    certified,  ///< refines until the certified bound itself is within the tolerance
};

/// What tessellate() can do with a scheme.
struct SchemeSupport {
    bool adaptive = false;  ///< refined where that is needed; else by whole levels of refine(), as honeycomb
    /// Patches, exact anywhere: targets and displacements, and what is measured is measured against the surface itself;
    /// else against a mesh of limit points that cuts the result's triangles in 16 or more (in 4 above 250 000 of them).
    bool patches = false;
    bool certified = false;  ///< bounds that hold for every point
};
/// Patches: Catmull-Clark and Loop by their plain rules. Certified: these by any rules; bilinear and midpoint;
/// Doo-Sabin and midedge; tuned Loop, Butterfly, Kobbelt, 4-8 and even averaging, unless a tag stays semi-sharp for
/// more than 6 levels. By whole levels: honeycomb refinement, whose texture coordinates are those of the level's net.
SchemeSupport scheme_support(const SchemeChoice& scheme, const RuleOptions& rules = {});
/// With such a mesh: there are no patches for corners with angles of their own.
SchemeSupport scheme_support(const ControlMesh& mesh, const SchemeChoice& scheme, const RuleOptions& rules = {});

struct TessellateOptions {
    SchemeChoice scheme = SchemeKind::catmull_clark;  ///< see scheme_support()
    RuleOptions rules{};                              ///< choices that the scheme's rules offer
    EstimatorKind estimator = EstimatorKind::measured;
    /// Largest allowed distance between mesh and limit surface, in both directions. Unset: refine to max_triangles, or
    /// until no distance is above rounding.
    std::optional<double> tolerance{};
    bool tolerance_is_absolute = false;  ///< else relative to the diagonal of the control mesh's bounding_box()
    /// 0: no limit; else the best mesh within it, largest errors first. The coarsest mesh, which has all corners of the
    /// control mesh, must fit.
    std::uint64_t max_triangles = 0;
    /// Quadtree levels that every face gets (sqrt3: levels of refine()); max_triangles must have room for them.
    int min_level = 0;
    int max_level = 28;  ///< no cell is refined beyond it
    /// Project vertices onto this mesh and measure against it, in both directions: where it reaches beyond what the
    /// control mesh covers, the tolerance is not met, and a warning says so.
    const TriangleMesh* target = nullptr;
    const HeightImage* displacement = nullptr;  ///< heights in [0, 1] by UV, along the limit normal
    double amplitude = 0;                       ///< height 1 in the unit of the model
    bool normals = true;                        ///< compute limit normals
    /// Vertices are split for shading, in TriangleMesh::triangle_normals alone, where a limit normal is farther than
    /// this off its triangle, as on roundings tighter than the tolerance. At infinitely sharp edges they always are.
    double crease_degrees = 30;
    bool uvs = true;  ///< carry the UV layer over, where there is one
    /// Measure the result at the end (symmetric Hausdorff, mean, RMS); with the measured estimator what is found to be
    /// off the tolerance is split and measured again, local maxima between the samples included. Takes one to five
    /// times as long as tessellating. A target that reaches beyond the mesh is found by this alone.
    bool measure = false;
    /// Samples that measuring aims at, each way: a lattice on every triangle, of at least 3 and at most 24 intervals a
    /// side (some 300 points). Against limit points, half as many, spread as compare() does.
    std::uint64_t measure_samples = 100'000;
    bool floats_written = false;  ///< the caller writes floats (GLB): certified_error then includes that rounding
};

struct StageSeconds {
    double load = 0, build = 0, refine = 0, estimate = 0, measure = 0, write = 0;
};

struct Tessellation {
    TriangleMesh mesh;
    std::vector<std::uint32_t> triangle_face;  ///< T: the control face each triangle comes from
    std::vector<float> triangle_error;         ///< T: of each triangle, measured or else estimated, unit of the model
    double tolerance_absolute = std::numeric_limits<double>::infinity();
    /// No estimate is above the tolerance, and neither is what was measured and what the certified estimator certifies
    /// (by that one, measured distances from the mesh to the surface do not count: they may be too large).
    /// With the measured estimator and without TessellateOptions::measure the samples that refinement took say so.
    bool tolerance_reached = true;
    /// Upper bound on the distance between mesh and limit surface, both directions; empty with target or displacement,
    /// for schemes without a bound (see scheme_support()), and with the measured estimator where the bound is by norms
    /// of masks, which takes several times as long as all else.
    std::optional<double> certified_error;
    std::optional<MeasuredError> measured_error;
    int deepest_level = 0;  ///< quadtree level of the finest triangle (sqrt3: level of refine())
    StageSeconds seconds;
    std::uint64_t peak_memory_before_measure_bytes = 0;
    std::vector<std::string> warnings;
};

/// Tessellates the limit surface of a control mesh to a tolerance: one watertight indexed mesh whose vertices are limit
/// points (projected or displaced on request), the same bytes for any number of threads.
/// @param mesh     control mesh; triangle schemes need triangles: triangulate() makes them
/// @throws Error   invalid_input (options that contradict each other, UVs missing for a displacement), unsupported
///                 (what scheme_support() says no to, a limit without a mask, more triangles in the coarsest mesh
///                 than max_triangles), memory_limit, cancelled
/// Cost: O(triangles); about one patch evaluation per vertex and two bounds per triangle. Without patches: about ten
/// limit points per triangle and as many again to measure, at a few microseconds each.
Tessellation tessellate(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context = {});

}  // namespace tetrakis
