#include "row_points.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../rules/limit_search.hpp"
#include "../rules/regular_limit.hpp"
#include "../rules/rule_levels.hpp"
#include "../uniform/repeated_rows.hpp"
#include "level_vertices.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// The first level that is made whole has about so many lattice levels, and is worth so many points for each site.
constexpr int k_first_lattice_level = 2;
constexpr std::uint64_t k_points_per_site = 200;
/// Levels of so many vertices take half a second; nothing can be cancelled meanwhile.
constexpr std::uint64_t k_most_points = 1u << 22;
/// For a vertex of a level by the rules, its share of the mesh and of the rows.
constexpr std::uint64_t k_point_bytes = 300;
/// Share of the memory limit that the first level may take.
constexpr std::uint64_t k_memory_share = 4;
/// Steps in which all semi-sharp tags have to be gone.
constexpr int k_settling_levels = 16;
/// A cell's middle is looked for at most so many levels further down.
constexpr int k_deepest_middle = 4;
/// Sites evaluated together: enough to share ancestors, few enough for their levels to stay in the cache.
constexpr std::uint32_t k_block = 2048;
/// Rows of a normal.
constexpr std::uint32_t k_normal_rows = 4;

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

/// Terms of the sums that a block's results are.
struct Sums {
    std::vector<std::uint32_t> source;
    std::vector<double> weight;
    std::vector<std::uint8_t> row;

    void clear() {
        source.clear();
        weight.clear();
        row.clear();
    }
};

struct Workspace {
    std::array<LevelVertices, k_max_level + 2> levels;  ///< from the first level of the rows on
    Sums sums;
};

enum class Wanted { positions, limits, normals };

class RowPoints final : public LevelSource {
  public:
    RowPoints(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
              std::shared_ptr<const LevelSource> others, const VertexRoots* roots, const RunContext& context)
        : mesh_(mesh),
          scheme_(scheme),
          rules_(rules),
          others_(std::move(others)),
          triangles_(scheme.family == MeshFamily::triangles) {
        if (roots != nullptr) roots_ = *roots;
        if (context.max_memory_bytes != 0)
            most_points_ = std::min(most_points_, context.max_memory_bytes / k_memory_share / k_point_bytes);
    }

    int first_level(const Site& site) const override { return others_->first_level(site); }
    int max_level() const override { return others_->max_level(); }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        evaluate(sites, Wanted::positions, level, out,
                 [&](std::span<const Site> some, std::span<Vec3d> to) { others_->positions(some, level, to); });
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        others_->frames(sites, level, out);
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        evaluate(sites, Wanted::limits, 0, out,
                 [&](std::span<const Site> some, std::span<Vec3d> to) { others_->limit_positions(some, to); });
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override { others_->limits(sites, out); }
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const override {
        evaluate(sites, Wanted::normals, 0, out,
                 [&](std::span<const Site> some, std::span<Vec3d> to) { others_->normals(some, to); });
    }

  private:
    struct Rows {
        std::unique_ptr<const RepeatedRows> all;
        std::vector<std::uint32_t> root_halfedge;  ///< by root of sites, as RepeatedRows::corner_halfedges()
        int limit_level = 0;                       ///< RepeatedRows::limit_level()
        std::vector<Vec3d> first;                  ///< points of the first level
        /// In cells too large for rows of their own the limit at the middle of a cell, where four finer ones meet, is a
        /// sum of their points: x, y = 0 stand right above.
        std::vector<RegularLimit::LatticeTerm> middle, tangents[2];

        int first_level() const { return all->first_level(); }
        const RootLattices& net() const { return all->net(); }
    };

    bool dual() const { return roots_.count() != 0; }
    /// Levels of the scheme to one of lattices.
    int offset() const { return triangles_ ? 0 : 1; }

    /// The rows, once they are worth it for all the sites that have been asked for.
    const Rows* rows_for(std::size_t sites) const {
        const std::lock_guard lock(mutex_);
        if (!tried_) {
            asked_ += sites;
            const std::uint64_t cells = triangles_ ? mesh_.face_count() / 2 + 1 : mesh_.halfedge_count(),
                                points = cells << (2 * k_first_lattice_level);
            if (points > std::min(most_points_, k_points_per_site * asked_)) return nullptr;
            tried_ = true;
            // Tasks of callers that wait for the lock must not be taken up by this thread.
            oneapi::tbb::this_task_arena::isolate([&] { rows_ = make(); });
        }
        return rows_.get();
    }

