#include "tetrakis/refine/sqrt3_net.hpp"

#include "tetrakis/hier/huge_memory.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tetrakis::detail {

Sqrt3Net::Sqrt3Net(const ControlMesh& mesh, const Sqrt3Levels& levels) : mesh_(&mesh), levels_(&levels) {
    const std::size_t count = levels.vertices.size();
    points_ = reinterpret_cast<Vec3d*>(memory_[0].reserve(3 * count));
    next_points_ = reinterpret_cast<Vec3d*>(memory_[1].reserve(3 * count));
    for (auto* flags : {&has_, &next_has_, &seen_}) resize_large(*flags, count);
    std::copy(mesh.positions().begin(), mesh.positions().end(), points_);
    std::fill_n(has_.begin(), mesh.vertex_count(), std::uint8_t{1});
}

// The ring of the vertex that a half-edge leaves, the first one that does; false where part of it is missing.
bool Sqrt3Net::gather(std::uint32_t leaving) {
    const Sqrt3Level& level = here();
    const std::uint32_t v = level.vertex[leaving];
    const auto add = [&](std::uint32_t at) {
        const std::uint32_t w = level.vertex[at];
        if (!Sqrt3Level::there(w) || has_[w] == 0) return false;
        ring_.around.push_back(points_[w]);
        return true;
    };
    if (has_[v] == 0) return false;
    ring_.point = points_[v];
    ring_.corner = false;
    ring_.closed = true;
    ring_.around.clear();
    for (std::uint32_t h = leaving;;) {
        if (!add(Sqrt3Level::next(h))) return false;
        h = level.twin[Sqrt3Level::prev(h)];
        if (h == leaving) return true;
        if (h == Sqrt3Level::outside) return false;
        if (h == Sqrt3Level::none) break;
    }
    ring_.closed = false;
    ring_.corner = Sqrt3Rules::is_corner(*mesh_, levels_->vertices[v]);
    // Clockwise to the boundary, and from there once more.
    std::uint32_t h = leaving;
    for (std::uint32_t t = level.twin[h]; t != Sqrt3Level::none; t = level.twin[h]) {
        if (t == Sqrt3Level::outside) return false;
        h = Sqrt3Level::next(t);
    }
    ring_.around.clear();
    for (;;) {
        if (!add(Sqrt3Level::next(h))) return false;
        const std::uint32_t behind = Sqrt3Level::prev(h), t = level.twin[behind];
        if (t == Sqrt3Level::none) return add(behind);
        h = t;
    }
}

bool Sqrt3Net::beside_cut(std::uint32_t leaving) const {
    const Sqrt3Level& level = here();
    std::uint32_t h = leaving;
    do {
        if (level.twin[h / 3 * 3] == Sqrt3Level::none) return true;
        h = level.twin[Sqrt3Level::prev(h)];
    } while (h != leaving);
    return false;
}

// At its first level, or where that comes before a cut beside it, at the level after (Sqrt3Points::limit()). Of a ring
// that has been gathered.
bool Sqrt3Net::has_limit(std::uint32_t vertex, std::uint32_t leaving) const {
    const int birth = levels_->vertices[vertex].birth;
    if (birth == level_) return level_ % 2 == 0 || (ring_.closed && !beside_cut(leaving));
    return birth + 1 == level_ && level_ % 2 == 0;
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
    for (std::uint32_t k = 0; k < 2; ++k) {
        if (!gather(3 * face + k)) continue;
        const Vec3d& beyond = k == 0 ? ring_.around.back() : ring_.around.front();
        next_points_[v + k] = Sqrt3Rules::beside(corner[k], corner[1 - k], ring_.corner ? nullptr : &beyond);
        next_has_[v + k] = 1;
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
        if (asked && has_limit(v, h)) {
            if (limits.normals.empty()) {
                limits.positions[to] = rules_.limit_position(ring_);
            } else {
                const LimitPoint point = rules_.limit(ring_);
                limits.positions[to] = point.position;
                limits.normals[to] = point.normal;
            }
            limits.found[to] = 1;
        }
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
