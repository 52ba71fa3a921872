#pragma once

#include "../base/memory.hpp"
#include "../base/run_context.hpp"
#include "../mesh/control_mesh.hpp"
#include "sqrt3_lattice.hpp"
#include "sqrt3_leaf.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Split faces of sqrt(3) refinement: per level their numbers (Sqrt3Lattice), increasing.
using Sqrt3Split = std::vector<std::vector<std::uint64_t>>;

/// A half-edge of a level on a crease or kept edge.
struct Sqrt3Line {
    std::uint32_t halfedge;
    std::uint32_t beyond;  ///< the other one
    float sharpness;
    bool kept;  ///< whatever the sharpness is
};

/// Faces of one level of sqrt(3) refinement, in the order of their numbers, and how they lie together. Half-edge
/// 3 i + j is side j of face i; where a number below is none or outside, it is no half-edge.
struct Sqrt3Level {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;     ///< across an edge that is not flipped
    static constexpr std::uint32_t outside = 0xFFFF'FFFEu;  ///< a face that has not been raised, or its point

    detail::RawPoolVector<std::uint64_t> number;  ///< per face: the lattice's
    /// Per half-edge: across an edge that is flipped. The last level may be without any (Sqrt3Levels).
    detail::RawPoolVector<std::uint32_t> twin;
    std::vector<Sqrt3Line> lines;                 ///< by half-edge
    detail::RawPoolVector<std::uint32_t> vertex;  ///< per half-edge: its origin, in Sqrt3Levels::vertices
    /// Per face: its point of the next level; where a side is cut, the one over the first and third half-edge.
    detail::RawPoolVector<std::uint32_t> apex;
    detail::RawPoolVector<std::uint32_t> child;  ///< per face: the first of three of the next level, or outside
    detail::RawPoolVector<std::uint8_t> split;   ///< per face
    bool all_split = false;                      ///< and no face of the surface is missing

    std::uint32_t face_count() const { return static_cast<std::uint32_t>(number.size()); }
    static bool there(std::uint32_t h) { return h < outside; }
    static std::uint32_t face(std::uint32_t h) { return h / 3; }
    static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static std::uint32_t prev(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    /// That of a half-edge; nullptr: it is on none.
    const Sqrt3Line* line(std::uint32_t h) const {
        const auto at = std::lower_bound(lines.begin(), lines.end(), h,
                                         [](const Sqrt3Line& line, std::uint32_t of) { return line.halfedge < of; });
        return at != lines.end() && at->halfedge == h ? &*at : nullptr;
    }
    /// The face of the next level with the number of half-edge h.
    std::uint32_t child_over(std::uint32_t h) const { return there(child[h / 3]) ? child[h / 3] + h % 3 : outside; }
};

/// The levels of an adaptive sqrt(3) mesh, side by side: all control faces; of the next level the faces over the sides
/// of split faces and of those around them, and so on. O(faces), in one sweep. Keeps a reference to the lattice.
///
/// The last level has twins only where rings can be gone around in no other way: with rings and limits, where a face is
/// left out or an edge not flipped, or where it has lines.
class Sqrt3Levels {
  public:
    /// @param split   those of a forest
    /// @param rings   of faces around the split ones whose sides' faces are raised, too
    /// @param limits  also raise what the vertices beside edges that are cut next are surrounded by after the cut
    /// @throws Error  memory_limit: they would take more than the context allows; cancelled
    Sqrt3Levels(const Sqrt3Lattice& lattice, const Sqrt3Split& split, int rings, bool limits = false,
                const RunContext& context = {});

