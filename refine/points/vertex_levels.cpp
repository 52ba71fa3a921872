#include "vertex_levels.hpp"

#include "../../hier/base/error.hpp"

#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

namespace {

class VertexLevels final : public LevelSource {
  public:
    explicit VertexLevels(std::shared_ptr<const PartialLevels> levels) : levels_(std::move(levels)) {}

    int first_level(const Site& site) const override { return site.level + 1; }
    int max_level() const override { return k_max_level + 1; }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        levels_->control_positions(cells(sites, level), out);
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        levels_->frames(cells(sites, level), out);
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        levels_->positions(cells(sites), out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        levels_->limits(cells(sites), out);
    }

  private:
    static std::vector<VertexCell> cells(std::span<const Site> sites) {
        std::vector<VertexCell> result;
        result.reserve(sites.size());
        for (const Site& site : sites) result.push_back(site_cell(site));
        return result;
    }
    static std::vector<VertexCell> cells(std::span<const Site> sites, int level) {
        for (const Site& site : sites)
            if (site.level + 1 != level)
                throw Error(ErrorCode::unsupported, "a dual scheme has other vertices on every level: one of level " +
                                                        std::to_string(site.level + 1) + " is none of level " +
                                                        std::to_string(level));
        return cells(sites);
    }

    std::shared_ptr<const PartialLevels> levels_;
};

}  // namespace

std::unique_ptr<LevelSource> vertex_levels(std::shared_ptr<const PartialLevels> levels) {
    return std::make_unique<VertexLevels>(std::move(levels));
}

}  // namespace tetrakis
