#include "whole_level_limits.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../rules/limit_search.hpp"
#include "../rules/regular_limit.hpp"
#include "../uniform/repeated_rows.hpp"

#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// At least so many vertices of a whole level are made in the time in which the rules evaluate one site; where a finer
/// level is needed the rules take as many times longer.
constexpr std::uint64_t k_points_per_site = 200;
/// Levels of so many vertices take half a second; nothing can be cancelled meanwhile.
constexpr std::uint64_t k_most_points = 1u << 22;
/// For a vertex of a level and its share of the level before.
constexpr std::uint64_t k_point_bytes = 2 * sizeof(Vec3d);
/// Share of the memory limit that a level may take.
constexpr std::uint64_t k_memory_share = 4;
/// Rows repeat from a level on that has a few segments a root. That is at most so much finer than the first level.
constexpr int k_first_levels = 4;
/// How many levels below those that have none there are at least some.
constexpr int k_finest_middles = 4;

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
                missing[i] = level == nullptr || !find(*level, sites[i], out[i]);
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
        /// In cells whose own level has no rows, points are control points of a level `finer` than theirs, and the
        /// limit at the middle of a cell, where four of those meet, is this sum of them: x, y = 0 stand right above.
        int finer = 0;
        std::vector<RegularLimit::LatticeTerm> middle;
    };

    bool dual() const { return roots_.count() != 0; }
    std::uint8_t level_of(const Site& site) const { return dual() ? site.level : minimal_level(site).level; }
    /// About; at most twice as many.
    std::uint64_t point_count(int level) const {
        const std::uint64_t cells = triangles_ ? mesh_.face_count() / 2 + 1 : mesh_.halfedge_count();
        return 2 * level < std::countl_zero(cells) ? cells << (2 * level) : std::numeric_limits<std::uint64_t>::max();
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
        if (level > k_max_level || (failed_ >> level & 1) != 0) return false;
        if (make(level, 0)) return true;
        failed_ |= std::uint32_t{1} << level;
        for (int finer = 2; dual() && finer <= k_finest_middles; ++finer) {
            if (point_count(level + finer) > most_points_) return false;  // coarser levels may do
            if (make(level, finer)) return true;
        }
        failed_ |= (std::uint32_t{2} << level) - 1;
        return false;
    }

    bool make(int level, int finer) const {
        auto result = std::make_unique<Level>();
        result->level = level;
        result->finer = finer;
        const int steps = triangles_ ? level : level + finer + 1;
        RepeatedRows::Demand demand;
        demand.limit = finer == 0;
        demand.even_if_slower = true;
        try {
            if (finer > 0 && !set_middle(*result)) return false;
            auto by_rules = std::make_unique<RuleLevels>(mesh_, scheme_, rules_, 0);
            result->rows = RepeatedRows::make(mesh_, scheme_, steps, rules_, by_rules, demand, {});
        } catch (const Error&) {  // evaluating single sites throws it again
        }
        if (!result->rows || result->rows->corner_halfedges().empty()) return false;
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

    /// False where the sum would take points of other cells.
    bool set_middle(Level& level) const {
        if (!middle_) middle_ = limit_at_middles();
        // As far again from those points to the ends of the cell, beyond which rules may be others.
        const int reach = 1 << (level.finer - 1);
        const auto inside = [&](int i) { return -reach <= 2 * i && 2 * (i + 1) <= reach; };
        level.middle = *middle_;
        return !middle_->empty() && std::ranges::all_of(*middle_, [&](const RegularLimit::LatticeTerm& term) {
            return inside(term.x) && inside(term.y);
        });
    }

    /// The scheme's limit where four regular cells meet.
    std::vector<RegularLimit::LatticeTerm> limit_at_middles() const {
        std::vector<RegularLimit::LatticeTerm> terms;
        const int rings = rule_limit_rings(scheme_, rules_), side = 2 * rings + 1;
        const RuleMesh mesh = RegularLimit::lattice_mesh(FanLattice::dual, rings);
        for (const int h : mesh.ring(RegularLimit::middle(rings)).halfedge) {
            if (mesh.origin(mesh.next(h)) != mesh.origin(h) + 1) continue;
            const std::optional<LimitRows> rows = LimitSearch(scheme_, rules_).at_face(mesh, h);
            if (!rows) break;
            // The face's corners are at 0 and 1 from the middle vertex.
            for (const auto& [v, weight] : rows->limit.terms)
                terms.push_back({v % side - rings - 1, v / side - rings - 1, weight});
        }
        return terms;
    }

    /// Whether the site has a limit there.
    bool find(const Level& level, const Site& any, Vec3d& limit) const {
        const Site site = dual() ? any : minimal_level(any);
        const std::uint32_t h = level.root_halfedge[site.root.value];
        if (h == MeshLevel::none) return false;
        const int up = level.level + level.finer - site.level;
        const auto point = [&](std::uint32_t x, std::uint32_t y) -> const Vec3d& {
            return level.points[level.numbers.of(level.rows->net().number(level.rows->last_layout(), h, x, y))];
        };
        const std::uint32_t x = site.at.x << up, y = site.at.y << up;
        if (level.middle.empty()) {
            limit = point(x, y);
            return true;
        }
        // Roots that are no faces' corners reach beyond the surface's end or a crease.
        if (site.root.value >= mesh_.halfedge_count()) return false;
        const std::uint32_t half = 1u << (up - 1);
        limit = Vec3d(0);
        for (const RegularLimit::LatticeTerm& term : level.middle)
            limit += term.weight * point(x + half + static_cast<std::uint32_t>(term.x),
                                         y + half + static_cast<std::uint32_t>(term.y));
        return true;
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
    mutable std::array<std::uint64_t, k_max_level + 1> asked_{};            ///< sites so far that no level answered for
    mutable std::optional<std::vector<RegularLimit::LatticeTerm>> middle_;  ///< limit_at_middles()
    mutable std::uint32_t failed_ = 0;                                      ///< bit l: level l cannot be made
};

}  // namespace

std::shared_ptr<const PositionSource> whole_level_limits(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                         const RuleOptions& rules,
                                                         std::shared_ptr<const LevelSource> others,
                                                         const VertexRoots* roots, const RunContext& context) {
    return std::make_shared<WholeLevelLimits>(mesh, scheme, rules, std::move(others), roots, context);
}

}  // namespace tetrakis::detail
