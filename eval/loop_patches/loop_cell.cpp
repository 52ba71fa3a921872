#include "loop_cell.hpp"

#include "../surface/local_frame.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <type_traits>

namespace tetrakis::detail {

namespace {

Vec3d edge_point(const Vec3d& a, const Vec3d& b, const Vec3d& left, const Vec3d& right) {
    return Loop::edge_end * (a + b) + Loop::edge_opposite * (left + right);
}

Vec3d regular_vertex_point(const Vec3d& c, const Vec3d& a, const Vec3d& b, const Vec3d& d, const Vec3d& e,
                           const Vec3d& f, const Vec3d& g) {
    return 0.625 * c + 0.0625 * ((a + b) + (d + e) + (f + g));
}

/// Six neighbours, counter-clockwise from the cell's next corner, with which the regular rules give what this ring's
/// rules give, at this level and below, on the cell's side; empty if there are none. Across a boundary or crease with
/// three triangles on the cell's side the missing neighbours are reflected: c + p_0 - p_1; at a corner with a single
/// triangle, through the centre too.
std::optional<std::array<Vec3d, 6>> regular_neighbours(const CornerRing& ring) {
    const int cell = ring.cell;
    const Vec3d& centre = ring.centre;
    std::array<Vec3d, 6> out;
    if (ring.is_smooth()) {
        if (ring.size() != 6) return {};
        for (int i = 0; i < 6; ++i) out[i] = ring.spoke(cell + i).point;
        return out;
    }
    const auto sector = ring.sector();
    if (!ring.is_stationary() || !sector) return {};
    const auto [first, faces, corner] = *sector;
    const int offset = cell - first;
    const auto p = [&ring, first = first](int i) { return ring.spoke(first + i).point; };
    if (!corner && faces == 3) {
        const std::array<Vec3d, 6> around{p(0), p(1), p(2), p(3), centre + p(3) - p(2), centre + p(0) - p(1)};
        for (int i = 0; i < 6; ++i) out[i] = around[(i + offset) % 6];
        return out;
    }
    if (corner && faces == 1)
        return std::array<Vec3d, 6>{
            p(0), p(1), centre + p(1) - p(0), 2.0 * centre - p(0), 2.0 * centre - p(1), centre + p(0) - p(1)};
    return {};
}

}  // namespace

void loop_star_step(int n, double beta, const Vec3d* star, Vec3d* step) {
    const Vec3d& c = star[0];
    const Vec3d* ring = star + 1;
    const Vec3d* out = star + n + 1;
    const Vec3d &a = ring[0], &b = ring[1], &before = ring[n - 1], &after = ring[n == 2 ? 0 : 2];
    Vec3d sum = ring[0];
    for (int i = 1; i < n; ++i) sum += ring[i];
    step[0] = (1 - n * beta) * c + beta * sum;
    step[1] = edge_point(c, ring[0], ring[n - 1], ring[1]);
    for (int i = 1; i < n - 1; ++i) step[1 + i] = edge_point(c, ring[i], ring[i - 1], ring[i + 1]);
    step[n] = edge_point(c, ring[n - 1], ring[n - 2], ring[0]);
    Vec3d* o = step + n + 1;
    o[0] = edge_point(a, before, c, out[0]);
    o[1] = regular_vertex_point(a, c, b, out[2], out[1], out[0], before);
    o[2] = edge_point(a, b, c, out[2]);
    o[3] = regular_vertex_point(b, c, a, out[2], out[3], out[4], after);
    o[4] = edge_point(b, after, c, out[4]);
    o[5] = edge_point(a, out[0], before, out[1]);
    o[6] = edge_point(a, out[1], out[0], out[2]);
    o[7] = edge_point(a, out[2], out[1], b);
    o[8] = edge_point(b, out[2], a, out[3]);
    o[9] = edge_point(b, out[4], out[3], after);
    o[10] = edge_point(b, out[3], out[2], out[4]);
}

void loop_star_quarter(int n, const Vec3d* step, int quarter, Net12& out) {
    const int o = n + 1, after = n == 2 ? 1 : 3;  // the outer points; (-1,1); ring point n is (1,-1)
    const auto gather = [&](const std::array<int, 12>& from) {
        for (std::size_t i = 0; i < 12; ++i) out[i] = step[from[i]];
    };
    if (quarter == 1)
        gather({1, o + 1, o + 2, 2, 0, n, o + 0, o + 5, o + 6, o + 7, o + 8, o + 3});
    else if (quarter == 2)
        gather({2, o + 2, o + 3, o + 4, after, 0, 1, o + 1, o + 7, o + 8, o + 10, o + 9});
    else
        gather({o + 2, 2, 1, o + 1, o + 7, o + 8, o + 3, o + 4, after, 0, n, o + 0});
}

LoopVertexRule loop_vertex_rule(int valence) {
    constexpr int k_common = 32;
    const auto make = [](int n) { return LoopVertexRule{Loop::beta(n), Loop::limit_mask(n)}; };
    static const auto table = [&] {
        std::array<LoopVertexRule, k_common + 1> rules;
        for (int n = 1; n <= k_common; ++n) rules[static_cast<std::size_t>(n)] = make(n);
        return rules;
    }();
    return valence <= k_common ? table[static_cast<std::size_t>(valence)] : make(valence);
}

Vec3d loop_star_limit(int n, const Vec3d* star) {
    const RingMask mask = loop_vertex_rule(n).limit;
    Vec3d sum = star[1];
    for (int i = 2; i <= n; ++i) sum += star[i];
    return mask.vertex * star[0] + mask.edge * sum;
}

Vec3d loop_star_corner(int n, const Vec3d* star, int corner) {
    const Vec3d* ring = star + 1;
    const Vec3d* o = star + n + 1;
    const Vec3d &a = ring[0], &b = ring[1], &before = ring[n - 1], &after = ring[n == 2 ? 0 : 2];
    const Vec3d sum =
        corner == 1 ? (star[0] + b) + (o[2] + o[1]) + (o[0] + before) : (star[0] + a) + (o[2] + o[3]) + (o[4] + after);
    return 0.5 * (corner == 1 ? a : b) + (1.0 / 12) * sum;
}

LoopStarChain& LoopStarChain::make(RecordPool& pool, int valence, int size) {
    static_assert(sizeof(LoopStarChain) % alignof(Vec3d) == 0 && std::is_trivially_destructible_v<LoopStarChain>);
    void* memory = pool.allocate(sizeof(LoopStarChain) + static_cast<std::size_t>(size) * sizeof(Vec3d));
    auto* link = new (memory) LoopStarChain(pool, valence);
    std::uninitialized_fill_n(link->points(), size, Vec3d(0));
    return *link;
}

const LoopStarChain& LoopStarChain::next() const {
    LoopStarChain* known = next_.load(std::memory_order_acquire);
    if (known != nullptr) return *known;
    LoopStarChain& fresh = make(*pool_, valence_, loop_star_step_size(valence_));
    loop_star_step(valence_, loop_vertex_rule(valence_).beta, points(), fresh.points());
    return next_.compare_exchange_strong(known, &fresh, std::memory_order_acq_rel) ? fresh : *known;
}

std::array<LoopRings, 4> LoopRings::children() const {
    std::array<LoopRings, 4> out;
    const std::array<CornerRing, 3> child{corner[0].child(), corner[1].child(), corner[2].child()};
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        out[k].corner[k] = child[k];
        CornerRing middle = side_ring(corner[k], corner[next], child[k], child[next]);
        middle.cell = 2;
        out[k].corner[next] = middle;
        middle.cell = 0;
        out[next].corner[k] = middle;
        middle.cell = 1;
        out[3].corner[(k + 2) % 3] = std::move(middle);
    }
    return out;
}

