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
    /// Measured distances. Bounds accept and samples reject most triangles; closest points (and rays, with a target)
    /// decide the rest. Without patches: limit points that two more levels put on each triangle's edges and inside it.
    measured,
    certified,  ///< the certified bound itself: refines until it is within the tolerance
};

/// What tessellate() can do with a scheme.
struct SchemeSupport {
    bool adaptive = false;  ///< the mesh is refined only where needed; else by whole levels of refine() (honeycomb)
    /// The surface is exact everywhere: results are measured against it; targets and displacements work. Else results
    /// are measured against limit points that cut each triangle in 16 or more (in 4 if there are more than 250 000).
    bool patches = false;
    bool certified = false;  ///< there are error bounds that hold for every point
};
/// Patches: Catmull-Clark and Loop with their plain rules. Certified: both with any rules; bilinear and midpoint;
/// Doo-Sabin and midedge; tuned Loop, Butterfly, Kobbelt, 4-8 and even averaging, unless a tag stays semi-sharp for
/// more than 6 levels. Whole levels: honeycomb refinement; its texture coordinates are those of the level's net.
SchemeSupport scheme_support(const SchemeChoice& scheme, const RuleOptions& rules = {});
/// The same for one mesh: there are no patches if corners have angles of their own. It does not check for holes (dual
/// schemes), or for meshes that only whole levels can refine: there the certified estimator throws `unsupported`.
SchemeSupport scheme_support(const ControlMesh& mesh, const SchemeChoice& scheme, const RuleOptions& rules = {});

struct TessellateOptions {
    SchemeChoice scheme = SchemeKind::catmull_clark;  ///< see scheme_support()
    RuleOptions rules{};                              ///< choices that the scheme's rules offer
    EstimatorKind estimator = EstimatorKind::measured;
    /// Largest allowed distance between mesh and limit surface, in both directions. Unset: refinement goes on to
    /// max_triangles, or until no distance is above rounding.
    std::optional<double> tolerance{};
    bool tolerance_is_absolute = false;  ///< else a share of the diagonal of the control mesh's bounding_box()
    /// 0: no limit. The largest errors are refined first. The coarsest mesh, with all control vertices, must fit.
    std::uint64_t max_triangles = 0;
    /// Least quadtree level of every face (sqrt3: level of refine()); max_triangles must have room for it.
    int min_level = 0;
    int max_level = 28;  ///< cells of this level are not refined
    /// Vertices are projected onto this mesh, and errors are distances to it, in both directions. If it has parts that
    /// the control mesh does not cover, the tolerance cannot be met there; a warning says so.
    const TriangleMesh* target = nullptr;
    const HeightImage* displacement = nullptr;  ///< heights in [0, 1] by UV, along the limit normal
    double amplitude = 0;                       ///< displacement by a height of 1, in the unit of the model
    bool normals = true;                        ///< limit normals; with target or displacement, the triangles'
    /// Largest angle between a triangle and its normals. At larger ones, as on roundings tighter than the tolerance,
    /// and at infinitely sharp edges, vertices get several normals (TriangleMesh::triangle_normals) for shading.
    double crease_degrees = 30;
    bool uvs = true;  ///< the result gets the control mesh's texture coordinates, if there are any
    /// Measures the result at the end (symmetric Hausdorff, mean, RMS), at local maxima between samples, too. With the
    /// measured estimator, triangles above the tolerance are split, and the mesh is measured again. Takes one to five
    /// times as long as tessellating. Parts of a target that the mesh does not cover are found by this only.
    bool measure = false;
    /// Number of samples that measuring aims at in each direction: a lattice on every triangle with 3 to 24 intervals a
    /// side (24: some 300 points). Without patches, half as many samples, which are spread as by compare().
    std::uint64_t measure_samples = 100'000;
    bool floats_written = false;  ///< the caller writes floats (GLB): certified_error includes their rounding
};

struct StageSeconds {
    double load = 0, build = 0, refine = 0, estimate = 0, measure = 0, write = 0;
};

struct Tessellation {
    TriangleMesh mesh;
    std::vector<std::uint32_t> triangle_face;  ///< T: control face that each triangle comes from
    std::vector<float> triangle_error;         ///< T: error of each triangle, measured or else estimated, as a length
    double tolerance_absolute = std::numeric_limits<double>::infinity();  ///< in the unit of the model
    /// Whether estimates, measured errors and the certified estimator's bound are all within the tolerance. With that
    /// estimator, measured distances from mesh to surface do not count, as they may be too large. With the measured
    /// estimator and without TessellateOptions::measure, only the samples of the refinement are known.
    bool tolerance_reached = true;
    /// Upper bound on the distance between mesh and limit surface, both directions. Empty: with target or displacement;
    /// if there is no bound (see scheme_support()); and with the measured estimator if the bound would be by norms of
    /// masks, which takes several times as long as all else.
    std::optional<double> certified_error;
    std::optional<MeasuredError> measured_error;
    int deepest_level = 0;  ///< quadtree level of the finest triangle (sqrt3: level of refine())
    StageSeconds seconds;
    std::uint64_t peak_memory_before_measure_bytes = 0;
    std::vector<std::string> warnings;
};

/// Tessellates the limit surface of a control mesh to a tolerance: one watertight indexed mesh whose vertices are limit
/// points (projected or displaced on request). The result has the same bytes for any number of threads.
/// @param mesh     control mesh; triangle schemes need triangles: triangulate() makes them
/// @throws Error   invalid_input (options that contradict each other, UVs missing for a displacement), unsupported
///                 (an option that scheme_support() denies, a limit without a mask, more triangles in the coarsest mesh
///                 than max_triangles), memory_limit, cancelled
/// Cost: O(triangles); about one patch evaluation per vertex and two bounds per triangle. Without patches: about ten
/// limit points per triangle and as many again to measure, at a few microseconds each.
Tessellation tessellate(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context = {});

}  // namespace tetrakis
