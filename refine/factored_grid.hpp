#pragma once

#include "tetrakis/refine/grid_refinement.hpp"

namespace tetrakis::detail {

/// Factored Catmull-Clark on structured roots: each level in two half-steps, with the rules of FactoredMesh and the
/// vertices of UniformRefiner in their order.
///
/// After the first half-step of a level with N segments there is its tetrakis mesh: the moved vertices in the level's
/// layout, and the centres of its faces, root by root, row by row. The second puts both and the edge points in the next
/// level's layout.
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
    void start(std::span<const Vec3<T>> control, T* out) const;
    void first_half(int level, const T* old);
    void second_half(int level, const T* old, T* fine) const;
    void move_corners(const RootLayout& at, const TagStep& step, const T* old);
    void move_edge(const RootLayout& at, const TagStep& step, std::uint32_t e, const T* old, std::vector<T>& lines);
    void edge_points(const RootLayout& at, const RootLayout& finer, const TagStep& step, std::uint32_t e, const T* old,
                     std::vector<T>& lines, T* fine) const;
    /// Centre of cell j of N along half-edge h.
    const T* cell(const RootLayout& at, std::uint32_t h, std::uint32_t j) const;

    const GridTopology& topology_;
    const RootKernels<T>& kernels_;
    HugeBuffer<T> levels_[2], moved_, centres_;
    const T* centre_points_ = nullptr;
    T* moved_points_ = nullptr;
};

}  // namespace tetrakis::detail
