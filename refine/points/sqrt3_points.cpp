#include "sqrt3_points.hpp"

#include "../../hier/base/parallel.hpp"
#include "level_frames.hpp"

#include <algorithm>

namespace tetrakis {

namespace {

constexpr std::size_t k_most_points = 1u << 16;  // kept per level

}  // namespace

std::uint64_t Sqrt3Points::opposite_of_kept(int level, std::uint64_t h) {
    if (!lattice_.has_kept() || level % 2 == 0) return Sqrt3Lattice::none;
    const std::uint64_t side = 3 * Sqrt3Lattice::face(h);
    if (lattice_.twin(level, side) != Sqrt3Lattice::none || lattice_.sharpness(level, side) > 0)
        return Sqrt3Lattice::none;
    return Sqrt3Lattice::prev(lattice_.beyond(level, side));
}

Sqrt3Points::Fan Sqrt3Points::fan(int level, std::uint64_t leaving) {
    Fan fan;
    // Clockwise to the boundary, or all around.
    std::uint64_t start = leaving;
    for (;;) {
        std::uint64_t t = lattice_.twin(level, start);
        if (t == Sqrt3Lattice::none) t = lattice_.beyond(level, start);
        fan.closed = t != Sqrt3Lattice::none;
        if (!fan.closed) break;
        start = Sqrt3Lattice::next(t);
        if (start == leaving) break;
    }
    bool any_cut = !fan.closed;
    for (std::uint64_t h = start;;) {
        fan.leaving.push_back(h);
        const std::uint64_t into = Sqrt3Lattice::prev(h);
        h = lattice_.twin(level, into);
        if (h == Sqrt3Lattice::none) {
            any_cut = true;
            h = lattice_.beyond(level, into);
        }
        if (h == Sqrt3Lattice::none || h == start) break;
    }
    if (fan.closed)
        std::rotate(fan.leaving.begin(), std::min_element(fan.leaving.begin(), fan.leaving.end()), fan.leaving.end());
    const bool kept = lattice_.has_kept() && level % 2 != 0;
    const auto add = [&](std::uint64_t edge, std::uint64_t to) {
        const float sharpness = any_cut ? lattice_.sharpness(level, edge) : 0.0f;
        if (sharpness > 0) fan.sharp.emplace_back(fan.around.size(), sharpness);
        // Flipped, if it were not kept: no edge, and one beyond each of its ends that are opposite.
        const bool flipped = kept && any_cut && !(sharpness > 0) && lattice_.twin(level, edge) == Sqrt3Lattice::none;
        if (!flipped) fan.around.push_back(to);
    };
    for (const std::uint64_t h : fan.leaving) {
        add(h, Sqrt3Lattice::next(h));
        if (!kept || h % 3 != 2) continue;
        if (const std::uint64_t beyond = opposite_of_kept(level, h); beyond != Sqrt3Lattice::none)
            fan.around.push_back(beyond);
    }
    if (!fan.closed) add(Sqrt3Lattice::prev(fan.leaving.back()), Sqrt3Lattice::prev(fan.leaving.back()));
    return fan;
}

detail::Sqrt3Ring Sqrt3Points::ring(int level, std::uint64_t leaving) {
    return ring(level, leaving, fan(level, leaving));
}

detail::Sqrt3Ring Sqrt3Points::ring(int level, std::uint64_t leaving, const Fan& at) {
    detail::Sqrt3Ring ring = sharp_ring(level, leaving, at);
    for (std::size_t i = 0; i < at.around.size(); ++i) ring.around[i] = position(level, at.around[i]);
    return ring;
}

detail::Sqrt3Ring Sqrt3Points::sharp_ring(int level, std::uint64_t leaving, const Fan& at) {
    detail::Sqrt3Ring ring;
    ring.closed = at.closed;
    ring.point = position(level, leaving);
    ring.around.resize(at.around.size());
    ring.sharp = at.sharp;
    if (lattice_.has_tagged_vertices())
        ring.vertex_sharpness = detail::Sqrt3Rules::vertex_sharpness(*mesh_, lattice_.origin(level, leaving), level);
    if (ring.rule() == VertexRule::crease)
        for (const auto& edge : at.sharp) ring.around[edge.first] = position(level, at.around[edge.first]);
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
        // On the cut edge from `near` to `far`, near the first.
        const std::uint64_t s = v.key;
        const bool first = v.kind == Kind::first;
        const std::uint64_t at = first ? s : Sqrt3Lattice::next(s), other = first ? Sqrt3Lattice::next(s) : s;
        if (const std::uint64_t opposite = opposite_of_kept(above, s); opposite != Sqrt3Lattice::none)
            return detail::Sqrt3Rules::beside_smooth(position(above, at), position(above, Sqrt3Lattice::prev(s)),
                                                     position(above, opposite));
        const Fan around = fan(above, at);
        const detail::Sqrt3Ring near = sharp_ring(above, at, around);
        const Vec3d far = position(above, other);
        const Vec3d* beyond = nullptr;
        if (near.rule() == VertexRule::crease) {
            // Of the two ways that the crease goes on, the one that is not to `far`.
            const Sqrt3Vertex one = lattice_.origin(above, around.around[near.sharp[0].first]);
            beyond = &near.around[near.sharp[one == lattice_.origin(above, other) ? 1 : 0].first];
        }
        return detail::Sqrt3Rules::beside(near.point, far, beyond);
    }
    const std::uint64_t before = lattice_.before(level, leaving);
    const Fan around = fan(above, before);
    detail::Sqrt3Ring from = sharp_ring(above, before, around);
    if (from.rule() == VertexRule::smooth || from.rule() == VertexRule::dart) from = ring(above, before, around);
    return rules_.moved(from, above % 2 != 0);
}

