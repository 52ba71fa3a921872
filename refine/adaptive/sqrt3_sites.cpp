#include "sqrt3_sites.hpp"

#include "../../hier/base/parallel.hpp"
#include "level_frames.hpp"
#include "sqrt3_points.hpp"

namespace tetrakis {

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
