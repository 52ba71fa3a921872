#include "tetrakis/refine/sqrt3_points.hpp"

#include "tetrakis/schemes/ring_mask.hpp"
#include "tetrakis/schemes/sqrt3.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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

bool Sqrt3Points::is_corner(const Sqrt3Vertex& v) const {
    return v.kind == Sqrt3Vertex::Kind::control && mesh_->sharpness(VertexId(static_cast<std::uint32_t>(v.key))) > 0;
}

std::vector<Vec3d> Sqrt3Points::ring(int level, const Fan& fan) {
    std::vector<Vec3d> points;
    for (const std::uint64_t h : fan.leaving) points.push_back(position(level, Sqrt3Lattice::next(h)));
    if (!fan.closed) points.push_back(position(level, Sqrt3Lattice::prev(fan.leaving.back())));
    return points;
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
    if (v.birth == level && v.kind == Kind::centre) {
        Vec3d sum(0);
        for (std::uint64_t h = 3 * v.key; h < 3 * v.key + 3; ++h) sum += (1.0 / 3) * position(above, h);
        return sum;
    }
    if (v.birth == level) {
        // On the boundary edge from `near` to `far`, near the first.
        const std::uint64_t s = v.key;
        const bool first = v.kind == Kind::first;
        const std::uint64_t at = first ? s : Sqrt3Lattice::next(s);
        const Vec3d near = position(above, at), far = position(above, first ? Sqrt3Lattice::next(s) : s);
        Vec3d p = Sqrt3::crease_middle * near + Sqrt3::crease_near * far;
        if (is_corner(lattice_.origin(above, at))) return p + Sqrt3::crease_far * (2.0 * near - far);
        const std::vector<Vec3d> around = ring(above, fan(above, at));
        return p + Sqrt3::crease_far * (first ? around.back() : around.front());
    }
    const std::uint64_t old = lattice_.before(level, leaving);
    const Vec3d p = position(above, old);
    const Fan at = fan(above, old);
    if (!at.closed) {
        if (above % 2 == 0 || is_corner(v)) return p;
        const std::vector<Vec3d> around = ring(above, at);
        return Sqrt3::crease_vertex * p + Sqrt3::crease_neighbour * around.front() +
               Sqrt3::crease_neighbour * around.back();
    }
    const RingMask mask = Sqrt3::vertex_mask(static_cast<int>(at.leaving.size()));
    Vec3d sum = mask.vertex * p;
    for (const Vec3d& q : ring(above, at)) sum += mask.edge * q;
    return sum;
}

LimitPoint Sqrt3Points::limit(int level, std::uint64_t leaving) {
    // The masks are those of the levels before the first of two steps.
    if (level % 2 != 0) {
        leaving = lattice_.after(level, leaving);
        ++level;
    }
    const Sqrt3Vertex v = lattice_.origin(level, leaving);
    // From the first such level that has it, whatever is asked for.
    for (; level > v.birth + 1; level -= 2) leaving = lattice_.before(level - 1, lattice_.before(level, leaving));
    const Fan at = fan(level, leaving);
    const Vec3d p = position(level, leaving);
    const std::vector<Vec3d> around = ring(level, at);
    LimitPoint out;
    if (!at.closed) {
        out.position = is_corner(v) ? p
                                    : k_crease_limit_mask.vertex * p + k_crease_limit_mask.neighbour * around.front() +
                                          k_crease_limit_mask.neighbour * around.back();
        Vec3d normal(0);
        for (std::size_t i = 0; i + 1 < around.size(); ++i) {
            const Vec3d face = glm::cross(around[i] - p, around[i + 1] - p);
            if (const double length = glm::length(face); length > 0) normal += face / length;
        }
        if (const double length = glm::length(normal); length > 0) out.normal = normal / length;
        return out;
    }
    const int n = static_cast<int>(around.size());
    const RingMask mask = Sqrt3::limit_mask(n);
    out.position = mask.vertex * p;
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        out.position += mask.edge * around[static_cast<std::size_t>(i)];
        out.tangent1 += std::cos(angle) * around[static_cast<std::size_t>(i)];
        out.tangent2 += std::sin(angle) * around[static_cast<std::size_t>(i)];
    }
    const Vec3d normal = glm::cross(out.tangent1, out.tangent2);
    if (const double length = glm::length(normal); length > 0) {
        out.normal = normal / length;
        out.has_tangent_plane = true;
    }
    return out;
}

}  // namespace tetrakis
