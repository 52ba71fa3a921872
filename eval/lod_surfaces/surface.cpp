#include "surface.hpp"

#include "../../hier/forest/bisection_path.hpp"
#include "../../hier/forest/corner_cell.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace tetrakis::lod {

namespace {

/// Looks for a ray's first hit among the finest triangles below others.
class RaySearch {
  public:
    RaySearch(const Surface& surface, const Vec3d& origin, const Vec3d& direction, double farthest, int depth)
        : surface_(surface), origin_(origin), direction_(direction), first_(farthest), depth_(depth), known_(depth) {}

    void search() {
        const ControlMesh& roots = surface_.roots();
        for (std::uint32_t h = 0; h < roots.halfedge_count(); ++h)
            if (!roots.is_hole(roots.face(HalfedgeId(h)))) search(HalfedgeId(h), BisectionShape::root(), 0);
    }
    std::optional<SurfaceHit> result() const {
        return found_ ? std::optional(SurfaceHit{first_, unit_or_zero(across_)}) : std::nullopt;
    }
    /// To which depth all triangles on the ray's way are known.
    int known_depth() const { return known_; }

  private:
    void search(HalfedgeId cell, const BisectionShape& shape, int depth) {
        const ControlMesh& roots = surface_.roots();
        const auto site = [&](const LatticePoint& p, int level) {
            return canonical(roots, {cell, p, static_cast<std::uint8_t>(level)});
        };
        std::array<DiamondBounds, 1> bounds;
        if (depth < depth_) surface_.bounds(std::array{site(shape.middle(depth), lattice_level(depth + 1))}, bounds);
        if (depth == depth_ || !bounds[0].known) {
            known_ = std::min(known_, depth);
            const CellTriangle triangle = shape.in(cell, depth);
            std::array<Site, 3> sites;
            for (std::size_t k = 0; k < 3; ++k) sites[k] = corner_site(roots, triangle, k);
            std::array<Place, 3> places;
            surface_.places(sites, places);
            meet(places[0].position, places[1].position, places[2].position);
            return;
        }
        if (!enters(bounds[0])) return;
        for (const int bit : {0, 1})
            search(depth == 0 && bit == 1 ? roots.next(cell) : cell, shape.child(depth, bit), depth + 1);
    }
    bool enters(const DiamondBounds& bounds) const {
        double begin = 0, end = first_;
        for (int axis = 0; axis < 3; ++axis) {
            const double off = bounds.center[axis] - origin_[axis], half = bounds.half_sides[axis];
            if (direction_[axis] == 0) {
                if (std::abs(off) > half) return false;
                continue;
            }
            const double a = (off - half) / direction_[axis], b = (off + half) / direction_[axis];
            begin = std::max(begin, std::min(a, b));
            end = std::min(end, std::max(a, b));
        }
        return begin <= end;
    }
    void meet(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        // Which side of each edge the ray passes on; on an edge both triangles are met.
        const Vec3d pa = a - origin_, pb = b - origin_, pc = c - origin_;
        const double u = glm::dot(direction_, glm::cross(pb, pc)), v = glm::dot(direction_, glm::cross(pc, pa)),
                     w = glm::dot(direction_, glm::cross(pa, pb)), sum = u + v + w;
        if (sum == 0 || std::min({u, v, w}) * std::max({u, v, w}) < 0) return;
        const double t = glm::dot(u * pa + v * pb + w * pc, direction_) / (sum * glm::dot(direction_, direction_));
        if (!(t >= 0 && t <= first_)) return;
        first_ = t;
        across_ = glm::cross(b - a, c - a);
        found_ = true;
    }

    const Surface& surface_;
    Vec3d origin_, direction_;
    double first_;
    Vec3d across_{};  // the nearest triangle
    int depth_, known_;
    bool found_ = false;
};

}  // namespace

bool Surface::is_ray(const Vec3d& origin, const Vec3d& direction, double farthest) {
    constexpr double k_shortest = 1e-100, k_longest = 1e100;
    const double length = glm::length(direction);
    return std::isfinite(origin.x + origin.y + origin.z) && length >= k_shortest && length <= k_longest &&
           !std::isnan(farthest);
}

std::optional<SurfaceHit> Surface::hit(const Vec3d& origin, const Vec3d& direction, double farthest) const {
    // Corners are the middles of larger triangles.
    const SurfaceUse use(*this);
    if (!is_ray(origin, direction, farthest)) return {};
    RaySearch finest(*this, origin, direction, farthest, max_depth());
    finest.search();
    if (finest.result() || finest.known_depth() == max_depth()) return finest.result();
    // It may have passed between triangles that are known and coarser ones beside them; those of one depth are closed.
    RaySearch closed(*this, origin, direction, farthest, finest.known_depth());
    closed.search();
    return closed.result();
}

std::vector<Vec3d> random_places(const Surface& surface, std::uint32_t count, std::uint64_t seed) {
    const ControlMesh& roots = surface.roots();
    const int level = surface.max_depth() / 2;
    std::vector<HalfedgeId> cells;
    for (std::uint32_t h = 0; h < roots.halfedge_count(); ++h)
        if (!roots.is_hole(roots.face(HalfedgeId(h)))) cells.push_back(HalfedgeId(h));
    std::mt19937_64 random(seed);
    std::vector<Site> sites;
    for (std::uint32_t i = 0; i < count && !cells.empty(); ++i) {
        const auto up_to_side = [&] {
            return static_cast<std::uint32_t>(random() % ((std::uint64_t{1} << level) + 1));
        };
        const HalfedgeId cell = cells[random() % cells.size()];
        const std::uint32_t x = up_to_side();
        std::uint32_t y = up_to_side();
        // At even depths triangles' corners are every other point.
        if (surface.max_depth() % 2 == 0 && (x + y) % 2 != 0) y = y > 0 ? y - 1 : 1;
        sites.push_back(canonical(roots, {cell, {x, y}, static_cast<std::uint8_t>(level)}));
    }
    std::vector<Place> places(sites.size());
    surface.places(sites, places);
    std::vector<Vec3d> positions;
    for (const Place& place : places)
        if (place.known) positions.push_back(place.position);
    return positions;
}

}  // namespace tetrakis::lod
