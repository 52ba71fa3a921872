#include "whole_level_limits.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../uniform/repeated_rows.hpp"

#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// At least so many vertices of a whole level are made in the time in which the rules evaluate one site.
constexpr std::uint64_t k_points_per_site = 200;
/// Levels of so many vertices take half a second; nothing can be cancelled meanwhile.
constexpr std::uint64_t k_most_points = 1u << 22;
/// For a vertex of a level and its share of the level before.
constexpr std::uint64_t k_point_bytes = 2 * sizeof(Vec3d);
/// Share of the memory limit that a level may take.
constexpr std::uint64_t k_memory_share = 4;
/// Rows repeat from a level on that has a few segments a root. That is at most so much finer than the first level.
constexpr int k_first_levels = 4;

/// For each root of vertex quadtrees, the half-edge of the net's base that its side 0 lies along; none where a root of
/// the net is not found.
std::vector<std::uint32_t> root_halfedges(const VertexRoots& roots, const RepeatedRows& rows) {
    const MeshLevel& base = rows.net().base();
    std::vector<std::uint32_t> first(roots.count(), MeshLevel::none), found;
    for (const std::uint32_t h : rows.corner_halfedges()) {
        first[found.size()] = h;
        found.push_back(static_cast<std::uint32_t>(found.size()));
    }
    // From the corners of faces outwards over the boundary.
    while (!found.empty()) {
        const std::uint32_t r = found.back();
        found.pop_back();
        for (std::uint32_t s = 0; s < 4; ++s) {
            const std::uint32_t link = roots.link[4 * std::size_t{r} + s];
            if (link == VertexRoots::outside || (roots.crease[r] >> s & 1) != 0) continue;
            const std::uint32_t beyond = link / 4;
            const std::uint32_t twin = base.twin[first[r] / 4 * 4 + (first[r] + s) % 4];
            if (first[beyond] != MeshLevel::none || twin == MeshLevel::none) continue;
            first[beyond] = twin / 4 * 4 + (twin + 4 - link % 4) % 4;
            found.push_back(beyond);
        }
    }
    return first;
}

class WholeLevelLimits final : public PositionSource {
  public:
    WholeLevelLimits(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                     std::shared_ptr<const LevelSource> others, const VertexRoots* roots, const RunContext& context)
        : mesh_(mesh),
          scheme_(scheme),
          rules_(rules),
          others_(std::move(others)),
          triangles_(scheme.family == MeshFamily::triangles) {
        if (roots != nullptr) roots_ = *roots;
        most_points_ = k_most_points;
        if (context.max_memory_bytes != 0)
            most_points_ = std::min(most_points_, context.max_memory_bytes / k_memory_share / k_point_bytes);
    }