bool Sqrt3Points::beside_cut(int level, std::uint64_t leaving) {
    const Fan at = fan(level, leaving);
    return std::any_of(at.leaving.begin(), at.leaving.end(),
                       [&](std::uint64_t h) { return lattice_.sharpness(level, 3 * Sqrt3Lattice::face(h)) > 0; });
}

bool Sqrt3Points::beside_dart(int level, const Fan& at) {
    if (!lattice_.has_lines()) return false;
    return std::any_of(at.sharp.begin(), at.sharp.end(), [&](const auto& edge) {
        const std::uint64_t there = at.around[edge.first];
        return lattice_.origin(level, there).kind == Sqrt3Vertex::Kind::control &&
               ring(level, there).rule() == VertexRule::dart;
    });
}

LimitPoint Sqrt3Points::limit(int level, std::uint64_t leaving) {
    // From the first level that has it, whatever is asked for; where that comes before the second of two steps, only
    // away from the edges that it cuts.
    const Sqrt3Vertex v = lattice_.origin(level, leaving);
    const auto advance = [&](int steps) {
        for (; steps > 0; --steps, ++level) leaving = lattice_.after(level, leaving);
    };
    for (; level > v.birth; --level) leaving = lattice_.before(level, leaving);
    if (level % 2 != 0) {
        if (beside_cut(level, leaving)) advance(1);
        return rules_.limit(ring(level, leaving));
    }
    // Where a sharp edge goes to a dart, from the level where it goes to a point of that edge.
    const Fan around = fan(level, leaving);
    if (!beside_dart(level, around)) return rules_.limit(ring(level, leaving, around));
    advance(2);
    return rules_.limit(ring(level, leaving));
}

namespace {

constexpr std::uint32_t k_site_block = 1024;  // sites that share what they are made of

class Sqrt3LevelSource final : public LevelSource {
  public:
    Sqrt3LevelSource(const ControlMesh& mesh, int max_level) : lattice_(mesh), max_level_(max_level) {}

    int first_level(const Site& site) const override { return site.level; }
    int max_level() const override { return max_level_; }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        for_each_site(sites, [&](Sqrt3Points& points, const Site& site, std::size_t i) {
            out[i] = points.position(level, leaving(points.lattice(), site, level));
        });
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        for_each_site(sites, [&](Sqrt3Points& points, const Site& site, std::size_t i) {
            const detail::Sqrt3Ring ring = points.ring(level, leaving(points.lattice(), site, level));
            const std::size_t count = ring.around.size();
            Vec3d normal(0);
            for (std::size_t k = 0; k + (ring.closed ? 0 : 1) < count; ++k)
                normal += glm::cross(ring.around[k] - ring.point, ring.around[(k + 1) % count] - ring.point);
            out[i] = detail::frame_from(ring.point, normal, ring.around[0] - ring.point);
        });
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        for_each_site(sites, [&](Sqrt3Points& points, const Site& site, std::size_t i) {
            out[i] = points.limit(site.level, leaving(points.lattice(), site, site.level)).position;
        });
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        for_each_site(sites, [&](Sqrt3Points& points, const Site& site, std::size_t i) {
            out[i] = points.limit(site.level, leaving(points.lattice(), site, site.level));
        });
    }

  private:
    template <class Visit>
    void for_each_site(std::span<const Site> sites, const Visit& visit) const {
        for_each_block(static_cast<std::uint32_t>(sites.size()), k_site_block,
                       [&](std::uint32_t begin, std::uint32_t end) {
                           Sqrt3Points points(lattice_);
                           for (std::uint32_t i = begin; i < end; ++i) visit(points, sites[i], i);
                       });
    }
    /// A half-edge that leaves the site's vertex at a level that has it.
    std::uint64_t leaving(Sqrt3Lattice& lattice, const Site& site, int level) const {
        const Sqrt3Vertex v = site_sqrt3(site);
        std::uint64_t h = 0;
        switch (v.kind) {
            case Sqrt3Vertex::Kind::control:
                h = lattice.mesh().vertex_halfedge(VertexId(static_cast<std::uint32_t>(v.key))).value;
                break;
            case Sqrt3Vertex::Kind::centre:
                h = 9 * v.key + 2;
                break;  // of the triangle over the face's first side
            case Sqrt3Vertex::Kind::first:
                h = 3 * v.key;
                break;  // of the one over the cut edge
            case Sqrt3Vertex::Kind::second:
                h = 3 * v.key + 1;
                break;
        }
        for (int k = v.birth; k < level; ++k) h = lattice.after(k, h);
        return h;
    }

    Sqrt3Lattice lattice_;  // has found nothing: copied
    int max_level_;
};

}  // namespace

std::unique_ptr<LevelSource> sqrt3_levels(const ControlMesh& mesh, int max_level) {
    return std::make_unique<Sqrt3LevelSource>(mesh, max_level);
}

}  // namespace tetrakis
