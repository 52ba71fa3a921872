#pragma once

#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/block_runner.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tetrakis::detail {

/// Blocks of a step's rows on all threads.
class ParallelBlocks final : public BlockRunner {
  public:
    void run(int count, const std::function<void(int)>& block) const override {
        for_each_index(
            static_cast<std::uint32_t>(count), [&](std::uint32_t i) { block(static_cast<int>(i)); }, 1);
    }
    bool is_parallel() const override { return !one_thread(); }
};

/// Writes every row's combination of `width` numbers a point: row by row, in the order of its terms whatever the width.
void apply(const StencilTable& table, const double* in, int width, double* out);

/// The control faces that a dual scheme's points and faces lie in.
struct CornerFaces {
    std::vector<int> control_face;  ///< by face
    // By half-edge; from level 1 on.
    std::vector<int> corner_face;  ///< of the corner there, on its side of creases
    std::vector<int> point_face;   ///< the same, but one for all corners at the end of a crease

    /// From a level to the next one.
    void follow(const RuleMesh& level, const RuleStep& step);
};

/// A control mesh refined step by step by the rules of a scheme; what depends on connectivity and tags is kept.
class RuleLevels {
  public:
    /// @param smoothing  rounds before the first step; see RefineOptions
    RuleLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, int smoothing);
    RuleLevels(const RuleLevels&) = delete;
    RuleLevels& operator=(const RuleLevels&) = delete;

    /// One step more. Returns RuleStep::child_halfedge.
    /// @throws Error  invalid_input: the scheme cannot take the mesh
    std::vector<int> advance();

    int level() const { return level_; }
    const RuleMesh& last() const { return last_; }
    /// The control face that a face lies in. Dual schemes: most of its corners, or the first such face of several.
    int control_face(int face) const { return faces_.control_face[static_cast<std::size_t>(face)]; }
    /// The control faces that the corners at the half-edges' origins come from.
    std::vector<std::uint32_t> control_face_of_corners() const;
    /// The rounds of smoothing and the steps so far, each from one level to the next.
    std::span<const StencilTable> steps() const { return steps_; }
    /// The last level's values from the control mesh's.
    std::vector<double> net(std::span<const double> control, int width) const;
    void net(std::span<const double> control, int width, std::span<double> out) const;

  private:
    ParallelBlocks runner_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::string source_;
    int level_ = 0;
    RuleMesh last_;
    std::vector<StencilTable> steps_;
    CornerFaces faces_;  ///< other schemes: of faces alone
};

}  // namespace tetrakis::detail
