#pragma once

#include "tetrakis/hier/huge_buffer.hpp"
#include "tetrakis/hier/run_context.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/level_points.hpp"
#include "tetrakis/refine/root_gather.hpp"
#include "tetrakis/refine/root_kernels.hpp"
#include "tetrakis/refine/root_layout.hpp"
#include "tetrakis/refine/uniform_tags.hpp"
#include "tetrakis/schemes/ring_mask.hpp"

#include <memory>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// What structured refinement of a control mesh needs besides points. The roots are the control faces where all are of
/// the scheme's size, else the quads of the first refinement.
struct GridTopology {
    SchemeKind scheme;
    PointRule rule;
    CreaseMethod method;
    MeshLevel control;  ///< used where the first refinement is the general one
    MeshLevel base;
    int base_level = 0;  ///< 0 or 1
    int levels;          ///< below the base
    UniformTags tags;
    std::vector<std::uint32_t> smooth;  ///< base vertices without tags that have faces, ascending
    RingMask masks[64];                 ///< vertex masks of valences below 64

    /// @param levels  those asked for; at least 1 where the faces are not all of the scheme's size
    GridTopology(const ControlMesh& mesh, SchemeKind scheme, int levels, PointRule rule);
    GridTopology(const GridTopology&) = delete;
    GridTopology& operator=(const GridTopology&) = delete;

    /// The control face that a face of the last level comes from: its root's.
    std::uint32_t control_face(const ControlMesh& mesh, std::uint32_t face) const {
        const std::uint32_t root = face >> 2 * levels;
        return base_level == 0 ? root : mesh.face(HalfedgeId(root)).value;
    }
    RootLayout layout(int level) const { return {base, level}; }
    RootLayout last() const { return layout(levels); }
};

/// Points of all levels down to the last, through buffers that are kept.
template <class T>
class GridPoints {
  public:
    explicit GridPoints(const GridTopology& topology, KernelSet set = best_kernels())
        : topology_(topology), kernels_(root_kernels<T>(set)) {}

    /// The last level's control points; three scalars each in `out`, or in a buffer of ours with k_limit_padding
    /// scalars past its end where `out` is null. Returns where they are.
    const T* run(std::span<const Vec3<T>> control, T* out, const RunContext& context);

  private:
    void start(std::span<const Vec3<T>> control, T* out);
    void step(int level, const T* coarse, T* fine, const RunContext& context, double from, double to);
    void corners(const RootLayout& at, const TagStep& step, const T* coarse, T* fine) const;
    void edge(const RootLayout& at, const RootLayout& finer, const TagStep& step, std::uint32_t e, const T* coarse,
              T* fine) const;
    void root(const RootLayout& at, const RootLayout& finer, std::uint32_t f, const T* coarse, T* fine) const;

    const GridTopology& topology_;
    const RootKernels<T>& kernels_;
    HugeBuffer<T> buffers_[2];
};

/// Vertex numbers of all faces at the last level, root by root, row by row.
void write_faces(const RootLayout& at, std::span<std::uint32_t> corners, const RunContext& context,
                 KernelSet set = best_kernels());

}  // namespace tetrakis::detail
