#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../surface/surface_point.hpp"
#include "cell.hpp"
#include "corner_ring.hpp"
#include "star.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis {

namespace detail {

template <class Shape>
struct PatchQuarters;

/// One cell of a patch tree. Regular cells are leaves, with one patch; the others grow four children on demand.
/// @tparam Shape  QuadShape or LoopShape: corners, patches, stars, and how cells are quartered
template <class Shape>
struct PatchNode : PoolNew {
    enum class Kind : std::uint8_t {
        regular,  ///< one patch
        star,     ///< smooth around its corners, which are not all regular
        generic,  ///< anything else: the rings of its corners
    };
    using Rings = CellRings<Shape::k_corners>;
    static constexpr int k_corners = Shape::k_corners;
    using Star = detail::Star<k_corners>;

    Kind kind = Kind::regular;
    std::uint8_t turn = 0;  ///< star: the corner of the cell that is (0, 0) of the star
    std::uint8_t depth = 0;
    std::atomic<PatchQuarters<Shape>*> quarters{nullptr};
    std::atomic<std::uint64_t>* bytes = nullptr;  ///< bytes of all trees, to which a node adds what it grows
    typename Shape::Patch patch;                  ///< irregular cells: only the corners' limit positions
    std::unique_ptr<const Star> star;
    std::unique_ptr<Rings> rings;  ///< generic

    PatchNode() = default;
    PatchNode(const PatchNode&) = delete;
    PatchNode& operator=(const PatchNode&) = delete;
    /// Deletes all cells below; no other thread may be reading them.
    ~PatchNode() { delete quarters.load(std::memory_order_acquire); }

