#include "site_rows.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../schemes/analysis/limit_search.hpp"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Most vertices of a level by the rules, a minute's work that cannot be cancelled; and the bytes that each takes.
constexpr std::uint64_t k_most_by_rules = std::uint64_t{1} << 24;
constexpr std::uint64_t k_point_bytes = 300;
/// Points, or limits, of a whole level that rows make in the time that a single point takes by itself.
constexpr std::uint64_t k_points_whole = 8;
/// Most points of a level that rows make whole: 200 MB.
constexpr std::uint64_t k_most_whole = 1u << 22;
constexpr std::uint64_t k_whole_bytes = 2 * sizeof(Vec3d);  ///< the point and its limit
/// Share of the memory limit that the first level may take.
constexpr std::uint64_t k_memory_share = 4;
/// Steps after which no semi-sharp tag may be left.
constexpr int k_settling_levels = 16;
/// Most levels below a cell on which the limit at its centre may be evaluated.
constexpr int k_deepest_middle = 4;
/// Sites evaluated together: enough to share ancestors, few enough for their levels to stay in the cache.
constexpr std::uint32_t k_sites_at_once = 2048;
/// Deepest lattice level of factor three: 3^20 is the last power below 2^32.
constexpr int k_max_ternary_level = 20;
/// Number of rows of a normal.
constexpr std::uint32_t k_normal_rows = 4;

/// The vertices of one level that a block of sites needs, each once, with stencils of points of the level before.
class LevelVertices {
  public:
    std::vector<RootPlace> keys;
    std::vector<std::uint32_t> stencil_begin;  ///< per key, into `source` and `weight`
    std::vector<std::uint32_t> source;         ///< vertices of the level above
    std::vector<double> weight;
    std::vector<Vec3d> value;

    std::uint32_t insert(const RootPlace& key) {
        if (2 * (keys.size() + 1) > slots_.size()) grow();
        std::uint32_t& slot = slots_[slot_of(key)];
        if (slot == 0) {
            keys.push_back(key);
            slot = static_cast<std::uint32_t>(keys.size());
        }
        return slot - 1;
    }
    /// O(elements); the table keeps its size.
    void clear() {
        for (const RootPlace& key : keys)
            for (std::size_t i = home(key); slots_[i] != 0; i = after(i)) slots_[i] = 0;
        keys.clear();
        stencil_begin.clear();
        source.clear();
        weight.clear();
        value.clear();
    }

  private:
    std::size_t home(const RootPlace& key) const {
        // Multiplicative mixing (Knuth, TAOCP 3, 6.4, with 64-bit odd constants), the upper bits being the good ones.
        std::uint64_t h = (std::uint64_t{key.x} << 32 | key.y) * 0x9E37'79B9'7F4A'7C15u;
        h = (h ^ h >> 29 ^ key.root) * 0xBF58'476D'1CE4'E5B9u;
        return (h ^ h >> 32) & (slots_.size() - 1);
    }
    std::size_t after(std::size_t slot) const { return (slot + 1) & (slots_.size() - 1); }
    /// Of the key, or the empty one where it would be.
    std::size_t slot_of(const RootPlace& key) const {
        std::size_t i = home(key);
        while (slots_[i] != 0 && keys[slots_[i] - 1] != key) i = after(i);
        return i;
    }
    void grow() {
        slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), 0);
        for (std::uint32_t k = 0; k < keys.size(); ++k) slots_[slot_of(keys[k])] = k + 1;
    }

    std::vector<std::uint32_t> slots_;  ///< a key's number and one; 0: empty
};

}  // namespace

struct SiteRows::Workspace {
    /// A term in the sums of a site whose level is not whole.
    struct Term {
        std::uint32_t row, source;  ///< source: number in the level's LevelVertices
        double weight;
    };
    struct Site {
        std::size_t number, level, end;  ///< end: of the site's range in `terms`
    };

    std::array<LevelVertices, k_max_level + 2> levels;  ///< from the first level of the rows on
    std::vector<Site> sites;
    std::vector<Term> terms;
    Sums sums;