    std::unique_ptr<const Rows> make() const {
        RepeatedRows::Demand demand;
        demand.limit = demand.normals = demand.even_if_slower = demand.any_level = true;
        auto result = std::make_unique<Rows>();
        try {
            auto by_rules = std::make_unique<RuleLevels>(mesh_, scheme_, rules_, 0);
            result->all = RepeatedRows::make(mesh_, scheme_, k_settling_levels, rules_, by_rules, demand, {});
            if (!result->all || result->all->corner_halfedges().empty()) return nullptr;
            const std::optional<int> level = result->all->limit_level();
            if (!level) return nullptr;
            result->limit_level = *level;
            if (dual()) set_middle(*result);
        } catch (const Error&) {  // evaluating single sites throws it again
            return nullptr;
        }
        const auto corners = result->all->corner_halfedges();
        if (dual())
            result->root_halfedge = root_halfedges(roots_, *result->all);
        else
            result->root_halfedge.assign(corners.begin(), corners.end());
        const RootLattices& net = result->net();
        resize_large(result->first, net.place_count(net.layout(result->all->segments(result->first_level()))));
        result->all->first_points(mesh_.positions(), result->first.data());
        return result;
    }

    /// The scheme's limit where four regular cells meet.
    void set_middle(Rows& rows) const {
        const int rings = rule_limit_rings(scheme_, rules_), side = 2 * rings + 1;
        const RuleMesh mesh = RegularLimit::lattice_mesh(FanLattice::dual, rings);
        for (const int h : mesh.ring(RegularLimit::middle(rings)).halfedge) {
            if (mesh.origin(mesh.next(h)) != mesh.origin(h) + 1) continue;
            const std::optional<LimitRows> found = LimitSearch(scheme_, rules_).at_face(mesh, h);
            if (!found || found->tangents.size() != 1) return;
            // The face's corners are at 0 and 1 from the middle vertex.
            const auto take = [&](const StencilRow& row, std::vector<RegularLimit::LatticeTerm>& terms) {
                for (const auto& [v, weight] : row.terms)
                    terms.push_back({v % side - rings - 1, v / side - rings - 1, weight});
            };
            take(found->limit, rows.middle);
            take(found->tangents[0][0], rows.tangents[0]);
            take(found->tangents[0][1], rows.tangents[1]);
            return;
        }
    }

    /// How many levels below a cell its limit can be told from: so that beyond the points it takes as many again are
    /// left to the ends of the cell, where rows may be others. -1: none.
    static int middle_depth(const Rows& rows) {
        for (int finer = 2; finer <= k_deepest_middle; ++finer) {
            const int reach = 1 << (finer - 1);
            const auto inside = [&](int i) { return -reach <= 2 * i && 2 * (i + 1) <= reach; };
            const auto all_inside = [&](const std::vector<RegularLimit::LatticeTerm>& terms) {
                return !terms.empty() &&
                       std::ranges::all_of(terms, [&](const auto& term) { return inside(term.x) && inside(term.y); });
            };
            if (all_inside(rows.middle) && all_inside(rows.tangents[0]) && all_inside(rows.tangents[1])) return finer;
        }
        return -1;
    }

    template <class Others>
    void evaluate(std::span<const Site> sites, Wanted wanted, int level, std::span<Vec3d> out,
                  const Others& others) const {
        const Rows* const rows = rows_for(sites.size());
        if (rows == nullptr) return others(sites, out);
        std::vector<std::uint8_t> missing(sites.size(), 0);
        for_each_block(static_cast<std::uint32_t>(sites.size()), k_block, [&](std::uint32_t begin, std::uint32_t end) {
            const std::size_t count = end - begin;
            block(*rows, sites.subspan(begin, count), wanted, level, out.subspan(begin, count),
                  std::span(missing).subspan(begin, count));
        });
        std::vector<Site> left;
        for (std::size_t i = 0; i < sites.size(); ++i)
            if (missing[i] != 0) left.push_back(sites[i]);
        if (left.empty()) return;
        std::vector<Vec3d> found(left.size());
        others(left, found);
        for (std::size_t i = 0, k = 0; i < sites.size(); ++i)
            if (missing[i] != 0) out[i] = found[k++];
    }