    /// The four quarters, grown at the first call; every thread would build the same bits.
    const PatchNode* grown() const;
    /// Limit position of a corner.
    Vec3d corner(int k) const {
        return kind == Kind::regular ? Shape::position(patch, cell_corner(k, k_corners))
                                     : Shape::corner_point(patch, k);
    }
    /// Number in the star of a corner of the cell.
    int in_star(int corner) const { return (corner - turn + k_corners) % k_corners; }
    /// The corner of an irregular cell at a point; in very deep cells, the corner of the point's quarter; -1: none.
    int corner_at(const Vec2d& at) const {
        constexpr int k_deepest = 52;  // below this a cell is a point: parameters have no more bits
        return is_cell_corner(at) || depth > k_deepest ? quarter_of(at, k_corners) % k_corners : -1;
    }
    /// Becomes the cell of a star; `corner` is the cell's corner that is (0, 0) of the star.
    void become(Star of, int corner) {
        if (of.regular()) {
            patch = typename Shape::Patch{net_of(of, corner)};
            return;
        }
        kind = Kind::star;
        turn = static_cast<std::uint8_t>(corner);
        star = std::make_unique<const Star>(std::move(of));
        for (int k = 0; k < k_corners; ++k) Shape::set_corner_point(patch, k, detail::corner_limit(*star, in_star(k)));
    }
    /// Becomes the cell of these rings: regular or a star if that represents it exactly, else generic.
    void become(Rings of) {
        if (become_simpler(of)) return;
        kind = Kind::generic;
        rings = std::make_unique<Rings>(std::move(of));
        for (int k = 0; k < k_corners; ++k)
            Shape::set_corner_point(patch, k, rings->corner[static_cast<std::size_t>(k)].limit().position);
    }
    /// Becomes a regular cell or a star if one represents the rings exactly; else returns false.
    bool become_simpler(const Rings& of) {
        constexpr int k_per_edge = Star::k_per_edge;
        std::array<OuterPoints, Shape::k_corners> beyond;
        typename Star::Valences valence;
        int corner = 0, special = 0, crease = -1;
        for (std::size_t k = 0; k < beyond.size(); ++k) {
            beyond[k] = Shape::beyond(of.corner[k]);
            if (beyond[k].empty()) return false;
            valence[k] = (static_cast<int>(beyond[k].size()) + 3 * k_per_edge - 1) / k_per_edge;
            if (valence[k] != Star::k_regular) corner = static_cast<int>(k), ++special;
            if (is_semi_sharp(of.side_sharpness(k))) crease = static_cast<int>(k), ++special;
        }
        if (k_corners == 4 && special > 1) return false;
        std::ranges::rotate(valence, valence.begin() + corner);
        Star of_rings;
        of_rings.resize(valence);
        for (int k = 0; k < k_corners; ++k) {
            const auto from = static_cast<std::size_t>((corner + k) % k_corners);
            of_rings.points[static_cast<std::size_t>(k)] = of.corner[from].centre;
            for (int i = 2 * k_per_edge; const Vec3d& p : beyond[from])
                of_rings.points[of_rings.ring_place(k, i++)] = p;
        }
        become(std::move(of_rings), corner);
        if constexpr (k_corners == 4)
            if (crease >= 0)
                patch.crease = {static_cast<std::int8_t>(crease), of.side_sharpness(static_cast<std::size_t>(crease))};
        return true;
    }
    /// Bytes of its star or rings; neither the node itself nor its quarters.
    std::uint64_t own_bytes() const { return (star ? star->memory_bytes() : 0) + (rings ? rings->memory_bytes() : 0); }
};

/// The four quarters of a node, allocated as one block.
template <class Shape>
struct PatchQuarters : PoolNew {
    std::array<PatchNode<Shape>, 4> cell;
};

template <class Shape>
const PatchNode<Shape>* PatchNode<Shape>::grown() const {
    auto& slot = const_cast<PatchNode*>(this)->quarters;
    if (const PatchQuarters<Shape>* found = slot.load(std::memory_order_acquire)) return found->cell.data();
    auto fresh = std::make_unique_for_overwrite<PatchQuarters<Shape>>();
    for (PatchNode& child : fresh->cell) {
        child.depth = static_cast<std::uint8_t>(depth + 1);
        child.bytes = bytes;
    }
    if (kind == Kind::star) {
        std::array<Star, 4> grown;
        subdivide(*star, grown);
        for (int k = 0; k < 4; ++k) {
            const int corner = k < k_corners ? (k + turn) % k_corners : turn;
            fresh->cell[static_cast<std::size_t>(k < k_corners ? corner : k)].become(
                std::move(grown[static_cast<std::size_t>(k)]), corner);
        }
    } else {
        auto children = rings->children();
        for (std::size_t k = 0; k < 4; ++k) fresh->cell[k].become(std::move(children[k]));
    }
    std::uint64_t taken = sizeof(*fresh);
    for (const PatchNode& child : fresh->cell) taken += child.own_bytes();
    PatchQuarters<Shape>* expected = nullptr;
    if (!slot.compare_exchange_strong(expected, fresh.get(), std::memory_order_acq_rel)) return expected->cell.data();
    bytes->fetch_add(taken, std::memory_order_relaxed);
    return fresh.release()->cell.data();
}

}  // namespace detail

/// Patch trees of a control mesh: exact evaluation of the limit surface at any point. There is one tree per root; its
/// leaves are regular patches, boundary and crease patches included. Trees grow on demand, below a root towards
/// irregular points only, and can be deleted. Thread-safe but for deletion; a result depends on its arguments alone.
/// Source: Stam 1998.
template <class Shape>
class PatchTree {
  public:
    using Node = detail::PatchNode<Shape>;
    PatchTree(const PatchTree&) = delete;
    PatchTree& operator=(const PatchTree&) = delete;

    const ControlMesh& mesh() const { return mesh_; }