    void add_to_sums(std::uint32_t row, double weight, const Vec3d& point) {
        sums.last_row = row;
        if (row >= sums.value.size()) sums.value.resize(row + 1, Vec3d(0));
        sums.value[row] += weight * point;
    }
};

struct SiteRows::Rows {
    /// A term of a mask: the place of its point relative to the mask's centre, and its weight.
    struct LatticeTerm {
        int x = 0, y = 0;
        double weight = 0;
    };

    std::unique_ptr<const RepeatedRows> all;
    std::span<const std::uint32_t> root_halfedge;  ///< by root of sites, as RepeatedRows::corner_halfedges()
    int limit_level = 0;                           ///< RepeatedRows::limit_level()
    /// Points and limits of the whole levels, from first_level() on. Deeper levels are summed from the last of them.
    std::array<std::vector<Vec3d>, k_max_level + 2> whole, whole_limits;
    std::atomic<std::size_t> whole_count = 0;
    std::array<std::atomic<bool>, k_max_level + 2> has_whole_limits{};
    std::array<std::uint64_t, k_max_level + 2> asked{}, asked_limits{};  ///< points and limits so far, by levels
    /// Masks of limit and tangents at the centre of a cell before `limit_level`, on finer cells, four of which meet
    /// there. The cell at x, y = 0 is to the upper right of the centre.
    std::vector<LatticeTerm> middle, tangents[2];
    int middle_depth = 0;  ///< levels from the cell to the finer cells; 0: there are no masks

    /// The fewest levels after which the masks use only cells of the cell's inner half: near its ends, points may obey
    /// other rows.
    int find_middle_depth() const {
        for (int finer = 2; finer <= k_deepest_middle; ++finer) {
            const int reach = 1 << (finer - 1);
            const auto inside = [&](int i) { return -reach <= 2 * i && 2 * (i + 1) <= reach; };
            bool inner = !middle.empty();
            for (const auto* terms : {&middle, &tangents[0], &tangents[1]})
                for (const LatticeTerm& term : *terms) inner = inner && inside(term.x) && inside(term.y);
            if (inner) return finer;
        }
        return 0;
    }

    int first_level() const { return all->first_level(); }
    const RootLattices& net() const { return all->net(); }
    RootLayout layout(std::size_t from_first) const {
        return net().layout(all->segments(first_level() + static_cast<int>(from_first)));
    }
};

/// Lattice coordinates of a site on the level whose points its result is a sum of.
struct SiteRows::Address {
    int level = -1;  ///< of the scheme; -1: the site has no rows
    std::uint32_t halfedge = 0, x = 0, y = 0;
    std::uint32_t half_cell = 0;  ///< not 0: the result is at the cell's centre, so far from x and y
};

SiteRows::SiteRows(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                   const VertexRoots& roots, const RunContext& context, bool whole_levels)
    : mesh_(mesh),
      scheme_(scheme),
      rules_(rules),
      roots_(roots),
      triangles_(scheme.family == MeshFamily::triangles),
      whole_levels_(whole_levels),
      factor_(scheme.refinement == Refinement::sqrt3 ? 3 : 2),
      max_memory_bytes_(context.max_memory_bytes),
      most_by_rules_(k_most_by_rules),
      most_whole_(k_most_whole) {
    if (max_memory_bytes_ == 0) return;
    most_by_rules_ = std::min(most_by_rules_, max_memory_bytes_ / k_memory_share / k_point_bytes);
    most_whole_ = std::min(most_whole_, max_memory_bytes_ / k_memory_share / k_whole_bytes);
}

/// Null if rows do not repeat or the first level is too large.
const SiteRows::Rows* SiteRows::rows_for(std::span<const Site> sites, Wanted wanted, int level) const {
    const std::lock_guard lock(mutex_);
    // This thread must not take over tasks of callers that wait for the lock.
    oneapi::tbb::this_task_arena::isolate([&] {
        if (!std::exchange(tried_, true)) rows_ = make();
        if (rows_ && whole_levels_) make_whole_levels(*rows_, sites, wanted, level);
    });
    return rows_.get();
}

