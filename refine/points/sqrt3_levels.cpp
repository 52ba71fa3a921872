#include "row_points.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/mesh_check.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../schemes/rules/sqrt3.hpp"
#include "../rules/rule_limit.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

namespace {

/// An edge of a level of refine() that leaves a vertex, and the face to its left.
struct Spoke {
    Site to;
    Site centre;  ///< centre of the face, a vertex on the next level of simple steps
    bool sharp = false, has_face = true;
};

/// The edges around a vertex, counter-clockwise; or the corners of a face, each with the face across its next edge.
struct Ring {
    std::vector<Spoke> spokes;
    bool closed = true;

    /// Whether the first simple step moves the vertex.
    bool is_smooth(float vertex_sharpness) const {
        const auto sharp = std::count_if(spokes.begin(), spokes.end(), [](const Spoke& s) { return s.sharp; });
        return closed && sharp < 2 && !(vertex_sharpness > 0);
    }
};

/// Adjacency of the vertices and faces of a level of refine(), in terms of sites.
class RefinedLevel {
  public:
    RefinedLevel(const ControlMesh& mesh, int level) : mesh_(mesh), level_(level) {
        for (int l = 0; l < level; ++l) segments_ *= 3;
    }

    /// Whether the site's vertex is the centre of a face, which the next simple step makes.
    bool is_centre(const Site& site) const { return site.level > level_; }

    Ring around_vertex(const Site& site) const {
        Ring ring;
        const FaceId root = mesh_.face(site.root);
        if (site.level == 0) {
            const HalfedgeId first = mesh_.vertex_halfedge(control_vertex(site));
            for (HalfedgeId h = first;;) {
                const std::uint32_t k = h.value % 3;
                const Sqrt3Point p = segments_ * unit(k);
                ring.spokes.push_back(
                    spoke(mesh_.face(h), p, unit(k + 1) - unit(k), unit(k + 2) - unit(k), is_sharp(h)));
                const HalfedgeId before = mesh_.prev(h), next = mesh_.twin(before);
                ring.closed = next.valid();
                if (!next.valid()) ring.spokes.push_back(last_spoke(mesh_.face(h), p + unit(k + 2) - unit(k)));
                if (!next.valid() || next == first) return ring;
                h = next;
            }
        }
        Sqrt3Point p{{0, site.at.x, site.at.y}};
        std::int64_t scale = 1;
        for (int l = site.level; l < level_; ++l) scale *= 3;
        p = scale * p;
        p[0] = segments_ - p[1] - p[2];
        std::size_t side = 0;
        while (side < 3 && p[(side + 2) % 3] != 0) ++side;
        const HalfedgeId edge(site.root.value + static_cast<std::uint32_t>(side % 3));
        const bool on_edge = side < 3, sharp = on_edge && is_sharp(edge);
        side %= 3;
        const std::array<Sqrt3Point, 6> way{unit(side + 1) - unit(side),     unit(side + 2) - unit(side),
                                            unit(side + 2) - unit(side + 1), unit(side) - unit(side + 1),
                                            unit(side) - unit(side + 2),     unit(side + 1) - unit(side + 2)};
        ring.closed = !on_edge || mesh_.twin(edge).valid();
        for (std::size_t k = 0; k < (ring.closed ? 6 : 3); ++k)
            ring.spokes.push_back(spoke(root, p, way[k], way[(k + 1) % 6], sharp && k % 3 == 0));
        if (!ring.closed) ring.spokes.push_back(last_spoke(root, p + way[3]));
        return ring;
    }
    /// @param site  the centre of a face
    Ring around_face(const Site& site) const {
        const FaceId root = mesh_.face(site.root);
        const Sqrt3Point p{{3 * segments_ - site.at.x - site.at.y, site.at.x, site.at.y}};
        // Of a face turned by half a turn all coordinates are two above a multiple of three.
        const std::int64_t turned = p[1] % 3 == 1 ? 1 : -1;
        Ring ring;
        for (std::size_t k = 0; k < 3; ++k) {
            const Sqrt3Point to_corner = turned * (3 * unit(k) - unit(0) - unit(1) - unit(2)),
                             beyond = turned * (unit(0) + unit(1) + unit(2) - 3 * unit(k + 2));
            const HalfedgeId edge(site.root.value + static_cast<std::uint32_t>(k));
            const bool sharp = turned > 0 && p[(k + 2) % 3] == 1 && is_sharp(edge);
            ring.spokes.push_back({site_of(root, p + to_corner, level_ + 1),
                                   sharp ? Site{} : site_of(root, p + beyond, level_ + 1), true, !sharp});
        }
        return ring;
    }
    VertexId control_vertex(const Site& site) const {
        return mesh_.origin(HalfedgeId(site.root.value + (site.at.x != 0 ? 1 : site.at.y != 0 ? 2 : 0)));
    }
    /// What is left of the sharpness of a vertex's tag.
    float sharpness(const Site& site) const {
        return site.level > 0 ? 0 : mesh_.sharpness(control_vertex(site)) - static_cast<float>(level_);
    }

