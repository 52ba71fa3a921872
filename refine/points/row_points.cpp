#include "row_points.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../schemes/rules/linear.hpp"
#include "../rules/limit_search.hpp"
#include "../rules/regular_limit.hpp"
#include "../rules/rule_levels.hpp"
#include "../uniform/repeated_rows.hpp"
#include "level_frames.hpp"
#include "level_vertices.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
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
/// The rules make so many vertices in some seconds, and take so many bytes for each; nothing can be cancelled
/// meanwhile.
constexpr std::uint64_t k_most_by_rules = 1u << 20;
constexpr std::uint64_t k_point_bytes = 300;
/// So many points are made by rows, with all of their level, in the time in which one is found by itself.
constexpr std::uint64_t k_points_whole = 8;
/// Of such levels; 100 MB.
constexpr std::uint64_t k_most_whole = 1u << 22;
/// Share of the memory limit that the first level may take.
constexpr std::uint64_t k_memory_share = 4;
/// Steps in which all semi-sharp tags have to be gone.
constexpr int k_settling_levels = 16;
/// A cell's middle is looked for at most so many levels further down.
constexpr int k_deepest_middle = 4;
/// Sites evaluated together: enough to share ancestors, few enough for their levels to stay in the cache.
constexpr std::uint32_t k_sites_at_once = 2048;
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

/// The sums that a site's result is made of.
struct Sums {
    std::vector<Vec3d> value;
    std::uint32_t last_row = 0;
};

/// Their terms, of a block of sites.
struct Terms {
    std::vector<std::uint32_t> source;
    std::vector<double> weight;
    std::vector<std::uint32_t> row;

    void clear() {
        source.clear();
        weight.clear();
        row.clear();
    }
};

struct Workspace {
    std::array<LevelVertices, k_max_level + 2> levels;  ///< from the first level of the rows on
    Terms terms;
    Sums sums;
};

enum class Wanted { positions, frames, limits, normals };

class RowPoints final : public LevelSource {
  public:
    RowPoints(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
              std::shared_ptr<const LevelSource> others, const VertexRoots* roots, const RunContext& context,
              bool whole_levels)
        : whole_levels_(whole_levels),
          mesh_(mesh),
          scheme_(scheme),
          rules_(rules),
          others_(std::move(others)),
          triangles_(scheme.family == MeshFamily::triangles),
          max_memory_bytes_(context.max_memory_bytes) {
        if (roots != nullptr) roots_ = *roots;
        if (context.max_memory_bytes != 0) {
            most_by_rules_ = std::min(most_by_rules_, context.max_memory_bytes / k_memory_share / k_point_bytes);
            most_whole_ = std::min(most_whole_, context.max_memory_bytes / k_memory_share / sizeof(Vec3d));
        }
    }

