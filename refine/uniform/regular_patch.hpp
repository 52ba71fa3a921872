#pragma once

#include "../../hier/forest/site.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../rules/regular_limit.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Where limits go: whole points, or positions alone, without tangents and normals.
struct LimitsOut {
    std::span<LimitPoint> points;
    std::span<Vec3d> positions;

    bool positions_alone() const { return !positions.empty(); }
    void put(std::uint32_t index, const LimitPoint& point) const {
        if (positions_alone())
            positions[index] = point.position;
        else
            points[index] = point;
    }
};

/// A dual scheme where the mesh is regular: the net around a cell of a vertex quadtree is a square of points, from
/// which those around each child follow by the same four rows everywhere, and so down to any level, without a mesh.
class RegularPatch {
  public:
    /// A cell asked for below that of the patch: how many levels, and the coordinates whose lowest bits lead there.
    struct Target {
        std::uint32_t index = 0;
        int levels = 0;
        LatticePoint at;
    };

    /// @param limit  the limit of the scheme's regular vertices
    /// @param rings  of faces around a vertex: more than any of the scheme's rules looks at
    RegularPatch(const SchemeInfo& scheme, const RuleOptions& options, const RegularLimit& limit, int rings);

    /// How far from its middle the patch goes.
    int radius() const { return radius_; }
    /// Takes the points around a vertex, where all of them are regular; returns whether they are.
    /// @param regular  per vertex (RegularLimit::regular())
    /// @param ahead    a half-edge that leaves the vertex towards +x
    bool gather(const RuleMesh& mesh, std::span<const unsigned char> regular, std::span<const Vec3d> net, int ahead);
    /// Limits at targets below the gathered patch. A limit depends on the patch and the target alone; those in the
    /// order of a tree share their way.
    void limits(std::span<const Target> targets, const LimitsOut& out);

  private:
    struct Term {
        int offset = 0;
        double weight = 0;
    };
    using Terms = std::vector<Term>;

    struct Masks {
        Terms limit, tangent1, tangent2;
    };
    using LatticeTerms = std::vector<RegularLimit::LatticeTerm>;

    bool reaches(int radius) const;
    Terms terms(std::span<const RegularLimit::LatticeTerm> lattice) const;
    LatticeTerms from_child(std::size_t child, std::span<const RegularLimit::LatticeTerm> lattice) const;
    void descend(std::size_t depth, std::span<const Target> targets, const LimitsOut& out);
    void make_child(std::size_t depth, std::size_t child);
    Vec3d* square(std::size_t depth);
    LimitPoint limit(const Masks& masks, const Vec3d* middle) const;
    Vec3d corner_normal(const Vec3d* middle) const;
    static Vec3d sum(const Terms& terms, const Vec3d* at) {
        Vec3d result(0);
        for (const Term& t : terms) result += t.weight * at[t.offset];
        return result;
    }

    int radius_ = 0, side_ = 0;
    bool positions_alone_ = false;
    std::array<LatticeTerms, 4> lattice_rows_;  // of the children: x + 2 y
    std::array<Terms, 4> rows_;
    Masks limit_;                       // of the middle
    std::array<Masks, 4> child_limit_;  // of the children, from their parent's square
    std::vector<Vec3d> points_;         // squares, one for each depth
};

}  // namespace tetrakis::detail