std::optional<Net12> LoopRings::regular_net() const {
    const auto a = regular_neighbours(corner[0]);
    if (!a) return {};
    const auto b = regular_neighbours(corner[1]);
    if (!b) return {};
    const auto c = regular_neighbours(corner[2]);
    if (!c) return {};
    return Net12{corner[0].centre, corner[1].centre, corner[2].centre, (*a)[2], (*a)[3], (*a)[4],
                 (*a)[5],          (*b)[3],          (*b)[4],          (*b)[5], (*c)[3], (*c)[4]};
}

int LoopRings::star_corner() const {
    for (int k = 0; k < 3; ++k)
        if (corner[k].is_smooth() && corner[k].size() != 6)
            return regular_neighbours(corner[(k + 1) % 3]) && regular_neighbours(corner[(k + 2) % 3]) ? k : -1;
    return -1;
}

std::vector<Vec3d> LoopRings::star_points(int k) const {
    const CornerRing& centre = corner[k];
    std::vector<Vec3d> out{centre.centre};
    for (int i = 0; i < centre.size(); ++i) out.push_back(centre.spoke(centre.cell + i).point);
    const auto a = *regular_neighbours(corner[(k + 1) % 3]);
    const auto b = *regular_neighbours(corner[(k + 2) % 3]);
    out.insert(out.end(), {a[3], a[4], a[5], b[3], b[4]});
    return out;
}

std::vector<Vec3d> LoopRings::points() const {
    std::vector<Vec3d> out;
    for (const CornerRing& ring : corner) ring.add_points(out);
    return out;
}

LoopNode::LoopNode(LoopRings rings, RecordPool& pool) : pool_(&pool) {
    if (const auto net = rings.regular_net()) {
        cell_.net = *net;
    } else if (const int corner = rings.star_corner(); corner >= 0) {
        const int valence = rings.corner[corner].size();
        LoopStarChain& star = LoopStarChain::make(pool, valence, loop_star_size(valence));
        std::ranges::copy(rings.star_points(corner), star.points());
        cell_.kind = LoopCell::Kind::star;
        cell_.turn = corner;
        cell_.star = &star;
    } else {
        cell_.kind = LoopCell::Kind::generic;
        cell_.node = this;
        rings_ = std::make_unique<LoopRings>(std::move(rings));
    }
}

LoopNode::~LoopNode() { delete children_.load(std::memory_order_relaxed); }

const LoopNode& LoopNode::child(int quarter) const {
    Children* known = children_.load(std::memory_order_acquire);
    if (known == nullptr) {
        auto fresh = std::make_unique<Children>();
        std::array<LoopRings, 4> rings = rings_->children();
        for (int i = 0; i < 4; ++i) (*fresh)[i] = std::make_unique<LoopNode>(std::move(rings[i]), *pool_);
        if (children_.compare_exchange_strong(known, fresh.get(), std::memory_order_acq_rel)) known = fresh.release();
    }
    return *(*known)[quarter];
}

}  // namespace tetrakis::detail
