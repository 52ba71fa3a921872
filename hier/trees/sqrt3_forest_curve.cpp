#include "../base/memory.hpp"
#include "../base/radix_sort.hpp"
#include "../base/spread_bits.hpp"
#include "sqrt3_forest.hpp"

#include <algorithm>
#include <cassert>

// The leaves along a curve through the mesh. Two steps cut the edges of a face in three and the face in nine, so a face
// of an even level lies in one control face, in whose grid its corners are whole numbers; which of the nine triangles
// is whose grandchild, the edges that are not flipped say, which lie on edges of control faces.
namespace tetrakis {

namespace {

/// A place in a control face: its corners' shares, k_grid in all.
using Place = std::array<std::int64_t, 3>;

constexpr Place operator+(const Place& a, const Place& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
constexpr Place operator-(const Place& a, const Place& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
constexpr Place operator*(std::int64_t x, const Place& a) { return {x * a[0], x * a[1], x * a[2]}; }
constexpr Place operator/(const Place& a, std::int64_t x) { return {a[0] / x, a[1] / x, a[2] / x}; }
Place mean(const Place& a, const Place& b, const Place& c) { return (a + b + c) / 3; }
Place third(const Place& from, const Place& to) { return (2 * from + to) / 3; }

// 3^20: Sqrt3Lattice::max_level() is 37 at most, 18 pairs of steps and one; what is marked after 17 or 18 of them takes
// two powers more. It is less than 2^32, so two coordinates together have 64 bits.
constexpr std::int64_t k_grid = 3'486'784'401;

/// A face of level 2 * `pairs`.
struct Cell {
    FaceId root;
    int pairs = 0;
    std::array<Place, 3> corner{};
};

}  // namespace

class Sqrt3Forest::CurveWalk {
  public:
    explicit CurveWalk(const Sqrt3Forest& forest) : forest_(forest), mesh_(forest.mesh()) {
        detail::reserve_large(marked_, forest.leaf_count());
    }

    std::vector<LeafId> leaves() {
        for (std::uint32_t root = 0; root < mesh_.face_count(); ++root)
            if (forest_.child_[root] != k_dead)
                visit(root, {FaceId(root), 0, {{{k_grid, 0, 0}, {0, k_grid, 0}, {0, 0, k_grid}}}});
        std::vector<Marked> spare;
        radix_sort(marked_, spare, [](const Marked& m) { return m.along; });
        radix_sort(marked_, spare, [](const Marked& m) { return std::uint64_t{m.root}; });
        assert(std::adjacent_find(marked_.begin(), marked_.end(), [](const Marked& a, const Marked& b) {
                   return a.root == b.root && a.along == b.along;
               }) == marked_.end());
        std::vector<LeafId> result;
        detail::reserve_large(result, marked_.size());
        for (const Marked& m : marked_) result.push_back(m.leaf);
        return result;
    }

  private:
    struct Marked {
        std::uint64_t along;  // the curve in the control face
        std::uint32_t root;
        LeafId leaf;
    };
    static_assert(sizeof(Marked) == 16);

    // Marks are inside their leaves, so no two are the same; of those that lie in two control faces, in that whose
    // number they have.
    void visit(std::uint32_t slot, const Cell& cell) {
        const Place centre = mean(cell.corner[0], cell.corner[1], cell.corner[2]);
        if (!forest_.is_split(slot)) return mark(slot, cell.root, centre);
        for (std::uint32_t j = 0; j < 3; ++j)
            visit_over(forest_.first_child(forest_.child_[slot]) + j, cell, j, centre);
    }
    /// The triangle over a side of a split cell.
    void visit_over(std::uint32_t slot, const Cell& cell, std::uint32_t j, const Place& centre) {
        const Place &a = cell.corner[j], &b = cell.corner[(j + 1) % 3], &opposite = cell.corner[(j + 2) % 3];
        if (forest_.child_[slot] == k_half) return mark(slot, cell.root, mean(a, b, centre));
        const HalfedgeId edge = root_edge(cell.root, a, b);
        const bool kept = edge.valid() && is_kept(edge, cell.pairs);
        const Place first = third(a, b);
        if (!forest_.is_split(slot)) return mark(slot, cell.root, kept ? mean(a, b, centre) : mean(a, first, centre));

        const std::uint32_t child = forest_.first_child(forest_.child_[slot]);
        const Place second = third(b, a);
        const int pairs = cell.pairs + 1;
        const auto is_half = [&](std::uint32_t side) { return forest_.child_[child + side] == k_half; };
        if (kept) {
            visit(child, {cell.root, pairs, {first, second, centre}});
            if (is_half(1))
                mark(child + 1, cell.root, mean(b, centre, second));
            else
                visit(child + 1, {cell.root, pairs, {b, third(b, opposite), second}});
        } else {
            const Place beyond = a + b - opposite, centre_beyond = a + b - centre;
            if (is_half(0))
                mark_across(edge, child, cell.root, mean(a, centre_beyond, first));
            else
                visit(child, across(edge, {cell.root, pairs, {a, third(a, beyond), first}}));
            // On both sides of the edge: in this one, between the edge's first third and its middle.
            if (is_half(1))
                mark(child + 1, cell.root, (4 * centre + 4 * first + second) / 9);
            else
                visit(child + 1, across(edge, {cell.root, pairs, {centre_beyond, second, first}}));
        }
        if (is_half(2))
            mark(child + 2, cell.root, mean(a, first, centre));
        else
            visit(child + 2, {cell.root, pairs, {centre, third(a, opposite), first}});
    }

    /// The control half-edge that a side lies on; invalid inside.
    HalfedgeId root_edge(FaceId root, const Place& a, const Place& b) const {
        for (std::uint32_t side = 0; side < 3; ++side)
            if (const std::uint32_t away = (side + 2) % 3; a[away] == 0 && b[away] == 0)
                return HalfedgeId(mesh_.face_halfedge(root).value + side);
        return {};
    }
    /// Whether an edge is not flipped at this level.
    bool is_kept(HalfedgeId h, int pairs) const {
        const EdgeId e = mesh_.edge(h);
        return !mesh_.twin(h).valid() || forest_.lattice().is_kept(e) || mesh_.sharpness(e) > static_cast<float>(pairs);
    }
    /// Places beyond a control edge, from its face's grid, folded down flat, to the grid of the face beyond.
    Place across(HalfedgeId h, const Place& p) const {
        const std::uint32_t side = h.value % 3, twin = mesh_.twin(h).value % 3;
        const std::int64_t beyond = p[(side + 2) % 3];
        Place q;
        q[twin] = p[(side + 1) % 3] + beyond;
        q[(twin + 1) % 3] = p[side] + beyond;
        q[(twin + 2) % 3] = -beyond;
        return q;
    }
    Cell across(HalfedgeId h, Cell cell) const {
        if (!h.valid()) return cell;
        cell.root = mesh_.face(mesh_.twin(h));
        for (Place& p : cell.corner) p = across(h, p);
        return cell;
    }
    void mark_across(HalfedgeId h, std::uint32_t slot, FaceId root, const Place& p) {
        if (h.valid())
            mark(slot, mesh_.face(mesh_.twin(h)), across(h, p));
        else
            mark(slot, root, p);
    }
    void mark(std::uint32_t slot, FaceId root, const Place& p) {
        assert(p[0] > 0 && p[1] > 0 && p[2] > 0 && p[0] + p[1] + p[2] == k_grid);
        const std::uint64_t along = detail::spread_bits(static_cast<std::uint64_t>(p[0])) |
                                    detail::spread_bits(static_cast<std::uint64_t>(p[1])) << 1;
        marked_.push_back({along, root.value, LeafId(slot)});
    }

    const Sqrt3Forest& forest_;
    const ControlMesh& mesh_;
    std::vector<Marked> marked_;
};

std::vector<LeafId> Sqrt3Forest::leaves_on_curve() const { return CurveWalk(*this).leaves(); }

}  // namespace tetrakis
