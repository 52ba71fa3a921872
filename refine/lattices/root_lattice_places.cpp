#include "root_lattices.hpp"

#include <array>
#include <span>
#include <utility>

// Places at levels of any depth: the root of a point, places beyond a side, the ring around a place.
namespace tetrakis::detail {

RootPlace RootLattices::own_place(std::uint32_t segments, const RootPlace& at) const {
    if (in_cells_ || is_inside(segments, at.x, at.y)) return at;
    for (std::uint32_t s = 0, h = side_count() * at.root; s < side_count(); ++s, ++h) {
        const auto [along, away] = seen_from(segments, s, {at.x, at.y});
        if (away != 0) continue;
        if (along == 0 || along == segments)
            return place_seen(segments, base_.vertex_halfedge[base_.origin[along == 0 ? h : base_.next(h)]], 0, 0);
        if ((base_.edge_side[h] & 1) != 0) return place_seen(segments, base_.twin[h], segments - along, 0);
        break;
    }
    return at;
}

RootLattices::Around RootLattices::around(std::uint32_t segments, const RootPlace& at) const {
    const bool quads = side_count() == 4;
    Around result;
    const auto add = [&](std::uint32_t h, std::uint32_t a, std::uint32_t b) {
        result.places.push_back(own_place(segments, place_seen(segments, h, a, b)));
    };
    for (std::uint32_t s = 0, h = side_count() * at.root; s < side_count(); ++s, ++h) {
        const auto [along, away] = seen_from(segments, s, {at.x, at.y});
        if (away != 0) continue;
        if (along == 0 || along == segments) {
            const std::uint32_t first = base_.vertex_halfedge[base_.origin[along == 0 ? h : base_.next(h)]];
            std::uint32_t g = first;
            for (;;) {
                add(g, 1, 0);
                if (quads) add(g, 1, 1);
                const std::uint32_t next = base_.twin[base_.prev(g)];
                if (next == none) add(g, 0, 1);
                result.closed = next != none;
                if (next == none || next == first) return result;
                g = next;
            }
        }
        add(h, along + 1, 0);
        if (quads) add(h, along + 1, 1);
        add(h, along, 1);
        add(h, along - 1, 1);
        add(h, along - 1, 0);
        const std::uint32_t t = base_.twin[h], back = segments - along;
        result.closed = t != none;
        if (t == none) return result;
        if (quads) add(t, back + 1, 1);
        add(t, back, 1);
        add(t, back - 1, 1);
        return result;
    }
    result.closed = true;
    using Step = std::pair<int, int>;
    static constexpr std::array<Step, 8> square{{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
    static constexpr std::array<Step, 6> hexagon{{{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};
    for (const auto& [dx, dy] : quads ? std::span<const Step>(square) : std::span<const Step>(hexagon))
        result.places.push_back(own_place(
            segments, {at.root, at.x + static_cast<std::uint32_t>(dx), at.y + static_cast<std::uint32_t>(dy)}));
    return result;
}

RootPlace RootLattices::place_beyond(std::uint32_t segments, std::uint32_t root, std::int64_t x, std::int64_t y) const {
    if (x > 0 && y > 0 && is_inside(segments, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)))
        return {root, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
    const std::uint32_t sides = side_count();
    const auto n = static_cast<std::int64_t>(last_place(segments));
    for (std::uint32_t s = 0; s < sides;) {
        const FarPlace seen = turned_place<FarPlace>(sides == 4, n, s == 0 ? 0 : sides - s, x, y);
        if (seen.y >= 0) {
            ++s;
            continue;
        }
        const std::uint32_t t = base_.twin[sides * root + s];
        root = t / sides;
        const FarPlace there =
            turned_place<FarPlace>(sides == 4, n, t % sides, n - seen.x, in_cells_ ? -seen.y - 1 : -seen.y);
        x = there.x;
        y = there.y;
        s = 0;
    }
    return own_place(segments, {root, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)});
}

}  // namespace tetrakis::detail