std::shared_ptr<SiteRows::Rows> SiteRows::make() const {
    auto rows = std::make_shared<Rows>();
    // If some vertex has no tangents, rows without normals are tried; if some has no limit, also rows without limits.
    const bool smooth = !scheme_.is_linear();
    for (const auto& [limit, normals] : {std::pair(true, smooth), std::pair(true, false), std::pair(false, false)})
        if (!rows->all) rows->all = repeated_rows(limit, normals);
    if (!rows->all) return nullptr;
    if (rows->all->has_limit()) {
        rows->limit_level = *rows->all->limit_level();
        if (dual()) set_middle(*rows);
    }
    rows->root_halfedge = dual() ? std::span(roots_.net_halfedge) : rows->all->corner_halfedges();
    resize_large(rows->whole[0], rows->net().place_count(rows->layout(0)));
    rows->all->first_points(mesh_.positions(), rows->whole[0].data());
    rows->whole_count = 1;
    return rows;
}

std::unique_ptr<const RepeatedRows> SiteRows::repeated_rows(bool limit, bool normals) const {
    RepeatedRows::Demand demand;
    demand.limit = limit;
    demand.normals = normals;
    demand.even_if_slower = demand.any_level = true;
    demand.most_points = static_cast<double>(most_by_rules_);
    RunContext limits;
    limits.max_memory_bytes = max_memory_bytes_;
    try {
        auto levels = std::make_unique<RuleLevels>(mesh_, scheme_, rules_, 0);
        std::unique_ptr<const RepeatedRows> rows =
            RepeatedRows::make(mesh_, scheme_, k_settling_levels, rules_, levels, demand, limits);
        if (!rows || rows->corner_halfedges().empty() || (limit && !rows->limit_level())) return nullptr;
        return rows;
    } catch (const Error&) {  // WholeLevels reports the error
        return nullptr;
    }
}

/// Makes the next levels whole if calls have asked for enough points of them or of deeper levels; likewise the limits.
void SiteRows::make_whole_levels(Rows& rows, std::span<const Site> sites, Wanted wanted, int level) const {
    for (const Site& site : sites) {
        const Address at = address(rows, site, wanted, level);
        if (at.level < rows.first_level()) continue;
        const auto l = static_cast<std::size_t>(at.level - rows.first_level());
        const bool middle = at.half_cell != 0;
        if (wanted == Wanted::limits)
            rows.asked[l] += middle ? rows.middle.size() : rows.all->limit().terms_inside();
        else
            rows.asked[l] += wanted == Wanted::normals ? rows.all->normals().terms_inside() : 1;
        if (wanted == Wanted::limits && !middle) ++rows.asked_limits[l];
    }
    for (std::size_t next = rows.whole_count; next < rows.whole.size(); ++next) {
        std::uint64_t deeper = 0;
        for (std::size_t l = next; l < rows.asked.size(); ++l) deeper += rows.asked[l];
        const std::uint64_t points = std::uint64_t{factor_} * factor_ * rows.whole[next - 1].size();
        if (points > std::min(k_points_whole * deeper, most_whole_)) break;
        const RootLayout above = rows.layout(next - 1), layout = rows.layout(next);
        resize_large(rows.whole[next], rows.net().place_count(layout));
        rows.all->step_to(rows.first_level() + static_cast<int>(next))
            .apply(above, layout, rows.whole[next - 1].data(), rows.whole[next].data(), {{}, 0, 1});
        rows.whole_count = next + 1;
    }
    for (std::size_t l = 0; l < rows.whole_count; ++l) {
        const std::vector<Vec3d>& points = rows.whole[l];
        if (rows.has_whole_limits[l] || points.size() > k_points_whole * rows.asked_limits[l]) continue;
        const RootLayout layout = rows.layout(l);
        resize_large(rows.whole_limits[l], points.size());
        rows.all->limit().apply(layout, layout, points.data(), rows.whole_limits[l].data(), {{}, 0, 1});
        rows.has_whole_limits[l] = true;
    }
}