    /// The limit surface at parameters (x, y) of a root. On creases and at corners, values are of this root's side.
    SurfacePoint evaluate(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, true); }
    /// The same without second derivatives: cheaper, and the same bits.
    SurfacePoint frame(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, false); }
    /// frame() of a vertex, but on an infinitely sharp edge with the mean of the normals of both sides, and at a
    /// control vertex with the mean of its sectors'.
    SurfacePoint vertex(HalfedgeId root, LatticePoint at, int level) const {
        const Vec2d place = std::ldexp(1.0, -level) * Vec2d(at.x, at.y);
        SurfacePoint point = frame(root, place.x, place.y);
        const auto [h, fraction] = Shape::on_edge(mesh_, root, place);
        if (!h.valid()) return point;
        if (fraction == 0) {
            // Around a control vertex there may be faces of more than four corners; one level down all are quads.
            point.normal = (Node::k_corners == 4 ? ring(h).child() : ring(h)).limit().normal;
        } else if (mesh_.twin(h).valid() && mesh_.sharpness(mesh_.edge(h)) == k_sharpness_infinity) {
            const SurfaceParameter beyond = Shape::in_root(mesh_, mesh_.twin(h), 1 - fraction);
            point.normal = unit_or_zero(point.normal + frame(beyond.root, beyond.x, beyond.y).normal);
        }
        return point;
    }
    /// The position alone, with the same bits: about the cost of one patch.
    Vec3d position(HalfedgeId root, double x, double y) const { return position(root_node(root), {x, y}); }
    /// position() at a lattice point of the root, level <= k_max_level.
    Vec3d limit(HalfedgeId root, LatticePoint at, int level) const {
        const double step = std::ldexp(1.0, -level);
        return position(root, at.x * step, at.y * step);
    }

    const Node& root_node(HalfedgeId root) const {
        const Node* node = roots_[root.value].load(std::memory_order_acquire);
        return node ? *node : made_root(root);
    }

    /// Bytes of all data, those of the trees (forgettable_bytes()) included.
    std::uint64_t memory_bytes() const { return roots_.size() * sizeof(roots_[0]) + forgettable_bytes(); }
    std::uint64_t forgettable_bytes() const { return tree_bytes_.load(std::memory_order_relaxed); }
    /// Bytes that trees may take before they should be deleted: enough for all trees of an ordinary model, unless that
    /// is much of the memory allowed.
    std::uint64_t bytes_to_keep() const {
        constexpr std::uint64_t k_least = 16 << 20, k_ordinary = 64 << 20, k_of_root = 256, k_share = 16;
        const std::uint64_t allowed = most_memory_ == 0 ? k_ordinary : std::min(k_ordinary, most_memory_ / k_share);
        return std::max({k_least, allowed, k_of_root * roots_.size()});
    }
    /// Deletes all trees and so all nodes; no other thread may be reading them.
    void forget_trees() const {
        for_each_index(
            static_cast<std::uint32_t>(roots_.size()),
            [&](std::uint32_t root) { delete roots_[root].exchange(nullptr, std::memory_order_acquire); }, 1024);
        tree_bytes_.store(0, std::memory_order_relaxed);
    }
    /// The limit position at a point of a cell.
    static Vec3d position(const Node& cell, Vec2d at) {
        const Node* node = &cell;
        while (node->kind != Node::Kind::regular) {
            if (const int corner = node->corner_at(at); corner >= 0) return node->corner(corner);
            const int quarter = detail::quarter_of(at, Node::k_corners);
            at = detail::in_quarter(at, quarter, Node::k_corners);
            node = node->grown() + quarter;
        }
        return Shape::position(node->patch, at);
    }
    /// Limit of a corner of a generic cell, or of an extraordinary one of a star: position, two tangents, normal.
    static SurfacePoint corner_limit(const Node& node, int corner) {
        if (node.kind == Node::Kind::generic) return node.rings->corner[static_cast<std::size_t>(corner)].limit();
        return node.star->corner_ring(node.in_star(corner)).limit();
    }

  protected:
    PatchTree(const ControlMesh& mesh, const RunContext& context)
        : mesh_(mesh), roots_(mesh.halfedge_count()), most_memory_(context.max_memory_bytes) {}
    ~PatchTree() { forget_trees(); }

    /// Makes a new node the cell of a root.
    virtual void build_root(HalfedgeId root, Node& node) const = 0;
    /// The ring of the control vertex that a half-edge leaves.
    virtual detail::CornerRing ring(HalfedgeId h) const = 0;

    const ControlMesh& mesh_;

  private:
    SurfacePoint evaluate(HalfedgeId root, double x, double y, bool second) const {
        const Node* node = &root_node(root);
        Vec2d at(x, y);
        std::optional<Vec3d> kept;  // with the bits of position()
        double scale = 1;
        while (node->kind != Node::Kind::regular) {
            if (const int corner = node->corner_at(at); corner >= 0) {
                if (!kept) kept = node->corner(corner);
                if (node->kind == Node::Kind::generic || node->star->is_extraordinary(node->in_star(corner))) {
                    SurfacePoint point = corner_limit(*node, corner);
                    point.position = *kept;
                    return point;
                }
            }
            const int quarter = detail::quarter_of(at, Node::k_corners);
            at = detail::in_quarter(at, quarter, Node::k_corners);
            scale *= quarter < Node::k_corners ? 2 : -2;
            node = node->grown() + quarter;
        }
        SurfacePoint point = Shape::evaluate(node->patch, at, second);
        if (kept) point.position = *kept;
        point.du *= scale, point.dv *= scale;
        point.has_second = second;
        point.normal = unit_or_zero(glm::cross(point.du, point.dv));
        if (second) point.duu *= scale * scale, point.duv *= scale * scale, point.dvv *= scale * scale;
        return point;
    }

    const Node& made_root(HalfedgeId root) const {
        auto fresh = std::make_unique_for_overwrite<Node>();
        fresh->bytes = &tree_bytes_;
        build_root(root, *fresh);
        Node* known = nullptr;
        if (!roots_[root.value].compare_exchange_strong(known, fresh.get(), std::memory_order_acq_rel)) return *known;
        tree_bytes_.fetch_add(sizeof(Node) + fresh->own_bytes(), std::memory_order_relaxed);
        return *fresh.release();
    }

    mutable detail::PoolVector<std::atomic<Node*>> roots_;  ///< null until first used
    mutable std::atomic<std::uint64_t> tree_bytes_{0};
    std::uint64_t most_memory_;  ///< of the whole run; 0: no limit
};

