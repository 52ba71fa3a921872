#pragma once

#include "factored_mesh.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace tetrakis::detail {

/// A family of factored schemes behind FactoredMesh.
class FactoredSteps {
  public:
    virtual ~FactoredSteps() = default;

    virtual void half_step() = 0;
    virtual int half_steps_per_level() const { return 2; }
    /// What half_step() would throw for want of room in one of the next `count`, as far as counts tell.
    virtual void check_half_steps(int count) const = 0;
    virtual FactoredVertex state(std::uint32_t vertex) const = 0;
    virtual std::vector<std::array<std::uint32_t, 3>> triangles() const = 0;
    virtual PolygonMesh mesh(std::vector<std::uint32_t>* numbers) const = 0;
    virtual PolygonMesh active_mesh() const = 0;

    std::span<const Vec3d> positions() const { return positions_; }
    void limit_memory(std::uint64_t bytes) { max_memory_bytes_ = bytes; }

  protected:
    static constexpr std::string_view k_next = "the next half-step";
    /// How check_half_steps() names one of them.
    static std::string half_step_of(int i, int count) {
        return "half-step " + std::to_string(i + 1) + " of " + std::to_string(count);
    }
    /// @param which  the half-step
    /// @throws Error  memory_limit: what the half-step and a mesh() of it take together is more than the limit
    void check_memory(std::uint64_t bytes, std::string_view which) const;
    /// @param elements  that the half-step would have
    [[noreturn]] static void refuse_count(std::uint64_t elements, int bits, std::string_view which);

    std::vector<Vec3d> positions_;

  private:
    std::uint64_t max_memory_bytes_ = 0;
};

std::unique_ptr<FactoredSteps> make_factored_primal(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredSteps> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme);
std::unique_ptr<FactoredSteps> make_factored_averaging(const ControlMesh& mesh, const RuleOptions& rules);

}  // namespace tetrakis::detail