/// Finds the scheme's masks for limit and tangents where four regular cells meet.
void SiteRows::set_middle(Rows& rows) const {
    const int rings = rule_limit_rings(scheme_, rules_), side = 2 * rings + 4;
    RuleMesh::Builder faces;
    for (int y = 0; y + 1 < side; ++y)
        for (int v = y * side; v + 1 < (y + 1) * side; ++v) faces.face({v, v + 1, v + side + 1, v + side});
    const RuleMesh mesh(side * side, std::move(faces));
    const int face = (rings + 1) * (side - 1) + rings + 1;
    const std::optional<LimitRows> found = LimitSearch(scheme_, rules_).at_face(mesh, mesh.face_begin(face));
    if (!found || found->tangents.size() != 1) return;
    // The face's third corner is to the upper right of its centre.
    const auto take = [&](const StencilRow& row, std::vector<Rows::LatticeTerm>& terms) {
        for (const auto& [v, weight] : row.terms) terms.push_back({v % side - rings - 2, v / side - rings - 2, weight});
    };
    take(found->limit, rows.middle);
    take(found->tangents[0][0], rows.tangents[0]);
    take(found->tangents[0][1], rows.tangents[1]);
    rows.middle_depth = rows.find_middle_depth();
}

SiteRows::Address SiteRows::address(const Rows& rows, const Site& any, Wanted wanted, int level) const {
    const Site site = own_site(any);
    Address at;
    at.halfedge = rows.root_halfedge[site.root.value];
    const int own = site.level + offset();
    if (level == k_own_level) level = own;
    if (wanted == Wanted::limits || wanted == Wanted::normals) {
        if (wanted == Wanted::limits ? !rows.all->has_limit() : !rows.all->has_normals()) return {};
        level = std::max(level, rows.limit_level);
        if (dual() && level > own) {
            // Roots that are not at face corners reach beyond the end of the surface or a crease.
            if (site.root.value >= mesh_.halfedge_count() || rows.middle_depth == 0) return {};
            level = std::max(own + rows.middle_depth, rows.first_level());
            at.half_cell = 1u << (level - own - 1);
        }
    }
    if (level < rows.first_level() || site.level + level - own > (factor_ == 2 ? k_max_level : k_max_ternary_level))
        return {};
    std::uint32_t scale = 1;
    for (int l = own; l < level; ++l) scale *= factor_;
    at.level = level;
    at.x = site.at.x * scale;
    at.y = site.at.y * scale;
    return at;
}

std::vector<std::size_t> SiteRows::evaluate(std::span<const Site> sites, Wanted wanted, int level,
                                            const std::function<void(std::size_t, const Sums&)>& finish) const {
    const Rows* const rows = rows_for(sites, wanted, level);
    std::vector<std::uint8_t> missing(sites.size(), 1);
    if (rows != nullptr)
        for_each_block(static_cast<std::uint32_t>(sites.size()), k_sites_at_once,
                       [&](std::uint32_t begin, std::uint32_t end) {
                           evaluate_block(*rows, sites.subspan(begin, end - begin), begin, wanted, level,
                                          std::span(missing).subspan(begin, end - begin), finish);
                       });
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < sites.size(); ++i)
        if (missing[i] != 0) others.push_back(i);
    return others;
}