    void block(const Rows& rows, std::span<const Site> sites, Wanted wanted, int level, std::span<Vec3d> out,
               std::span<std::uint8_t> missing) const {
        Workspace& work = workspaces_.local();
        for (LevelVertices& vertices : work.levels) vertices.clear();
        work.sums.clear();
        std::vector<std::size_t> begin;
        std::vector<int> level_of;
        int deepest = 0;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            begin.push_back(work.sums.source.size());
            level_of.push_back(add(rows, sites[i], wanted, level, work));
            missing[i] = level_of[i] < 0 ? 1 : 0;
            deepest = std::max(deepest, level_of[i]);
        }
        begin.push_back(work.sums.source.size());
        const RootLattices& net = rows.net();
        const RootLayout first = net.layout(rows.all->segments(rows.first_level()));
        evaluate_levels(
            std::span<LevelVertices>(work.levels), deepest,
            [&](const RootPlace& at, int l, const auto& add_term) {
                const int to = rows.first_level() + l;
                rows.all->step_to(to).read(
                    rows.all->segments(to - 1), at,
                    [&](std::uint32_t, const RootPlace& from, double weight) { add_term(from, weight); });
            },
            [&](const RootPlace& at) {
                return rows.first[net.number_at(first, at.root, {at.x, at.y})];
            });
        for (std::size_t i = 0; i < sites.size(); ++i) {
            if (missing[i] != 0) continue;
            const std::vector<Vec3d>& value = work.levels[static_cast<std::size_t>(level_of[i])].value;
            Vec3d sum[k_normal_rows] = {};
            for (std::size_t k = begin[i]; k < begin[i + 1]; ++k)
                sum[work.sums.row[k]] += work.sums.weight[k] * value[work.sums.source[k]];
            out[i] = wanted == Wanted::normals ? RowPatterns::normal_of(sum) : sum[0];
            if (wanted == Wanted::normals && out[i] == Vec3d(0)) missing[i] = 1;
        }
    }

    /// The vertices of a site's sums. Returns their level, counted from the first of the rows; -1: it has none there.
    int add(const Rows& rows, const Site& any, Wanted wanted, int level, Workspace& work) const {
        const Site site = dual() ? any : minimal_level(any);
        const std::uint32_t h = rows.root_halfedge[site.root.value];
        if (h == MeshLevel::none) return -1;
        const RootLattices& net = rows.net();
        const int own = site.level + offset();
        bool middle = false;
        if (wanted != Wanted::positions) {
            level = std::max(own, rows.limit_level);
            middle = dual() && level > own;
            if (middle) {
                // Roots that are no faces' corners reach beyond the surface's end or a crease.
                const int depth = site.root.value < mesh_.halfedge_count() ? middle_depth(rows) : -1;
                if (depth < 0) return -1;
                level = std::max(own + depth, rows.first_level());
            }
            // Where creases are shared, a normal is the mean of two sides.
            if (wanted == Wanted::normals && net.shares_points() && site.root.value >= mesh_.halfedge_count())
                return -1;
        }
        if (level < rows.first_level()) return -1;
        const std::uint32_t segments = rows.all->segments(level);
        const int up = level - own;
        if (site.level + up > k_max_level) return -1;
        LevelVertices& vertices = work.levels[static_cast<std::size_t>(level - rows.first_level())];
        const auto take = [&](std::uint32_t row, const RootPlace& at, double weight) {
            work.sums.source.push_back(vertices.insert(at));
            work.sums.weight.push_back(weight);
            work.sums.row.push_back(static_cast<std::uint8_t>(row));
        };
        const std::uint32_t x = site.at.x << up, y = site.at.y << up;
        if (middle) {
            const std::uint32_t half = 1u << (up - 1);
            const auto sum = [&](std::uint32_t row, const std::vector<RegularLimit::LatticeTerm>& terms) {
                for (const RegularLimit::LatticeTerm& term : terms)
                    take(row,
                         net.place_seen(segments, h, x + half + static_cast<std::uint32_t>(term.x),
                                        y + half + static_cast<std::uint32_t>(term.y)),
                         term.weight);
            };
            if (wanted == Wanted::limits) {
                sum(0, rows.middle);
            } else {
                sum(0, rows.tangents[0]);
                sum(1, rows.tangents[1]);
            }
            return level - rows.first_level();
        }
        const RootPlace at = net.own_place(segments, net.place_seen(segments, h, x, y));
        if (wanted == Wanted::positions)
            take(0, at, 1);
        else
            (wanted == Wanted::limits ? rows.all->limit() : rows.all->normals()).read(segments, at, take);
        return level - rows.first_level();
    }

    const ControlMesh& mesh_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::shared_ptr<const LevelSource> others_;
    VertexRoots roots_;
    bool triangles_;
    std::uint64_t most_points_ = k_most_points;
    mutable std::mutex mutex_;
    mutable std::uint64_t asked_ = 0;  ///< sites so far
    mutable bool tried_ = false;
    mutable std::unique_ptr<const Rows> rows_;
    mutable oneapi::tbb::enumerable_thread_specific<Workspace> workspaces_{};  ///< what blocks have grown
};

}  // namespace

std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, std::shared_ptr<const LevelSource> others,
                                              const VertexRoots* roots, const RunContext& context) {
    return std::make_shared<RowPoints>(mesh, scheme, rules, std::move(others), roots, context);
}

}  // namespace tetrakis::detail
