#include "surface.hpp"

#include "../../hier/forest/bisection_path.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "ray_cast.hpp"

#include <algorithm>
#include <array>
#include <random>

namespace tetrakis::lod {

namespace {

/// Searches for a ray's first hit among the known triangles of at most depth `depth`.
class RaySearch {
  public:
    RaySearch(const Surface& surface, const detail::RayCast& ray, int depth)
        : surface_(surface), ray_(ray), depth_(depth), known_(depth) {
        const ControlMesh& roots = surface.roots();
        for (std::uint32_t h = 0; h < roots.halfedge_count(); ++h)
            if (!roots.is_hole(roots.face(HalfedgeId(h)))) search(HalfedgeId(h), BisectionShape::root(), 0);
    }
    std::optional<SurfaceHit> result() const { return ray_.hit(); }
    /// Depth to which all triangles along the ray are known.
    int known_depth() const { return known_; }

  private:
    void search(HalfedgeId cell, const BisectionShape& shape, int depth) {
        const ControlMesh& roots = surface_.roots();
        const Site middle = canonical(roots, {cell, shape.middle(depth), lattice_level(depth + 1)});
        std::array<DiamondBounds, 1> bounds;
        if (depth < depth_) surface_.bounds({&middle, 1}, bounds);
        if (depth == depth_ || !bounds[0].known) {
            known_ = std::min(known_, depth);
            const CellTriangle triangle = shape.in(cell, depth);
            std::array<Site, 3> sites;
            for (std::size_t k = 0; k < 3; ++k) sites[k] = corner_site(roots, triangle, k);
            std::array<Place, 3> places;
            surface_.places(sites, places);
            ray_.meet(places[0].position, places[1].position, places[2].position);
            return;
        }
        if (!ray_.enters(bounds[0].center, bounds[0].half_sides)) return;
        for (const int bit : {0, 1})
            search(depth == 0 && bit == 1 ? roots.next(cell) : cell, shape.child(depth, bit), depth + 1);
    }

    const Surface& surface_;
    detail::RayCast ray_;
    int depth_, known_;
};

}  // namespace

std::optional<SurfaceHit> Surface::hit(const Vec3d& origin, const Vec3d& direction, double farthest) const {
    // A use keeps corners known: they are midpoints of larger triangles.
    const SurfaceUse use(*this);
    const detail::RayCast ray(origin, direction, farthest, roots().bounding_box());
    if (!ray.is_valid()) return {};
    const RaySearch finest(*this, ray, max_depth());
    if (finest.result() || finest.known_depth() == max_depth()) return finest.result();
    // The ray may have passed a gap beside a triangle of another depth. Triangles of one depth have no gaps.
    return RaySearch(*this, ray, finest.known_depth()).result();
}

std::vector<Vec3d> random_places(const Surface& surface, std::uint32_t count, std::uint64_t seed) {
    const ControlMesh& roots = surface.roots();
    std::vector<HalfedgeId> cells;
    for (std::uint32_t h = 0; h < roots.halfedge_count(); ++h)
        if (!roots.is_hole(roots.face(HalfedgeId(h)))) cells.push_back(HalfedgeId(h));
    std::mt19937_64 random(seed);
    std::vector<Site> sites;
    for (std::uint32_t i = 0; i < count && !cells.empty(); ++i) {
        const HalfedgeId root = cells[random() % cells.size()];
        const std::uint64_t path = random() % (std::uint64_t{1} << surface.max_depth());
        sites.push_back(corner_site(roots, cell_triangle(roots, root, surface.max_depth(), path), random() % 3));
    }
    std::vector<Place> places(sites.size());
    const SurfaceUse use(surface);
    surface.places(sites, places);
    std::vector<Vec3d> positions;
    for (const Place& place : places)
        if (place.known) positions.push_back(place.position);
    return positions;
}

}  // namespace tetrakis::lod
