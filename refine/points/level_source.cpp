#include "level_source.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "level_frames.hpp"
#include "partial_levels.hpp"

#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

namespace {

/// The control vertex at a site, if one is there.
VertexId control_vertex(const ControlMesh& mesh, const Site& site, bool triangles) {
    const std::uint32_t n = 1u << site.level;
    if (site.at.x == 0 && site.at.y == 0) return mesh.origin(site.root);
    if (triangles && site.at.x == n && site.at.y == 0) return mesh.origin(mesh.next(site.root));
    if (triangles && site.at.x == 0 && site.at.y == n) return mesh.origin(mesh.prev(site.root));
    return {};
}

/// By the rules. Quads: lattice level l is scheme level l + 1.
class SiteLevels final : public LevelSource {
  public:
    SiteLevels(const ControlMesh& mesh, bool triangles, PartialLevels levels)
        : mesh_(mesh), triangles_(triangles), levels_(std::move(levels)) {}

    int first_level(const Site& site) const override {
        const int lattice = minimal_level(site).level;
        return triangles_ || (lattice == 0 && control_vertex(mesh_, site, false).valid()) ? lattice : lattice + 1;
    }
    int max_level() const override { return k_max_level + offset(); }

    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        if (level >= offset()) return levels_.control_positions(at_lattice_level(sites, level - offset()), out);
        for (std::size_t i = 0; i < sites.size(); ++i) out[i] = mesh_.position(control_vertex(mesh_, sites[i], false));
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        if (level >= offset()) return levels_.frames(at_lattice_level(sites, level - offset()), out);
        for (std::size_t i = 0; i < sites.size(); ++i)
            out[i] = detail::control_frame(mesh_, control_vertex(mesh_, sites[i], false));
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        levels_.positions(sites, out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override { levels_.limits(sites, out); }

  private:
    int offset() const { return triangles_ ? 0 : 1; }
    static std::vector<Site> at_lattice_level(std::span<const Site> sites, int level) {
        std::vector<Site> result(sites.size());
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Site s = minimal_level(sites[i]);
            const int up = level - s.level;
            result[i] = {s.root, {s.at.x << up, s.at.y << up}, static_cast<std::uint8_t>(level)};
        }
        return result;
    }

    const ControlMesh& mesh_;
    bool triangles_;
    PartialLevels levels_;
};

}  // namespace

void LevelSource::normals(std::span<const Site> sites, std::span<Vec3d> out) const {
    std::vector<LimitPoint> points(sites.size());
    limits(sites, points);
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = points[i].normal;
}

std::unique_ptr<LevelSource> rule_levels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules) {
    PartialLevels levels(mesh, scheme, rules);
    if (levels.lattice() == FanLattice::dual)
        throw Error(ErrorCode::unsupported,
                    std::string(scheme.name) + " is a dual scheme with these choices: its vertices are no sites");
    return std::make_unique<SiteLevels>(mesh, levels.lattice() == FanLattice::triangles, std::move(levels));
}

}  // namespace tetrakis
