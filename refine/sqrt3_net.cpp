#include "tetrakis/refine/sqrt3_net.hpp"

#include "tetrakis/hier/huge_memory.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tetrakis::detail {

Sqrt3Net::Sqrt3Net(const Sqrt3Levels& levels)
    : mesh_(&levels.lattice().mesh()), levels_(&levels), tagged_(levels.lattice().has_tagged_vertices()) {
    const std::size_t count = levels.vertices.size();
    points_ = reinterpret_cast<Vec3d*>(memory_[0].reserve(3 * count));
    next_points_ = reinterpret_cast<Vec3d*>(memory_[1].reserve(3 * count));
    for (auto* flags : {&has_, &next_has_, &seen_}) resize_large(*flags, count);
    std::copy(mesh_->positions().begin(), mesh_->positions().end(), points_);
    std::fill_n(has_.begin(), mesh_->vertex_count(), std::uint8_t{1});
}

// The ring of the vertex that a half-edge leaves, the first one that does; false where part of it is missing.
bool Sqrt3Net::gather(std::uint32_t leaving) {
    const Sqrt3Level& level = here();
    const std::uint32_t v = level.vertex[leaving];
    if (has_[v] == 0) return false;
    ring_.point = points_[v];
    ring_.closed = true;
    ring_.around.clear();
    ring_.sharp.clear();
    ring_.vertex_sharpness = tagged_ ? Sqrt3Rules::vertex_sharpness(*mesh_, levels_->vertices[v], level_) : 0.0f;
    const bool kept = may_be_flipped();
    for (std::uint32_t h = leaving;;) {
        if (kept && h % 3 == 2 && level.twin[h - 2] == Sqrt3Level::none) return gather_cut(leaving);
        const std::uint32_t w = level.vertex[Sqrt3Level::next(h)];
        if (!Sqrt3Level::there(w) || has_[w] == 0) return false;
        ring_.around.push_back(points_[w]);
        h = level.twin[Sqrt3Level::prev(h)];
        if (h == leaving) break;
        if (h == Sqrt3Level::outside) return false;
        if (h == Sqrt3Level::none) return gather_cut(leaving);
    }
    return true;
}

// Whether kept edges are not as the rules see them: where smooth, they see them flipped.
bool Sqrt3Net::may_be_flipped() const { return level_ % 2 != 0 && levels_->lattice().has_kept(); }

// Whether an edge that the next step cuts is a kept one that is smooth.
bool Sqrt3Net::is_smooth_cut(std::uint32_t h) const {
    const Sqrt3Line* line = here().twin[h] == Sqrt3Level::none ? here().line(h) : nullptr;
    return line != nullptr && !(line->sharpness > 0);
}

// The same where some of the edges are not flipped, as Sqrt3Points::fan() has it.
bool Sqrt3Net::gather_cut(std::uint32_t leaving) {
    const Sqrt3Level& level = here();
    const bool kept = may_be_flipped();
    const auto across = [&](std::uint32_t h) {
        if (level.twin[h] != Sqrt3Level::none) return level.twin[h];
        const Sqrt3Line* line = level.line(h);
        return line != nullptr ? line->beyond : Sqrt3Level::none;
    };
    // Clockwise to the boundary, or all around.
    std::uint32_t start = leaving;
    for (;;) {
        const std::uint32_t t = across(start);
        if (t == Sqrt3Level::outside) return false;
        ring_.closed = t != Sqrt3Level::none;
        if (!ring_.closed) break;
        start = Sqrt3Level::next(t);
        if (start == leaving) break;
    }
    ring_.around.clear();
    around_.clear();
    const auto add = [&](std::uint32_t to) {
        const std::uint32_t w = level.vertex[to];
        if (!Sqrt3Level::there(w) || has_[w] == 0) return false;
        ring_.around.push_back(points_[w]);
        around_.push_back(w);
        return true;
    };
    const auto add_edge = [&](std::uint32_t edge, std::uint32_t to) {
        if (level.twin[edge] == Sqrt3Level::none) {
            const Sqrt3Line* line = level.line(edge);
            const float sharpness = line != nullptr ? line->sharpness : k_sharpness_infinity;
            if (sharpness > 0)
                ring_.sharp.emplace_back(ring_.around.size(), sharpness);
            else if (kept)
                return true;
        }
        return add(to);
    };
    for (std::uint32_t h = start;;) {
        if (!add_edge(h, Sqrt3Level::next(h))) return false;
        if (const std::uint32_t side = h / 3 * 3; kept && h % 3 == 2 && is_smooth_cut(side)) {
            const std::uint32_t beyond = level.line(side)->beyond;
            if (beyond == Sqrt3Level::outside || !add(Sqrt3Level::prev(beyond))) return false;
        }
        const std::uint32_t behind = Sqrt3Level::prev(h);
        h = across(behind);
        if (h == Sqrt3Level::outside) return false;
        if (h == Sqrt3Level::none && !add_edge(behind, behind)) return false;
        if (h == Sqrt3Level::none || h == start) break;
    }
    return true;
}

