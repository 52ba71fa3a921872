#pragma once

#include "../base/number_set.hpp"
#include "sqrt3_lattice.hpp"
#include "sqrt3_leaf.hpp"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

/// A face of a level of sqrt(3) refinement (Sqrt3Lattice).
struct Sqrt3Face {
    std::uint8_t level = 0;
    std::uint64_t face = 0;
    friend constexpr auto operator<=>(const Sqrt3Face&, const Sqrt3Face&) = default;
};

/// Adaptive sqrt(3) refinement (Kobbelt 2000, section 5, adaptive refinement): faces are split by a point inside, and
/// an edge is flipped as soon as both its faces are split. The flipped triangle is a face of the next level, which can
/// be split itself. So a face is there when the faces on both sides of the edge it lies across are split, and the mesh
/// is conforming and graded whatever is split: nothing is needed to close it. Edges that are not flipped (Sqrt3Lattice:
/// boundary, creases, kept ones) are cut in three by every second step: there both faces of an edge inside are split
/// together, as partners.
///
/// The state is the set of split faces, whatever the way to it. Storage: a bit per split face, of which there is one
/// for two leaves, where all around are split; 64 bytes where it is alone.
class Sqrt3Forest {
  public:
    /// Nothing split. Keeps a reference to the mesh. Faces in holes are not there.
    /// @param kept    as Sqrt3Lattice takes it
    /// @throws Error  unsupported: other faces than triangles
    explicit Sqrt3Forest(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept = {});
    explicit Sqrt3Forest(const ControlMesh&&, const std::function<bool(EdgeId)>& = {}) = delete;

    const ControlMesh& mesh() const { return *mesh_; }
    /// To be copied where it is used.
    const Sqrt3Lattice& lattice() const { return lattice_; }
    int max_level() const { return max_level_; }
    std::size_t split_count() const;
    /// Each split adds two, on the boundary, too.
    std::size_t leaf_count() const { return roots_ + 2 * split_count(); }
    bool is_split(const Sqrt3Face& face) const;
    /// Whether the face is part of the mesh, or has been split: the faces that it comes from are split.
    bool is_there(const Sqrt3Face& face) const;

    /// Splits a face, its partner, and the coarser ones that they need to be there. Returns the number of faces split;
    /// 0 if it is split already.
    /// @throws Error  invalid_input: no such face; unsupported: beyond max_level(). The forest is then unchanged.
    std::size_t refine(const Sqrt3Face& face);
    /// The same for many, all or none.
    std::size_t refine(std::span<const Sqrt3Face> faces);
    /// Splits faces that need no others than are split or among them, as needed() has found them; all or none.
    /// @throws Error  unsupported: beyond max_level()
    std::size_t refine_closed(std::span<const Sqrt3Face> faces);
    /// A leaf: splits its face; a half, the face beyond its edge, so that it becomes a face.
    std::size_t refine(const Sqrt3Leaf& leaf);
    /// The faces that refine() would split, the finest first; none if nothing is left to split.
    /// @throws Error  as refine()
    std::vector<Sqrt3Face> needed(const Sqrt3Leaf& leaf) const;
    std::vector<Sqrt3Face> needed(const Sqrt3Face& face) const;
    /// refine() of all leaves that are wanted, each as it is before the call. Returns the number of faces split.
    std::size_t refine_where(const std::function<bool(const Sqrt3Leaf&)>& wanted);
    /// Whether a face is split and none of the faces that come from it and its partner is.
    bool can_coarsen(const Sqrt3Face& face) const;
    /// Takes a face's point out again: the inverse of the split of this face, and its partner, alone.
    /// @throws Error  invalid_input: can_coarsen() is false
    void coarsen(const Sqrt3Face& face) { coarsen({&face, 1}); }
    /// The same for many, all or none: none of them comes from another.
    void coarsen(std::span<const Sqrt3Face> faces);

    /// Split faces per level.
    std::span<const NumberSet> split() const { return split_; }
    /// The mesh: all leaves by control face, then by where they come from. O(leaves).
    std::vector<Sqrt3Leaf> leaves() const;
    /// All split faces, by level, then number.
    std::vector<Sqrt3Face> split_faces() const;
    /// Verifies that every split face is there, and its partner split, too. Returns the first violation, or nothing.
    std::optional<std::string> check() const;
    std::uint64_t memory_bytes() const;

  private:
    bool is_split(int level, std::uint64_t face) const {
        return static_cast<std::size_t>(level) < split_.size() &&
               split_[static_cast<std::size_t>(level)].contains(face);
    }
    bool is_there(Sqrt3Lattice& lattice, int level, std::uint64_t face) const;
    void add_needed(Sqrt3Lattice& lattice, std::vector<Sqrt3Face>& wanted) const;
    bool has_split_children(Sqrt3Lattice& lattice, const Sqrt3Face& face) const;
    std::size_t split_all(std::span<const Sqrt3Face> faces);
    void require_face(const Sqrt3Face& face) const;
    [[noreturn]] void refuse_depth() const;

    const ControlMesh* mesh_;
    Sqrt3Lattice lattice_;  // has found nothing yet: copied where it is used
    int max_level_ = 0;
    std::size_t roots_ = 0;         // faces outside holes
    std::vector<NumberSet> split_;  // per level
};

}  // namespace tetrakis