    void positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        std::array<std::uint64_t, k_max_level + 1> wanted{};
        for (const Site& site : sites) ++wanted[level_of(site)];
        std::array<const Level*, k_max_level + 1> from{};
        {
            const std::lock_guard lock(mutex_);
            // Tasks of callers that wait for the lock must not be taken up by this thread.
            oneapi::tbb::this_task_arena::isolate([&] { prepare(wanted); });
            for (std::size_t l = 0; l < from.size(); ++l) from[l] = source_of(static_cast<int>(l));
        }
        const auto count = static_cast<std::uint32_t>(sites.size());
        constexpr std::uint32_t k_grain = 1024;
        std::vector<std::uint8_t> missing(sites.size(), 0);
        for_each_index(
            count,
            [&](std::uint32_t i) {
                const Level* const level = from[level_of(sites[i])];
                const std::uint32_t point = level == nullptr ? MeshLevel::none : number(*level, sites[i]);
                if (point == MeshLevel::none)
                    missing[i] = 1;
                else
                    out[i] = level->points[point];
            },
            k_grain);
        if (std::find(missing.begin(), missing.end(), 1) != missing.end()) ask_others(sites, missing, out);
    }

  private:
    /// A whole level of limit points.
    struct Level {
        int level = 0;  ///< of its sites
        std::unique_ptr<const RepeatedRows> rows;
        std::vector<std::uint32_t> root_halfedge;  ///< by root of sites, as RepeatedRows::corner_halfedges()
        RootLattices::Numbers numbers;
        std::vector<Vec3d> points;
    };

    bool dual() const { return roots_.count() != 0; }
    std::uint8_t level_of(const Site& site) const { return dual() ? site.level : minimal_level(site).level; }
    /// About; at most twice as many.
    std::uint64_t point_count(int level) const {
        const std::uint64_t cells = triangles_ ? mesh_.face_count() / 2 + 1 : mesh_.halfedge_count();
        return cells << (2 * level);
    }
    /// The level that has points for sites of that level; null if there is none.
    const Level* source_of(int level) const {
        if (dual()) return levels_[static_cast<std::size_t>(level)].get();
        const auto finest = std::find_if(levels_.rbegin(), levels_.rend(), [](const auto& l) { return l != nullptr; });
        return finest != levels_.rend() && (*finest)->level >= level ? finest->get() : nullptr;
    }

    /// Makes the levels that are worth it for so many sites of each level.
    void prepare(const std::array<std::uint64_t, k_max_level + 1>& wanted) const {
        std::uint64_t all = 0;
        for (std::size_t l = 0; l < wanted.size(); ++l) {
            if (wanted[l] == 0 || source_of(static_cast<int>(l)) != nullptr) continue;
            asked_[l] += wanted[l];
        }
        int worth = -1;
        for (std::size_t l = 0; l < wanted.size(); ++l) {
            const int level = static_cast<int>(l);
            if (wanted[l] == 0 || source_of(level) != nullptr) continue;
            all = dual() ? asked_[l] : all + asked_[l];
            if (point_count(level) > std::min(most_points_, k_points_per_site * all)) continue;
            if (dual())
                make(level);
            else
                worth = level;
        }
        if (worth < 0) return;
        // Of the first levels only finer ones may be there.
        for (int level = worth; level <= std::max(worth, k_first_levels); ++level)
            if (point_count(level) <= most_points_ && make(level)) return;
    }

    bool make(int level) const {
        if (level <= failed_ || level > k_max_level) return false;
        auto result = std::make_unique<Level>();
        result->level = level;
        const int steps = triangles_ ? level : level + 1;
        RepeatedRows::Demand demand;
        demand.limit = demand.even_if_slower = true;
        try {
            auto by_rules = std::make_unique<RuleLevels>(mesh_, scheme_, rules_, 0);
            result->rows = RepeatedRows::make(mesh_, scheme_, steps, rules_, by_rules, demand, {});
        } catch (const Error&) {  // evaluating single sites throws it again
        }
        if (!result->rows || result->rows->corner_halfedges().empty()) {
            failed_ = level;
            return false;
        }
        const RepeatedRows& rows = *result->rows;
        if (dual()) {
            result->root_halfedge = root_halfedges(roots_, rows);
        } else {
            const auto corners = rows.corner_halfedges();
            result->root_halfedge.assign(corners.begin(), corners.end());
        }
        result->numbers = rows.net().point_numbers(rows.last_layout());
        resize_large(result->points, rows.point_count());
        rows.refine(mesh_.positions(), result->points, {}, {});
        levels_[static_cast<std::size_t>(level)] = std::move(result);
        return true;
    }

    std::uint32_t number(const Level& level, const Site& any) const {
        const Site site = dual() ? any : minimal_level(any);
        const std::uint32_t h = level.root_halfedge[site.root.value];
        if (h == MeshLevel::none) return MeshLevel::none;
        const int up = level.level - site.level;
        return level.numbers.of(
            level.rows->net().number(level.rows->last_layout(), h, site.at.x << up, site.at.y << up));
    }

    void ask_others(std::span<const Site> sites, std::span<const std::uint8_t> missing, std::span<Vec3d> out) const {
        struct Asked {
            Site site;
            std::size_t index;
            auto operator<=>(const Asked&) const = default;
        };
        std::vector<Asked> asked;
        for (std::size_t i = 0; i < sites.size(); ++i)
            if (missing[i] != 0) asked.push_back({sites[i], i});
        oneapi::tbb::parallel_sort(asked.begin(), asked.end());
        std::vector<Site> distinct;
        for (const Asked& a : asked)
            if (distinct.empty() || distinct.back() != a.site) distinct.push_back(a.site);
        std::vector<Vec3d> found(distinct.size());
        others_->limit_positions(distinct, found);
        std::size_t k = 0;
        for (const Asked& a : asked) {
            if (distinct[k] != a.site) ++k;
            out[a.index] = found[k];
        }
    }

    const ControlMesh& mesh_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::shared_ptr<const LevelSource> others_;
    VertexRoots roots_;
    bool triangles_;
    std::uint64_t most_points_ = 0;
    mutable std::mutex mutex_;
    mutable std::array<std::unique_ptr<const Level>, k_max_level + 1> levels_;
    mutable std::array<std::uint64_t, k_max_level + 1> asked_{};  ///< sites so far that no level answered for
    mutable int failed_ = -1;                                     ///< no level up to this one can be made
};

}  // namespace

std::shared_ptr<const PositionSource> whole_level_limits(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                         const RuleOptions& rules,
                                                         std::shared_ptr<const LevelSource> others,
                                                         const VertexRoots* roots, const RunContext& context) {
    return std::make_shared<WholeLevelLimits>(mesh, scheme, rules, std::move(others), roots, context);
}

}  // namespace tetrakis::detail