  private:
    static Sqrt3Point unit(std::size_t k) {
        Sqrt3Point p;
        p[k % 3] = 1;
        return p;
    }
    bool is_sharp(HalfedgeId h) const {
        return !mesh_.twin(h).valid() || mesh_.sharpness(mesh_.edge(h)) > static_cast<float>(level_);
    }
    Site site_of(FaceId root, const Sqrt3Point& p, int level) const { return sqrt3_site(mesh_, root, p, level); }
    Spoke spoke(FaceId root, const Sqrt3Point& p, const Sqrt3Point& way, const Sqrt3Point& next, bool sharp) const {
        return {site_of(root, p + way, level_), site_of(root, 3 * p + way + next, level_ + 1), sharp, true};
    }
    /// The last edge at a boundary vertex, which has no face to its left.
    Spoke last_spoke(FaceId root, const Sqrt3Point& to) const { return {site_of(root, to, level_), {}, true, false}; }

    const ControlMesh& mesh_;
    int level_;
    std::int64_t segments_ = 1;
};

class Sqrt3Levels final : public LevelSource {
  public:
    Sqrt3Levels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const RunContext& context,
                bool whole_levels, std::shared_ptr<const PositionSource> limit_positions)
        : mesh_(mesh),
          even_(detail::row_points(mesh, scheme, rules, nullptr, context, whole_levels, std::move(limit_positions))) {}

    int first_level(const Site& site) const override { return sqrt3_first_level(site); }
    int max_level() const override { return Sqrt3Lattice::max_level(mesh_); }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        if (level % 2 == 0) return even_->positions(sites, level / 2, out);
        // Points of the level before that the first simple step combines: for a centre the corners of its face,
        // otherwise the vertex itself and, if it moves, its ring.
        const RefinedLevel before(mesh_, level / 2);
        std::vector<Site> from;
        std::vector<std::size_t> begin;
        for (const Site& site : sites) {
            begin.push_back(from.size());
            const bool centre = before.is_centre(site);
            const Ring ring = centre ? before.around_face(site) : before.around_vertex(site);
            if (!centre) from.push_back(site);
            if (centre || ring.is_smooth(before.sharpness(site)))
                for (const Spoke& spoke : ring.spokes) from.push_back(spoke.to);
        }
        begin.push_back(from.size());
        std::vector<Vec3d> points(from.size());
        even_->positions(from, level / 2, points);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const std::span<const Vec3d> p = std::span(points).subspan(begin[i], begin[i + 1] - begin[i]);
            Vec3d around(0);
            for (const Vec3d& q : p.subspan(before.is_centre(sites[i]) ? 0 : 1)) around += q;
            if (before.is_centre(sites[i])) {
                out[i] = around / 3.0;
            } else if (p.size() == 1) {
                out[i] = p[0];
            } else {
                const RingMask mask = Sqrt3::vertex_mask(static_cast<int>(p.size()) - 1);
                out[i] = mask.vertex * p[0] + mask.edge * around;
            }
        }
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        if (level % 2 == 0) return even_->frames(sites, level / 2, out);
        // The step flips all edges except sharp ones.
        const RefinedLevel before(mesh_, level / 2);
        std::vector<Site> all;
        std::vector<std::size_t> begin;
        for (const Site& site : sites) {
            begin.push_back(all.size());
            all.push_back(site);
            const bool centre = before.is_centre(site);
            const Ring ring = centre ? before.around_face(site) : before.around_vertex(site);
            for (const Spoke& spoke : ring.spokes) {
                if (centre || spoke.sharp) all.push_back(spoke.to);
                if (spoke.has_face) all.push_back(spoke.centre);
            }
            if (ring.closed) all.push_back(all[begin.back() + 1]);
        }
        begin.push_back(all.size());
        std::vector<Vec3d> points(all.size());
        positions(all, level, points);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec3d* const p = &points[begin[i]];
            Vec3d normal(0);
            for (std::size_t k = 1; k + 1 < begin[i + 1] - begin[i]; ++k)
                normal += glm::cross(p[k] - p[0], p[k + 1] - p[0]);
            out[i] = detail::frame_from(p[0], normal, p[1] - p[0]);
        }
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        require_limits(sites);
        even_->limit_positions(sites, out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        require_limits(sites);
        even_->limits(sites, out);
    }
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const override {
        require_limits(sites);
        even_->normals(sites, out);
    }

  private:
    /// Throws if an infinitely sharp crease ends at a vertex of two triangles; the message names the first such vertex.
    void require_limits(std::span<const Site> sites) const {
        VertexId first;
        for (const Site& site : sites) {
            if (site.level > 0) continue;
            const VertexId v = RefinedLevel(mesh_, 0).control_vertex(site);
            const HalfedgeId h = mesh_.vertex_halfedge(v);
            if (mesh_.is_boundary(v) || mesh_.face_valence(v) != 2 || mesh_.sharpness(v) > 0) continue;
            const float one = mesh_.sharpness(mesh_.edge(h)), other = mesh_.sharpness(mesh_.edge(mesh_.prev(h)));
            if (std::min(one, other) > 0 || std::max(one, other) < k_sharpness_infinity) continue;
            first = std::min(first, v);
        }
        if (first.valid())
            throw detail::NoLimit("sqrt3 has no limit at " + detail::vertex_name(mesh_.data(), first.value) +
                                      ", where a crease ends between two triangles: tag the vertex as a corner",
                                  mesh_.data().source);
    }

    const ControlMesh& mesh_;
    std::shared_ptr<const LevelSource> even_;
};

}  // namespace

std::shared_ptr<const LevelSource> sqrt3_levels(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                const RuleOptions& rules, const RunContext& context, bool whole_levels,
                                                std::shared_ptr<const PositionSource> limit_positions) {
    return std::make_shared<Sqrt3Levels>(mesh, scheme, rules, context, whole_levels, std::move(limit_positions));
}

}  // namespace tetrakis