namespace detail {

/// for_each_reported() for a body that evaluates patches. After each batch, all trees are deleted if they take more
/// than bytes_to_keep(). Some are grown again, but memory does not grow with the number of irregular cells. A batch is
/// half as long as the last one if trees have grown much, else twice as long.
/// @param patches  null: the body evaluates none
template <class Patches, class Body>
void for_each_batch(const Patches* patches, std::uint32_t count, std::uint32_t grain, const RunContext& context,
                    std::string_view stage, double from, double to, Body&& body) {
    if (!patches) return for_each_reported(count, grain, context, stage, from, to, std::forward<Body>(body));
    constexpr std::uint32_t k_reports = 64, k_grains = 16, k_least = 4;
    const std::uint32_t most = std::max(context.progress ? count / k_reports + 1 : count, k_grains * grain);
    std::uint32_t batch = k_least * grain;
    for (std::uint32_t begin = 0; begin < count;) {
        context.report(stage, from + (to - from) * begin / count);
        const std::uint64_t before = patches->forgettable_bytes();
        const std::uint32_t size = std::min(batch, count - begin);
        for_each_index(
            size, [&](std::uint32_t i) { body(begin + i); }, grain);
        begin += size;
        const std::uint64_t now = patches->forgettable_bytes();
        const bool large = 4 * (now - before) > patches->bytes_to_keep();
        batch = large ? std::max(batch / 2, k_least * grain) : batch <= most / 2 ? 2 * batch : most;
        if (now > patches->bytes_to_keep()) patches->forget_trees();
    }
    context.report(stage, to);
}

}  // namespace detail

}  // namespace tetrakis