    int first_level(const Site& site) const override { return others_->first_level(site); }
    int max_level() const override { return others_->max_level(); }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        evaluate(
            sites, Wanted::positions, level, out, [](const Sums& sums, Vec3d& point) { point = sums.value[0]; },
            [&](std::span<const Site> some, std::span<Vec3d> to) { others_->positions(some, level, to); });
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        evaluate(
            sites, Wanted::frames, level, out, [&](const Sums& sums, LimitPoint& point) { point = frame(sums.value); },
            [&](std::span<const Site> some, std::span<LimitPoint> to) { others_->frames(some, level, to); });
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        evaluate(
            sites, Wanted::limits, 0, out, [](const Sums& sums, Vec3d& point) { point = sums.value[0]; },
            [&](std::span<const Site> some, std::span<Vec3d> to) { others_->limit_positions(some, to); });
    }
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const override {
        evaluate(
            sites, Wanted::normals, 0, out,
            [](const Sums& sums, Vec3d& normal) { normal = RowPatterns::normal_of(sums.value.data()); },
            [&](std::span<const Site> some, std::span<Vec3d> to) { others_->normals(some, to); });
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        std::vector<std::uint8_t> missing(sites.size(), 0);
        find(
            sites, Wanted::normals, 0, out,
            [](const Sums& sums, LimitPoint& point) {
                point.normal = RowPatterns::normal_of(sums.value.data());
                point.tangent1 = sums.value[0];
                point.tangent2 = sums.value[1];
                point.has_tangent_plane = sums.last_row < 2;
            },
            missing);
        find(
            sites, Wanted::limits, 0, out, [](const Sums& sums, LimitPoint& point) { point.position = sums.value[0]; },
            missing);
        fill_missing(sites, out, missing,
                     [&](std::span<const Site> some, std::span<LimitPoint> to) { others_->limits(some, to); });
    }

  private:
    struct Rows {
        std::unique_ptr<const RepeatedRows> all;
        std::vector<std::uint32_t> root_halfedge;  ///< by root of sites, as RepeatedRows::corner_halfedges()
        int limit_level = 0;                       ///< RepeatedRows::limit_level()
        /// Points of the levels from the first on that are whole; rows go up to the last of these.
        std::array<std::vector<Vec3d>, k_max_level + 2> whole;
        std::atomic<std::size_t> whole_count = 0;
        std::array<std::uint64_t, k_max_level + 2> asked{};  ///< sites so far, by levels from the first on
        /// In cells too large for rows of their own the limit at the middle of a cell, where four finer ones meet, is a
        /// sum of their points: x, y = 0 stand right above.
        std::vector<RegularLimit::LatticeTerm> middle, tangents[2];
        int middle_depth = 0;  ///< levels down to those; 0: there are none

        int first_level() const { return all->first_level(); }
        const RootLattices& net() const { return all->net(); }
        RootLayout layout(std::size_t from_first) const {
            return net().layout(all->segments(first_level() + static_cast<int>(from_first)));
        }
    };

    bool dual() const { return roots_.count() != 0; }
    /// Levels of the scheme to one of lattices.
    int offset() const { return triangles_ ? 0 : 1; }

    /// The rows, once they are worth it for all the sites that have been asked for.
    const Rows* rows_for(std::span<const Site> sites, Wanted wanted, int level) const {
        const std::lock_guard lock(mutex_);
        // Tasks of callers that wait for the lock must not be taken up by this thread.
        oneapi::tbb::this_task_arena::isolate([&] {
            if (!tried_) {
                asked_ += sites.size();
                const std::uint64_t cells = triangles_ ? mesh_.face_count() / 2 + 1 : mesh_.halfedge_count(),
                                    points = cells << (2 * k_first_lattice_level);
                // Else results would depend on the calls before.
                if (whole_levels_ && points > k_points_per_site * asked_) return;
                tried_ = true;
                rows_ = make();
            }
            if (rows_ && whole_levels_) make_whole_levels(*rows_, sites, wanted, level);
        });
        return rows_.get();
    }

    /// Those for which enough sites at them and further down have been asked for.
    void make_whole_levels(Rows& rows, std::span<const Site> sites, Wanted wanted, int level) const {
        for (const Site& site : sites)
            if (const Address at = address(rows, site, wanted, level); at.level >= rows.first_level())
                ++rows.asked[static_cast<std::size_t>(at.level - rows.first_level())];
        for (std::size_t next = rows.whole_count; next < rows.whole.size(); ++next) {
            std::uint64_t deeper = 0;
            for (std::size_t l = next; l < rows.asked.size(); ++l) deeper += rows.asked[l];
            const std::uint64_t points = 4 * rows.whole[next - 1].size();
            if (points > std::min(k_points_whole * deeper, most_whole_)) return;
            const RootLayout above = rows.layout(next - 1), layout = rows.layout(next);
            resize_large(rows.whole[next], rows.net().place_count(layout));
            rows.all->step_to(rows.first_level() + static_cast<int>(next))
                .apply(above, layout, rows.whole[next - 1].data(), rows.whole[next].data(), {{}, 0, 1});
            rows.whole_count = next + 1;
        }
    }

    std::unique_ptr<Rows> make() const {
        RepeatedRows::Demand demand;
        demand.limit = demand.even_if_slower = demand.any_level = true;
        // Without tangents, or with such as depend on the level.
        demand.normals = !is_linear(scheme_) && !rules_.hoppe_crease;
        demand.most_points = static_cast<double>(most_by_rules_);
        auto result = std::make_unique<Rows>();
        try {
            auto by_rules = std::make_unique<RuleLevels>(mesh_, scheme_, rules_, 0);
            RunContext limits;
            limits.max_memory_bytes = max_memory_bytes_;
            result->all = RepeatedRows::make(mesh_, scheme_, k_settling_levels, rules_, by_rules, demand, limits);
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
        resize_large(result->whole[0], net.place_count(result->layout(0)));
        result->all->first_points(mesh_.positions(), result->whole[0].data());
        result->whole_count = 1;
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
            rows.middle_depth = middle_depth(rows);
            return;
        }
    }

    /// So far down that beyond the points it takes as many again are left to the ends of the cell, where rows may be
    /// others.
    static int middle_depth(const Rows& rows) {
        for (int finer = 2; finer <= k_deepest_middle; ++finer) {
            const int reach = 1 << (finer - 1);
            const auto inside = [&](int i) { return -reach <= 2 * i && 2 * (i + 1) <= reach; };
            bool all = !rows.middle.empty();
            for (const auto* terms : {&rows.middle, &rows.tangents[0], &rows.tangents[1]})
                for (const RegularLimit::LatticeTerm& term : *terms) all = all && inside(term.x) && inside(term.y);
            if (all) return finer;
        }
        return 0;
    }

    /// The net about a vertex, from its point and those of RootLattices::around(), the first once more where they
    /// close.
    LimitPoint frame(std::span<const Vec3d> p) const {
        Vec3d normal(0);
        if (rows_->net().side_count() == 4)
            for (std::size_t i = 1; i + 2 < p.size(); i += 2) normal += glm::cross(p[i + 1] - p[0], p[i + 2] - p[i]);
        else
            for (std::size_t i = 1; i + 1 < p.size(); ++i) normal += glm::cross(p[i] - p[0], p[i + 1] - p[0]);
        return frame_from(p[0], normal, p[1] - p[0]);
    }

    /// @param finish  (sums, result); a normal that is zero is none
    /// @param others  (sites, results): the others' for those that have no rows
    template <class Result, class Finish, class Others>
    void evaluate(std::span<const Site> sites, Wanted wanted, int level, std::span<Result> out, const Finish& finish,
                  const Others& others) const {
        std::vector<std::uint8_t> missing(sites.size(), 0);
        find(sites, wanted, level, out, finish, missing);
        fill_missing(sites, out, missing, others);
    }

    /// @param missing  results that have no rows are set to 1
    template <class Result, class Finish>
    void find(std::span<const Site> sites, Wanted wanted, int level, std::span<Result> out, const Finish& finish,
              std::span<std::uint8_t> missing) const {
        const Rows* const rows = rows_for(sites, wanted, level);
        if (rows == nullptr) return std::fill(missing.begin(), missing.end(), std::uint8_t{1});
        for_each_block(static_cast<std::uint32_t>(sites.size()), k_sites_at_once,
                       [&](std::uint32_t begin, std::uint32_t end) {
                           const std::size_t count = end - begin;
                           block(*rows, sites.subspan(begin, count), wanted, level, out.subspan(begin, count),
                                 missing.subspan(begin, count), finish);
                       });
    }

    template <class Result, class Others>
    static void fill_missing(std::span<const Site> sites, std::span<Result> out, std::span<const std::uint8_t> missing,
                             const Others& others) {
        std::vector<Site> left;
        for (std::size_t i = 0; i < sites.size(); ++i)
            if (missing[i] != 0) left.push_back(sites[i]);
        if (left.empty()) return;
        std::vector<Result> found(left.size());
        others(std::span<const Site>(left), std::span<Result>(found));
        for (std::size_t i = 0, k = 0; i < sites.size(); ++i)
            if (missing[i] != 0) out[i] = found[k++];
    }

    /// Where a site is in the lattices, at the level that its result has rows of.
    struct Address {
        int level = -1;  ///< of the scheme; -1: it has none
        std::uint32_t halfedge = 0, x = 0, y = 0;
        std::uint32_t half_cell = 0;  ///< not 0: the middle of the cell is asked for
    };
    Address address(const Rows& rows, const Site& any, Wanted wanted, int level) const {
        const Site site = dual() ? any : minimal_level(any);
        Address at;
        at.halfedge = rows.root_halfedge[site.root.value];
        if (at.halfedge == MeshLevel::none) return {};
        const int own = site.level + offset();
        if (wanted == Wanted::frames && dual()) return {};
        if (wanted == Wanted::positions && dual() && level != own) return {};  // no vertex of that level
        if (wanted == Wanted::normals && !rows.all->has_normals()) return {};
        if (wanted == Wanted::limits || wanted == Wanted::normals) {
            level = std::max(own, rows.limit_level);
            // Roots that are no faces' corners reach beyond the surface's end or a crease.
            const bool beyond = site.root.value >= mesh_.halfedge_count() && dual();
            if (dual() && level > own) {
                if (beyond || rows.middle_depth == 0) return {};
                level = std::max(own + rows.middle_depth, rows.first_level());
                at.half_cell = 1u << (level - own - 1);
            }
            // Where creases are shared, a normal is the mean of two sides.
            if (wanted == Wanted::normals && beyond && rows.net().shares_points()) return {};
        }
        if (level < rows.first_level() || site.level + level - own > k_max_level) return {};
        at.level = level;
        at.x = site.at.x << (level - own);
        at.y = site.at.y << (level - own);
        return at;
    }

    template <class Result, class Finish>
    void block(const Rows& rows, std::span<const Site> sites, Wanted wanted, int level, std::span<Result> out,
               std::span<std::uint8_t> missing, const Finish& finish) const {
        Workspace& work = workspaces_.local();
        for (LevelVertices& vertices : work.levels) vertices.clear();
        work.terms.clear();
        const std::size_t base = rows.whole_count - 1;
        std::vector<std::size_t> begin, level_of;
        std::size_t deepest = base;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            begin.push_back(work.terms.source.size());
            level_of.push_back(base);
            const Address at = address(rows, sites[i], wanted, level);
            if (at.level < 0) missing[i] = 1;
            if (missing[i] != 0) continue;
            level_of[i] = static_cast<std::size_t>(at.level - rows.first_level());
            add(rows, at, wanted, base, work);
            deepest = std::max(deepest, level_of[i]);
        }
        begin.push_back(work.terms.source.size());
        const RootLayout base_layout = rows.layout(base);
        evaluate_levels(
            std::span(work.levels).subspan(base), static_cast<int>(deepest - base),
            [&](const RootPlace& at, int l, const auto& add_term) {
                const int to = rows.first_level() + static_cast<int>(base) + l;
                rows.all->step_to(to).read(
                    rows.all->segments(to - 1), at,
                    [&](std::uint32_t, const RootPlace& from, double weight) { add_term(from, weight); });
            },
            [&](const RootPlace& at) {
                return rows.net().number_at(base_layout, at.root, {at.x, at.y});
            },
            rows.whole[base]);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            if (missing[i] != 0) continue;
            const std::vector<Vec3d>& value =
                level_of[i] <= base ? rows.whole[level_of[i]] : work.levels[level_of[i]].value;
            Sums& sums = work.sums;
            sums.value.assign(k_normal_rows, Vec3d(0));
            sums.last_row = 0;
            for (std::size_t k = begin[i]; k < begin[i + 1]; ++k) {
                sums.last_row = work.terms.row[k];
                if (sums.last_row >= sums.value.size()) sums.value.resize(sums.last_row + 1, Vec3d(0));
                sums.value[sums.last_row] += work.terms.weight[k] * value[work.terms.source[k]];
            }
            if (wanted == Wanted::frames) sums.value.resize(sums.last_row + 1);
            finish(std::as_const(sums), out[i]);
            if (wanted == Wanted::normals && RowPatterns::normal_of(sums.value.data()) == Vec3d(0)) missing[i] = 1;
        }
    }

    /// The terms of a site's sums.
    /// @param base  the last whole level
    static void add(const Rows& rows, const Address& address, Wanted wanted, std::size_t base, Workspace& work) {
        const RootLattices& net = rows.net();
        const std::uint32_t segments = rows.all->segments(address.level), h = address.halfedge;
        const auto level = static_cast<std::size_t>(address.level - rows.first_level());
        const RootLayout layout = rows.layout(level);
        const auto take = [&](std::uint32_t row, const RootPlace& p, double weight) {
            work.terms.source.push_back(level <= base ? net.number_at(layout, p.root, {p.x, p.y})
                                                      : work.levels[level].insert(p));
            work.terms.weight.push_back(weight);
            work.terms.row.push_back(row);
        };
        if (address.half_cell != 0) {
            const auto sum = [&](std::uint32_t row, const std::vector<RegularLimit::LatticeTerm>& terms) {
                const std::uint32_t x = address.x + address.half_cell, y = address.y + address.half_cell;
                for (const RegularLimit::LatticeTerm& term : terms)
                    take(row,
                         net.place_seen(segments, h, x + static_cast<std::uint32_t>(term.x),
                                        y + static_cast<std::uint32_t>(term.y)),
                         term.weight);
            };
            sum(0, wanted == Wanted::limits ? rows.middle : rows.tangents[0]);
            if (wanted == Wanted::normals) sum(1, rows.tangents[1]);
            return;
        }
        const RootPlace at = net.own_place(segments, net.place_seen(segments, h, address.x, address.y));
        if (wanted == Wanted::positions || wanted == Wanted::frames) {
            take(0, at, 1);
            if (wanted == Wanted::positions) return;
            RootLattices::Around around = net.around(segments, at);
            if (around.closed) around.places.push_back(around.places.front());
            for (std::uint32_t k = 0; k < around.places.size(); ++k) take(k + 1, around.places[k], 1);
        } else {
            (wanted == Wanted::limits ? rows.all->limit() : rows.all->normals()).read(segments, at, take);
        }
    }

    bool whole_levels_;
    const ControlMesh& mesh_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::shared_ptr<const LevelSource> others_;
    VertexRoots roots_;
    bool triangles_;
    std::uint64_t max_memory_bytes_;
    std::uint64_t most_by_rules_ = k_most_by_rules, most_whole_ = k_most_whole;
    mutable std::mutex mutex_;
    mutable std::uint64_t asked_ = 0;  ///< sites so far
    mutable bool tried_ = false;
    mutable std::unique_ptr<Rows> rows_;
    mutable oneapi::tbb::enumerable_thread_specific<Workspace> workspaces_{};  ///< what blocks have grown
};

}  // namespace

std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, std::shared_ptr<const LevelSource> others,
                                              const VertexRoots* roots, const RunContext& context, bool whole_levels) {
    return std::make_shared<RowPoints>(mesh, scheme, rules, std::move(others), roots, context, whole_levels);
}

}  // namespace tetrakis::detail