bool Sqrt3Net::beside_cut(std::uint32_t leaving) const {
    const Sqrt3Level& level = here();
    std::uint32_t h = leaving;
    do {
        if (level.twin[h / 3 * 3] == Sqrt3Level::none && !is_smooth_cut(h / 3 * 3)) return true;
        h = level.twin[Sqrt3Level::prev(h)];
    } while (h != leaving);
    return false;
}

// At its first level, or where that comes before a cut beside it, at the level after (Sqrt3Points::limit()). Of a ring
// that has been gathered.
bool Sqrt3Net::has_limit(std::uint32_t vertex, std::uint32_t leaving) const {
    const int birth = levels_->vertices[vertex].birth;
    if (birth == level_) return level_ % 2 == 0 || !beside_cut(leaving);
    return birth + 1 == level_ && level_ % 2 == 0;
}

void Sqrt3Net::put_limit(const Limits& limits, std::uint32_t leaving, std::uint32_t to) {
    limits.found[to] = 1;
    // What a crease goes to may be a dart (Sqrt3Points::limit()).
    const bool alone =
        !here().lines.empty() && std::any_of(ring_.sharp.begin(), ring_.sharp.end(), [&](const auto& edge) {
            return levels_->vertices[around_[edge.first]].kind == Sqrt3Vertex::Kind::control;
        });
    if (alone) {
        if (!points_alone_) points_alone_.emplace(levels_->lattice());
        const Sqrt3Level& level = here();
        const LimitPoint point = points_alone_->limit(level_, 3 * level.number[leaving / 3] + leaving % 3);
        limits.positions[to] = point.position;
        if (!limits.normals.empty()) limits.normals[to] = point.normal;
    } else if (limits.normals.empty()) {
        limits.positions[to] = rules_.limit_position(ring_);
    } else {
        const LimitPoint point = rules_.limit(ring_);
        limits.positions[to] = point.position;
        limits.normals[to] = point.normal;
    }
}

void Sqrt3Net::add_apex(std::uint32_t face) {
    const Sqrt3Level& level = here();
    const std::uint32_t v = level.apex[face];
    if (v == Sqrt3Level::outside) return;
    std::array<Vec3d, 3> corner;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t w = level.vertex[3 * face + k];
        if (!Sqrt3Level::there(w) || has_[w] == 0) return;
        corner[k] = points_[w];
    }
    if (levels_->vertices[v].kind == Sqrt3Vertex::Kind::centre) {
        next_points_[v] = Sqrt3Rules::centre(corner);
        next_has_[v] = 1;
        return;
    }
    if (is_smooth_cut(3 * face)) {
        const std::uint32_t beyond = level.line(3 * face)->beyond;
        const std::uint32_t w = Sqrt3Level::there(beyond) ? level.vertex[Sqrt3Level::prev(beyond)] : beyond;
        if (!Sqrt3Level::there(w) || has_[w] == 0) return;
        for (std::uint32_t k = 0; k < 2; ++k) {
            const std::uint32_t to = k == 0 ? v : levels_->beside(v);
            next_points_[to] = Sqrt3Rules::beside_smooth(corner[k], corner[2], points_[w]);
            next_has_[to] = 1;
        }
        return;
    }
    for (std::uint32_t k = 0; k < 2; ++k) {
        if (!gather(3 * face + k)) continue;
        const Vec3d* beyond = nullptr;
        if (ring_.rule() == VertexRule::crease) {
            const std::size_t other = around_[ring_.sharp[0].first] == level.vertex[3 * face + 1 - k] ? 1 : 0;
            beyond = &ring_.around[ring_.sharp[other].first];
        }
        const std::uint32_t to = k == 0 ? v : levels_->beside(v);
        next_points_[to] = Sqrt3Rules::beside(corner[k], corner[1 - k], beyond);
        next_has_[to] = 1;
    }
}

void Sqrt3Net::step(const Limits& limits) {
    const Sqrt3Level& level = here();
    const bool last = at_last();
    std::fill(seen_.begin(), seen_.end(), std::uint8_t{0});
    std::fill(next_has_.begin(), next_has_.end(), std::uint8_t{0});
    const auto halfedges = static_cast<std::uint32_t>(level.vertex.size());
    for (std::uint32_t h = 0; h < halfedges; ++h) {
        const std::uint32_t v = level.vertex[h];
        if (!Sqrt3Level::there(v) || seen_[v] != 0) continue;
        seen_[v] = 1;
        const std::uint32_t to = limits.number.empty() ? no_number : limits.number[v];
        const bool asked = to != no_number && limits.found[to] == 0;
        if ((last && !asked) || !gather(h)) continue;
        if (asked && has_limit(v, h)) put_limit(limits, h, to);
        if (last) continue;
        next_points_[v] = rules_.moved(ring_, level_ % 2 != 0);
        next_has_[v] = 1;
    }
    if (last) return;
    for (std::uint32_t f = 0; f < level.face_count(); ++f) add_apex(f);
    std::swap(points_, next_points_);
    std::swap(has_, next_has_);
    ++level_;
}

}  // namespace tetrakis::detail
