#pragma once

#include "tetrakis/refine/grid_refinement.hpp"

namespace tetrakis::detail {

/// Factored Catmull-Clark on structured roots: each level in two half-steps, with the rules of FactoredMesh and the
/// vertices of UniformRefiner in their order.
///
/// The first half-step of a level gives its tetrakis mesh: the moved vertices and the centres of its faces; the second
/// the edge points. Both are made root by root, so that what is between them stays in the cache; what edges and corners
/// need of the centres is kept for the roots' sides.
template <class T>
class FactoredGrid {
  public:
    /// @param topology  of Catmull-Clark by the scheme's rules; outlives this
    explicit FactoredGrid(const GridTopology& topology, KernelSet set = best_kernels())
        : topology_(topology), kernels_(root_kernels<T>(set)) {}

    /// The last level's control points, three scalars each, in a buffer that is kept until the next call. The first
    /// refinement of n-gons goes by the same rules.
    const T* run(std::span<const Vec3<T>> control);

  private:
    struct EdgeRule;
    void refine_roots(int level, const T* old, T* fine);
    void refine_edge(const RootLayout& at, const RootLayout& finer, const TagStep& step, std::uint32_t e, const T* old,
                     std::vector<T>& lines, T* fine) const;
    void move_corners(const RootLayout& at, const TagStep& step, const T* old, T* fine) const;
    /// Centre of cell j of N along half-edge h.
    const T* cell(const RootLayout& at, std::uint32_t h, std::uint32_t j) const {
        return rims_points_ + 3 * (std::uint64_t{h} * at.segments() + j);
    }

    const GridTopology& topology_;
    const RootKernels<T>& kernels_;
    HugeBuffer<T> levels_[2], rims_;
    const T* rims_points_ = nullptr;
};

}  // namespace tetrakis::detail
