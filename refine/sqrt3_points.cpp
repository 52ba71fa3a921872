#include "tetrakis/refine/sqrt3_points.hpp"

#include <algorithm>

namespace tetrakis {

namespace {

constexpr std::size_t k_most_points = 1u << 16;  // kept per level

}  // namespace

Sqrt3Points::Fan Sqrt3Points::fan(int level, std::uint64_t leaving) {
    Fan fan;
    // Clockwise to the boundary, or all around.
    std::uint64_t start = leaving;
    for (;;) {
        const std::uint64_t t = lattice_.twin(level, start);
        if (t == Sqrt3Lattice::none) break;
        start = Sqrt3Lattice::next(t);
        if (start == leaving) break;
    }
    fan.closed = lattice_.twin(level, start) != Sqrt3Lattice::none;
    for (std::uint64_t h = start;;) {
        fan.leaving.push_back(h);
        h = lattice_.ccw(level, h);
        if (h == Sqrt3Lattice::none || h == start) break;
    }
    if (fan.closed)
        std::rotate(fan.leaving.begin(), std::min_element(fan.leaving.begin(), fan.leaving.end()), fan.leaving.end());
    return fan;
}

detail::Sqrt3Ring Sqrt3Points::ring(int level, std::uint64_t leaving) {
    const Fan at = fan(level, leaving);
    detail::Sqrt3Ring ring;
    ring.closed = at.closed;
    ring.corner = detail::Sqrt3Rules::is_corner(*mesh_, lattice_.origin(level, leaving));
    ring.point = position(level, leaving);
    for (const std::uint64_t h : at.leaving) ring.around.push_back(position(level, Sqrt3Lattice::next(h)));
    if (!at.closed) ring.around.push_back(position(level, Sqrt3Lattice::prev(at.leaving.back())));
    return ring;
}

Vec3d Sqrt3Points::position(int level, std::uint64_t leaving) {
    const Sqrt3Vertex v = lattice_.origin(level, leaving);
    if (level == 0) return mesh_->position(VertexId(static_cast<std::uint32_t>(v.key)));
    if (known_.size() <= static_cast<std::size_t>(level)) known_.resize(static_cast<std::size_t>(level) + 1);
    const auto& known = known_[static_cast<std::size_t>(level)];
    if (const auto at = known.find(v); at != known.end()) return at->second;
    const Vec3d p = compute(level, leaving, v);
    auto& points = known_[static_cast<std::size_t>(level)];
    if (points.size() > k_most_points) points.clear();
    points.emplace(v, p);
    return p;
}

Vec3d Sqrt3Points::compute(int level, std::uint64_t leaving, const Sqrt3Vertex& v) {
    const int above = level - 1;
    using Kind = Sqrt3Vertex::Kind;
    if (v.birth == level && v.kind == Kind::centre)
        return detail::Sqrt3Rules::centre(
            {position(above, 3 * v.key), position(above, 3 * v.key + 1), position(above, 3 * v.key + 2)});
    if (v.birth == level) {
        // On the boundary edge from `near` to `far`, near the first.
        const std::uint64_t s = v.key;
        const bool first = v.kind == Kind::first;
        const std::uint64_t at = first ? s : Sqrt3Lattice::next(s);
        const detail::Sqrt3Ring near = ring(above, at);
        const Vec3d far = position(above, first ? Sqrt3Lattice::next(s) : s);
        return detail::Sqrt3Rules::beside(near.point, far,
                                          near.corner ? nullptr : &(first ? near.around.back() : near.around.front()));
    }
    return rules_.moved(ring(above, lattice_.before(level, leaving)), above % 2 != 0);
}

LimitPoint Sqrt3Points::limit(int level, std::uint64_t leaving) {
    // From the first level that has it, whatever is asked for; where that comes before the second of two steps, only
    // inside and away from the edges that it cuts.
    const Sqrt3Vertex v = lattice_.origin(level, leaving);
    for (; level > v.birth; --level) leaving = lattice_.before(level, leaving);
    if (level % 2 != 0) {
        const Fan at = fan(level, leaving);
        bool inside = at.closed;
        for (const std::uint64_t h : at.leaving)
            inside = inside && lattice_.twin(level, 3 * Sqrt3Lattice::face(h)) != Sqrt3Lattice::none;
        if (!inside) {
            leaving = lattice_.after(level, leaving);
            ++level;
        }
    }
    return rules_.limit(ring(level, leaving));
}

}  // namespace tetrakis
