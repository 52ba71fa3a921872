#pragma once

#include "tetrakis/refine/factored_mesh.hpp"

namespace tetrakis::detail {

/// A family of factored schemes behind FactoredMesh. Rules read positions through the family's accessor alone, which
/// writes the trace.
class FactoredSteps {
  public:
    virtual ~FactoredSteps() = default;

    virtual void half_step(FactoredTrace* trace) = 0;
    virtual int half_steps_per_level() const { return 2; }
    virtual FactoredVertex state(std::uint32_t vertex) const = 0;
    virtual std::vector<std::array<std::uint32_t, 3>> triangles() const = 0;
    virtual PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const = 0;
    virtual PolygonMesh active_mesh() const = 0;

    std::span<const Vec3d> positions() const { return positions_; }
    void limit_memory(std::uint64_t bytes) { max_memory_bytes_ = bytes; }

  protected:
    /// @throws Error  memory_limit: what the next half-step and a mesh() of it take together is more than the limit
    void check_memory(std::uint64_t bytes) const;

    std::vector<Vec3d> positions_;

  private:
    std::uint64_t max_memory_bytes_ = 0;
};

std::unique_ptr<FactoredSteps> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredSteps> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredSteps> make_factored_averaging(const ControlMesh& mesh, const RuleOptions& rules);

}  // namespace tetrakis::detail
