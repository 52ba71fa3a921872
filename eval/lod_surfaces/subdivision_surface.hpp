#pragma once

#include "../surface/scheme_choice.hpp"
#include "sampled_surface.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace tetrakis::detail {
class LatticeLimits;
}

namespace tetrakis::lod {

struct SubdivisionSurfaceOptions {
    /// Triangles lie over a lattice of 2^(level + 1) steps to an edge of the control mesh. From 1 to
    /// SampledSurface::k_max_level; for dual schemes 1 is as 2.
    int level = 5;
    RuleOptions rules{};
    /// Moves each point of the lattice along its normal by the returned distance. Called by several threads; on_edge of
    /// the place is its position. The surface is then the finest triangles.
    std::function<double(const Place&)> displacement{};
    RunContext context{};
};

/// The limit surface of a scheme whose faces become quads, of Doo-Sabin, midedge, or Loop. roots() of the dual ones are
/// the cells of level 1. Bounds are proven: they hold for every point of the limit surface, also between the lattice's
/// points. They include the rounding of positions, which are stored as floats. uv: linear interpolation from a face's
/// corners; from one of the faces around where these differ. The surface keeps a copy of the control mesh.
class SubdivisionSurface final : public SampledSurface {
  public:
    /// @throws Error  invalid_input: a mesh that the scheme cannot take or whose faces are all holes, a level out
    ///                of range, a point that is displaced to no finite place; unsupported: a scheme
    ///                of another kind, a mesh for which the scheme has no bound (tessellate.hpp, certified);
    ///                memory_limit; cancelled
    /// Cost: some microseconds for each point of the lattice, by all threads; 26 bytes for each. While bounds are
    /// computed, each thread needs some 150 bytes for each point of one corner cell; 1300 for dual schemes, 2000 for
    /// other schemes without patches.
    SubdivisionSurface(const ControlMesh& mesh, const SchemeChoice& scheme,
                       const SubdivisionSurfaceOptions& options = {});

    std::uint64_t memory_bytes() const override;

  private:
    void positions(std::span<const Site> sites, std::span<Vec3d> positions) const override;
    void shade(std::span<const Site> sites, std::span<Place> places) const override;
    void finest_errors(HalfedgeId cell, std::span<float> errors) const override;

    bool by_triangles_;
    const detail::LatticeLimits* limits_ = nullptr;  // while bounds are being found
    // By point.
    std::vector<Vec3f> positions_, normals_;
};

}  // namespace tetrakis::lod
