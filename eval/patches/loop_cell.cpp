#include "loop_cell.hpp"

#include "../surface/local_frame.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <type_traits>

namespace tetrakis::detail {

LoopStarChain& LoopStarChain::make(RecordPool& pool, int valence, int size) {
    static_assert(sizeof(LoopStarChain) % alignof(Vec3d) == 0 && std::is_trivially_destructible_v<LoopStarChain>);
    void* memory = pool.allocate(sizeof(LoopStarChain) + static_cast<std::size_t>(size) * sizeof(Vec3d));
    auto* link = new (memory) LoopStarChain(pool, valence);
    std::uninitialized_fill_n(link->points(), size, Vec3d(0));
    return *link;
}

void LoopStarChain::find_reach() {
    const Vec3d& centre = *points();
    double most = 0;
    for (const Vec3d& p : std::span(points(), static_cast<std::size_t>(loop_star_size(valence_))))
        most = std::max(most, glm::dot(p - centre, p - centre));
    reach_ = round_up(std::sqrt(most));
}

const LoopStarChain& LoopStarChain::next() const {
    LoopStarChain* known = next_.load(std::memory_order_acquire);
    if (known != nullptr) return *known;
    LoopStarChain& fresh = make(*pool_, valence_, loop_star_step_size(valence_));
    loop_star_step(valence_, loop_vertex_rule(valence_).beta, points(), fresh.points());
    fresh.find_reach();
    return next_.compare_exchange_strong(known, &fresh, std::memory_order_acq_rel) ? fresh : *known;
}

LoopNode::LoopNode(LoopRings rings, RecordPool& pool) : pool_(&pool) {
    if (const auto net = rings.regular_net()) {
        kind_ = LoopCell::Kind::regular;
        net_ = std::make_unique<Net12>(*net);
        return;
    }
    if (const int corner = rings.star_corner(); corner >= 0) {
        kind_ = LoopCell::Kind::star;
        turn_ = corner;
        const int valence = rings.corner[corner].size();
        star_ = &LoopStarChain::make(pool, valence, loop_star_size(valence));
        const std::vector<Vec3d> points = rings.star_points(corner);
        std::copy(points.begin(), points.end(), star_->points());
        star_->find_reach();
        return;
    }
    rings_ = std::make_unique<LoopRings>(std::move(rings));
}

LoopNode::~LoopNode() { delete children_.load(std::memory_order_relaxed); }

void LoopNode::cell(LoopCell& out) const {
    out.kind = kind_;
    out.turn = turn_;
    if (net_) out.net = *net_;
    out.star = star_;
    out.node = this;
}

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