    /// Calls visit(level, face, half, control face) for the triangles of the mesh, by control face, then by where they
    /// come from. Where `half`, the face is split, and `face` is the half-edge over which its part remains.
    template <class Visit>
    void for_each_leaf(Visit&& visit) const {
        // Split faces that are being gone through: the next of their half-edges, and where these end.
        struct Open {
            std::uint32_t next, end;
        };
        std::vector<Open> open;
        for (std::uint32_t root = 0; root < levels[0].face_count(); ++root) {
            if (lattice_->is_hole(0, root)) continue;
            // Whether the triangle over a half-edge of a split face is a whole one.
            const auto is_whole = [](const Sqrt3Level& level, std::uint32_t h) {
                if (level.all_split) return true;
                const std::uint32_t t = level.twin[h];
                return t == Sqrt3Level::none || (t != Sqrt3Level::outside && level.split[t / 3] != 0);
            };
            const auto enter = [&](std::uint32_t face) {
                const std::size_t k = open.size();
                const Sqrt3Level& level = levels[k];
                if (!level.all_split && level.split[face] == 0)
                    return visit(static_cast<int>(k), face, false, FaceId(root));
                if (k + 1 < split_levels_) return open.push_back({3 * face, 3 * face + 3});
                for (std::uint32_t h = 3 * face; h < 3 * face + 3; ++h) {
                    const bool whole = is_whole(level, h);
                    visit(static_cast<int>(whole ? k + 1 : k), whole ? level.child_over(h) : h, !whole, FaceId(root));
                }
            };
            enter(root);
            while (!open.empty()) {
                if (open.back().next == open.back().end) {
                    open.pop_back();
                    continue;
                }
                const std::uint32_t h = open.back().next++;
                const std::size_t k = open.size() - 1;
                if (const Sqrt3Level& level = levels[k]; is_whole(level, h))
                    enter(level.child_over(h));
                else
                    visit(static_cast<int>(k), h, true, FaceId(root));
            }
        }
    }
    /// The point that stands over a half-edge of a split face.
    std::uint32_t apex(int level, std::uint32_t h) const {
        const Sqrt3Level& at = levels[static_cast<std::size_t>(level)];
        const std::uint32_t first = at.apex[h / 3];
        return h % 3 == 1 ? beside(first) : first;
    }
    /// The other point of a cut edge, from the one that a face has for its apex; any other point itself.
    std::uint32_t beside(std::uint32_t apex) const {
        switch (vertices[apex].kind) {
            case Sqrt3Vertex::Kind::first:
                return apex + 1;
            case Sqrt3Vertex::Kind::second:
                return apex - 1;  // of a crease, from the side that has not named them
            case Sqrt3Vertex::Kind::centre:
            case Sqrt3Vertex::Kind::control:
                break;
        }
        return apex;
    }
    /// What a call of for_each_leaf() says, as the lattice names it.
    Sqrt3Leaf leaf(int level, std::uint32_t face, bool half, FaceId control_face) const;

    std::vector<Sqrt3Level> levels;
    detail::PoolVector<Sqrt3Vertex> vertices;  ///< those of the control mesh first
    bool complete = true;                      ///< no face is left out

    const Sqrt3Lattice& lattice() const { return *lattice_; }
    std::uint64_t memory_bytes() const;

  private:
    void start(const ControlMesh& mesh);
    void mark_split(std::size_t index, std::span<const std::uint64_t> numbers);
    detail::RawPoolVector<std::uint8_t> with_rings(const Sqrt3Level& level, detail::RawPoolVector<std::uint8_t> faces,
                                                   int rings) const;
    void add_beside_cuts(const Sqrt3Level& level, detail::RawPoolVector<std::uint8_t>& faces) const;
    void raise(Sqrt3Level& level, int index, std::span<const std::uint8_t> faces, Sqrt3Level& finer);
    bool needs_last_twins(const Sqrt3Level& before_last, int rings, bool limits) const;
    void link(const Sqrt3Level& level, bool cuts, Sqrt3Level& finer) const;
    void link_lines(const Sqrt3Level& level, bool cuts, Sqrt3Level& finer) const;

    const Sqrt3Lattice* lattice_;
    std::size_t split_levels_;  // from here on no face is split
};

}  // namespace tetrakis
