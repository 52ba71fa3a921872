#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "level_points.hpp"
#include "root_gather.hpp"
#include "root_kernels.hpp"
#include "root_layout.hpp"
#include "uniform_tags.hpp"
#include "vertex_masks.hpp"

#include <memory>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Where roots are: at control faces that are quads, and at the corners of others; or at the corners of all faces, as
/// soon as one is no quad.
enum class RootPlace { faces, corners };

/// What structured refinement of a control mesh needs besides points.
struct GridTopology {
    SchemeKind scheme;
    PointRule rule;
    CreaseMethod method;
    MeshLevel control;  ///< RootPlace::corners: what the base is the first refinement of
    MeshLevel base;
    int base_level = 0;  ///< 0 or 1
    int levels;          ///< below the base
    UniformTags tags;
    std::vector<std::uint32_t> smooth;  ///< base vertices without tags that have faces, ascending
    const VertexMasks& masks;           ///< of the scheme's smooth vertices in the base

    /// @param levels  those asked for; at least 1 where the faces are not all of the scheme's size
    GridTopology(const ControlMesh& mesh, SchemeKind scheme, int levels, PointRule rule,
                 RootPlace place = RootPlace::faces);
    GridTopology(const GridTopology&) = delete;
    GridTopology& operator=(const GridTopology&) = delete;

    RootLayout layout(int level) const { return {base, 1u << level}; }
    RootLayout last() const { return layout(levels); }
};

/// The base's points from the control mesh's: the same, or with RootPlace::corners and other faces than quads their
/// first refinement.
template <class T>
void refine_to_base(const GridTopology& topology, std::span<const Vec3<T>> control, T* out);

/// How a level is made from the one above. In half-steps (Catmull-Clark, RootPlace::corners): first its tetrakis mesh,
/// the moved vertices and the centres of the faces, then the edge points from both, row by row, so that what is between
/// stays in registers; the rules are those of FactoredMesh.
enum class LevelSteps { whole, half };

/// Points of all levels down to the last, through buffers that are kept.
template <class T>
class GridPoints {
  public:
    explicit GridPoints(const GridTopology& topology, LevelSteps steps = LevelSteps::whole,
                        KernelSet set = best_kernels())
        : topology_(topology), half_steps_(steps == LevelSteps::half), kernels_(root_kernels<T>(set)) {}

    /// The last level's control points; three scalars each in `out`, or in a buffer of ours with k_limit_padding
    /// scalars past its end where `out` is null. Returns where they are.
    const T* run(std::span<const Vec3<T>> control, T* out, const RunContext& context);

  private:
    using Copy = std::vector<T>;  ///< a line that has no place of its own
    void start(std::span<const Vec3<T>> control, T* out);
    template <class Layout>
    void step(const Layout& at, const TagStep& tags, const T* coarse, T* fine, const RunContext& context, double from,
              double to);
    template <class Layout>
    void corners(const Layout& at, const TagStep& step, const T* coarse, T* fine) const;
    template <class Layout>
    void edge(const Layout& at, const Layout& finer, const TagStep& step, std::uint32_t e, const T* coarse, T* fine,
              Copy& left, Copy& right) const;
    /// The smooth point of a side of one piece.
    template <class Layout>
    void only_piece(const Layout& at, std::uint32_t h, const T* coarse, T* out) const;
    template <class Layout>
    PointLine<T> beside(const Layout& at, std::uint32_t h, bool reversed, const T* coarse, Copy& copy) const;
    template <class Layout>
    PointLine<T> copied_beside(const Layout& at, std::uint32_t h, bool reversed, const T* coarse, Copy& copy) const;
    template <class Layout>
    void root(const Layout& at, const Layout& finer, std::uint32_t f, const T* coarse, T* fine, Copy& scratch) const;
    template <class Layout>
    void other_face(const Layout& at, const Layout& finer, std::uint32_t f, const T* coarse, T* fine) const;

    const GridTopology& topology_;
    bool half_steps_;
    const RootKernels<T>& kernels_;
    HugeBuffer<T> buffers_[2];
};

/// Vertex numbers of all faces at the last level, root by root, row by row.
void write_faces(const RootLayout& at, std::span<std::uint32_t> corners, const RunContext& context,
                 KernelSet set = best_kernels());

}  // namespace tetrakis::detail
