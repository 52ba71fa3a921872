#pragma once

#include <optional>
#include <string>

namespace tetrakis {

class BlockRunner;

/// The C1 rule for smooth edges that end in a boundary or crease (Biermann, Levin, Zorin 2000).
enum class EdgeBesideCrease {
    plain,   ///< the smooth rule of the interior: no tangent plane where more than 3 quads or 5 triangles meet
    cosine,  ///< the weights depend on the number of faces
    brief,   ///< constant weights, those of a large number of faces
};
enum class LoopWeights { loop, warren };
/// How averaging schemes treat the missing neighbours along the boundary of a mesh.
enum class AveragingBoundary {
    replicate,  ///< copies of the boundary vertices replace them
    recede,     ///< points that need them are not made: each step takes about m / 4 rings off the mesh
};

inline constexpr int k_most_averaging_steps = 64;

/// Choices that the rules of some schemes offer; a scheme ignores those that it does not have.
struct RuleOptions {
    EdgeBesideCrease edge_beside_crease = EdgeBesideCrease::plain;  ///< loop, tuned-loop, catmull-clark
    LoopWeights loop_weights = LoopWeights::loop;                   ///< loop
    bool hoppe_crease = false;  ///< loop: Hoppe et al. 1994, the crease edge rule that depends on the valence
    /// catmull-clark: total weights of the edge neighbours and of the opposite corners at extraordinary vertices
    /// between quads; see catmull_clark_weight_range().
    std::optional<double> catmull_clark_beta{}, catmull_clark_gamma{};
    bool reflect_at_boundary = false;  ///< modified-butterfly: missing points by reflection, not by boundary rules
    double butterfly_w = 0;            ///< butterfly, modified-butterfly: the ten-point rule's tension, -1/16 to 1/24
    double tuning = 1;                 ///< tuned-loop: 0 Loop's eigenvalues, 1 the prescribed ones
    int averaging_steps = 3;           ///< averaging; from 0 to k_most_averaging_steps
    AveragingBoundary averaging_boundary = AveragingBoundary::replicate;
    /// loop, tuned-loop, catmull-clark: interior angle of sectors at corners without a tag (RuleMesh::corner_angle());
    /// 0: the plain rule.
    double corner_angle = 0;
    /// The same schemes: when a control mesh becomes a RuleMesh, a sector without its own angle gets the sum of its
    /// faces' angles (usable_corner_angle()).
    bool measure_corner_angles = false;
    bool chaikin_creases = false;         ///< loop, catmull-clark: semi-sharp edges follow CreaseMethod::chaikin
    const BlockRunner* runner = nullptr;  ///< no rule: runs the blocks of a step's rows; nullptr: no threads
};

/// The options whose rules are not the default ones, as text: "averaging_steps 2, tuning 0.5", in the order of their
/// declaration; empty for plain rules. Equal texts are equal rules: numbers are written to their last bit.
std::string rule_choices(const RuleOptions& options);

}  // namespace tetrakis