/// @param first  number of sites[0] among all sites
void SiteRows::evaluate_block(const Rows& rows, std::span<const Site> sites, std::size_t first, Wanted wanted,
                              int level, std::span<std::uint8_t> missing,
                              const std::function<void(std::size_t, const Sums&)>& finish) const {
    std::shared_ptr<Workspace>& own = workspaces_.local();
    if (!own) own = std::make_shared<Workspace>();
    Workspace& work = *own;
    for (LevelVertices& vertices : work.levels) vertices.clear();
    work.sites.clear();
    work.terms.clear();
    const std::size_t base = rows.whole_count - 1;
    std::size_t deepest = base;
    const auto clear_sums = [&] {
        work.sums.value.assign(k_normal_rows, Vec3d(0));
        work.sums.last_row = 0;
    };
    const auto finish_sums = [&](std::size_t i) {
        if (wanted == Wanted::rings) work.sums.value.resize(work.sums.last_row + 1);
        finish(first + i, work.sums);
    };
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Address at = address(rows, sites[i], wanted, level);
        missing[i] = at.level < 0 ? 1 : 0;
        if (missing[i] != 0) continue;
        const auto l = static_cast<std::size_t>(at.level - rows.first_level());
        if (l > base) {
            for_each_term(rows, at, wanted, [&](std::uint32_t row, const RootPlace& p, double weight) {
                work.terms.push_back({row, work.levels[l].insert(p), weight});
            });
            work.sites.push_back({i, l, work.terms.size()});
            deepest = std::max(deepest, l);
            continue;
        }
        const RootLayout layout = rows.layout(l);
        const bool limit_known = wanted == Wanted::limits && at.half_cell == 0 && rows.has_whole_limits[l];
        const std::vector<Vec3d>& value = limit_known ? rows.whole_limits[l] : rows.whole[l];
        clear_sums();
        for_each_term(rows, at, limit_known ? Wanted::positions : wanted,
                      [&](std::uint32_t row, const RootPlace& p, double weight) {
                          work.add_to_sums(row, weight, value[rows.net().number_at(layout, p.root, {p.x, p.y})]);
                      });
        finish_sums(i);
    }
    evaluate_levels(rows, base, deepest, work);
    std::size_t begin = 0;
    for (const Workspace::Site& site : work.sites) {
        clear_sums();
        for (; begin < site.end; ++begin) {
            const Workspace::Term& term = work.terms[begin];
            work.add_to_sums(term.row, term.weight, work.levels[site.level].value[term.source]);
        }
        finish_sums(site.number);
    }
}

/// Computes the points of the vertices collected on the levels after the whole level `base`. It collects the vertices
/// that these need on each level before, from the deepest level upwards, and then evaluates from `base` downwards.
void SiteRows::evaluate_levels(const Rows& rows, std::size_t base, std::size_t deepest, Workspace& work) {
    const RootLayout base_layout = rows.layout(base);
    for (std::size_t l = deepest; l > base; --l) {
        LevelVertices &level = work.levels[l], &above = work.levels[l - 1];
        const int to = rows.first_level() + static_cast<int>(l);
        const std::uint32_t segments = rows.all->segments(to - 1);
        level.stencil_begin.push_back(0);
        for (const RootPlace& key : level.keys) {
            rows.all->step_to(to).read(segments, key, [&](std::uint32_t, const RootPlace& from, double weight) {
                level.source.push_back(l - 1 > base ? above.insert(from)
                                                    : rows.net().number_at(base_layout, from.root, {from.x, from.y}));
                level.weight.push_back(weight);
            });
            level.stencil_begin.push_back(static_cast<std::uint32_t>(level.source.size()));
        }
    }
    for (std::size_t l = base + 1; l <= deepest; ++l) {
        LevelVertices& level = work.levels[l];
        const std::vector<Vec3d>& above = l - 1 > base ? work.levels[l - 1].value : rows.whole[base];
        level.value.resize(level.keys.size());
        for (std::size_t i = 0; i < level.keys.size(); ++i) {
            Vec3d sum(0);
            for (std::uint32_t k = level.stencil_begin[i]; k < level.stencil_begin[i + 1]; ++k)
                sum += level.weight[k] * above[level.source[k]];
            level.value[i] = sum;
        }
    }
}

/// Calls take(row, place, weight) for the terms of a site's sums.
template <class Take>
void SiteRows::for_each_term(const Rows& rows, const Address& address, Wanted wanted, const Take& take) {
    const RootLattices& net = rows.net();
    const std::uint32_t segments = rows.all->segments(address.level), h = address.halfedge;
    if (address.half_cell != 0) {
        const auto sum = [&](std::uint32_t row, const std::vector<Rows::LatticeTerm>& terms) {
            const std::uint32_t x = address.x + address.half_cell, y = address.y + address.half_cell;
            for (const Rows::LatticeTerm& term : terms)
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
    if (wanted == Wanted::positions || wanted == Wanted::rings) {
        take(0, at, 1);
        if (wanted == Wanted::positions) return;
        RootLattices::Around around = net.around(segments, at);
        if (around.closed) around.places.push_back(around.places.front());
        for (std::uint32_t k = 0; k < around.places.size(); ++k) take(k + 1, around.places[k], 1);
    } else {
        (wanted == Wanted::limits ? rows.all->limit() : rows.all->normals()).read(segments, at, take);
    }
}

}  // namespace tetrakis::detail
