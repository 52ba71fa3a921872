#include "row_points.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../schemes/rules/linear.hpp"
#include "../rules/face_normals.hpp"
#include "../rules/rule_levels.hpp"
#include "../uniform/repeated_rows.hpp"
#include "level_frames.hpp"
#include "level_vertices.hpp"
#include "whole_levels.hpp"

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

/// The rules make so many vertices in a minute, and take so many bytes for each; nothing can be cancelled meanwhile.
constexpr std::uint64_t k_most_by_rules = std::uint64_t{1} << 24;
constexpr std::uint64_t k_point_bytes = 300;
/// So many points are made by rows, with all of their level, in the time in which one is found by itself.
constexpr std::uint64_t k_points_whole = 8;
/// Of such levels; 100 MB.
constexpr std::uint64_t k_most_whole = 1u << 22;
/// Share of the memory limit that the first level may take.
constexpr std::uint64_t k_memory_share = 4;
/// Steps in which all semi-sharp tags have to be gone.
constexpr int k_settling_levels = 16;
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

enum class Wanted { positions, rings, limits, normals };
/// In place of a level: that at which each site is a vertex first.
constexpr int k_own_level = -1;

/// Where the rules have a vertex, and its number there.
struct RuleVertex {
    const WholeLevels::Level& level;
    int v;

    Vec3d point() const { return level.points[static_cast<std::size_t>(v)]; }
};

class RowPoints final : public LevelSource {
  public:
    RowPoints(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const VertexRoots* roots,
              const RunContext& context, bool whole_levels)
        : whole_levels_(whole_levels),
          mesh_(mesh),
          scheme_(scheme),
          rules_(rules),
          by_rules_(mesh, scheme, rules, context),
          triangles_(scheme.family == MeshFamily::triangles),
          max_memory_bytes_(context.max_memory_bytes) {
        if (roots != nullptr) roots_ = *roots;
        if (context.max_memory_bytes != 0) {
            most_by_rules_ = std::min(most_by_rules_, context.max_memory_bytes / k_memory_share / k_point_bytes);
            most_whole_ = std::min(most_whole_, context.max_memory_bytes / k_memory_share / sizeof(Vec3d));
        }
    }

    int first_level(const Site& site) const override {
        const Site minimal = own_site(site);
        return minimal.level + (is_control_vertex(minimal) ? 0 : offset());
    }
    int max_level() const override { return k_max_level + offset(); }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        check_level(sites, level);
        points_of(sites, level, out);
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        check_level(sites, level);
        if (dual()) return frames_of_cells(sites, out);
        evaluate(
            sites, Wanted::rings, level, out, [&](const Sums& sums, LimitPoint& point) { point = frame(sums.value); },
            [](const RuleVertex& at, LimitPoint& point) { point = rule_frame(at); });
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        evaluate(
            sites, Wanted::limits, k_own_level, out, [](const Sums& sums, Vec3d& point) { point = sums.value[0]; },
            [&](const RuleVertex& at, Vec3d& point) { point = rule_limit(at).position; });
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        find_planes(sites, out);
        std::vector<Vec3d> points(sites.size());
        limit_positions(sites, points);
        for (std::size_t i = 0; i < points.size(); ++i) out[i].position = points[i];
    }
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const override {
        std::vector<LimitPoint> planes(sites.size());
        find_planes(sites, planes);
        for (std::size_t i = 0; i < planes.size(); ++i) out[i] = planes[i].normal;
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

        int first_level() const { return all->first_level(); }
        const RootLattices& net() const { return all->net(); }
        RootLayout layout(std::size_t from_first) const {
            return net().layout(all->segments(first_level() + static_cast<int>(from_first)));
        }
    };

    bool dual() const { return roots_.count() != 0; }
    /// Levels of the scheme to one of lattices.
    int offset() const { return triangles_ ? 0 : 1; }

    Site own_site(const Site& site) const { return dual() ? site : minimal_level(site); }
    /// Of quad schemes: it is there before there is a lattice.
    bool is_control_vertex(const Site& minimal) const {
        return !dual() && !triangles_ && minimal.level == 0 && minimal.at == LatticePoint{0, 0};
    }
    void check_level(std::span<const Site> sites, int level) const {
        for (const Site& site : sites)
            if (dual() && site.level + 1 != level)
                throw Error(ErrorCode::unsupported, "a dual scheme has other vertices on every level: one of level " +
                                                        std::to_string(site.level + 1) + " is none of level " +
                                                        std::to_string(level));
    }

    /// Null where rows do not repeat, or the first level is too large.
    const Rows* rows_for(std::span<const Site> sites, Wanted wanted, int level) const {
        const std::lock_guard lock(mutex_);
        // Tasks of callers that wait for the lock must not be taken up by this thread.
        oneapi::tbb::this_task_arena::isolate([&] {
            if (!std::exchange(tried_, true)) rows_ = make();
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
        auto result = std::make_unique<Rows>();
        // Without tangents, or without limits, where one vertex has none.
        const bool smooth = !is_linear(scheme_);
        for (const auto& [limit, normals] : {std::pair(true, smooth), std::pair(true, false), std::pair(false, false)})
            if ((result->all = rows_with(limit, normals)) != nullptr) break;
        if (!result->all) return nullptr;
        if (result->all->has_limit()) result->limit_level = *result->all->limit_level();
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

    std::unique_ptr<const RepeatedRows> rows_with(bool limit, bool normals) const {
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
        } catch (const Error&) {  // whole levels say what is wrong
            return nullptr;
        }
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

    static LimitPoint rule_frame(const RuleVertex& at) {
        const RuleMesh& mesh = at.level.step.mesh;
        const std::vector<Vec3d>& net = at.level.points;
        Vec3d normal(0);
        const RuleMesh::Ring ring = mesh.ring(at.v);
        for (const int h : ring.halfedge) {
            const auto corners = mesh.corners(mesh.face(h));
            for (std::size_t i = 1; i + 1 < corners.size(); ++i)
                normal += glm::cross(net[corners[i]] - net[corners[0]], net[corners[i + 1]] - net[corners[0]]);
        }
        return frame_from(at.point(), normal, net[ring.neighbour[0]] - at.point());
    }
    const LimitPoint& rule_limit(const RuleVertex& at) const {
        if (at.level.has_limit[static_cast<std::size_t>(at.v)] == 0)
            throw Error(ErrorCode::unsupported,
                        std::string(scheme_.name) + " has no limit mask for vertex " + std::to_string(at.v) +
                            " of a level; leave out the limit",
                        mesh_.data().source);
        return at.level.limits[static_cast<std::size_t>(at.v)];
    }

    void points_of(std::span<const Site> sites, int level, std::span<Vec3d> out) const {
        evaluate(
            sites, Wanted::positions, level, out, [](const Sums& sums, Vec3d& point) { point = sums.value[0]; },
            [](const RuleVertex& at, Vec3d& point) { point = at.point(); });
    }

    /// @param finish   (sums of rows, result)
    /// @param by_rule  (vertex of a whole level, result), of those that have no rows
    template <class Result, class Finish, class ByRule>
    void evaluate(std::span<const Site> sites, Wanted wanted, int level, std::span<Result> out, const Finish& finish,
                  const ByRule& by_rule) const {
        const Rows* const rows = rows_for(sites, wanted, level);
        std::vector<std::uint8_t> missing(sites.size(), 1);
        if (rows != nullptr)
            for_each_block(static_cast<std::uint32_t>(sites.size()), k_sites_at_once,
                           [&](std::uint32_t begin, std::uint32_t end) {
                               const std::size_t count = end - begin;
                               block(*rows, sites.subspan(begin, count), wanted, level, out.subspan(begin, count),
                                     std::span(missing).subspan(begin, count), finish);
                           });
        const bool limits = wanted == Wanted::limits || wanted == Wanted::normals;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            if (missing[i] == 0) continue;
            const int at = level != k_own_level ? level : own_site(sites[i]).level + offset();
            const WholeLevels::Level& made = limits ? by_rules_.level_with_limits(at) : by_rules_.level(at);
            by_rule(RuleVertex{made, by_rules_.vertex(sites[i], at)}, out[i]);
        }
    }

    /// Tangents and normals.
    void find_planes(std::span<const Site> sites, std::span<LimitPoint> out) const {
        // On creases of dual schemes each side has rows of its own.
        std::vector<Site> sides;
        std::vector<std::size_t> begin;
        for (const Site& site : sites) {
            begin.push_back(sides.size());
            if (dual())
                for (const VertexCell& cell : roots_.sides(site_cell(site))) sides.push_back(cell_site(cell));
            else
                sides.push_back(site);
        }
        begin.push_back(sides.size());
        std::vector<LimitPoint> found(sides.size());
        if (!is_linear(scheme_))
            evaluate(
                std::span<const Site>(sides), Wanted::normals, k_own_level, std::span(found),
                [](const Sums& sums, LimitPoint& point) {
                    point.normal = RowPatterns::normal_of(sums.value.data());
                    point.tangent1 = sums.value[0];
                    point.tangent2 = sums.value[1];
                    point.has_tangent_plane = sums.last_row < 2 && point.normal != Vec3d(0);
                },
                [&](const RuleVertex& at, LimitPoint& point) { point = rule_limit(at); });
        std::vector<Site> flat;
        std::vector<std::size_t> number;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            out[i] = found[begin[i]];
            for (std::size_t k = begin[i] + 1; k < begin[i + 1]; ++k) out[i].normal += found[k].normal;
            if (begin[i + 1] > begin[i] + 1) {
                out[i].normal = unit_of_sum(out[i].normal);
                out[i].has_tangent_plane = false;
            }
            if (out[i].normal != Vec3d(0)) continue;
            flat.push_back(sites[i]);
            number.push_back(i);
        }
        std::vector<Vec3d> normals(flat.size());
        if (!flat.empty()) face_normals(flat, normals);
        for (std::size_t i = 0; i < flat.size(); ++i) out[number[i]].normal = normals[i];
    }

    /// From the faces around the sites where they are vertices first (FaceNormals).
    void face_normals(std::span<const Site> sites, std::span<Vec3d> out) const {
        if (dual()) {
            std::vector<FaceNormals> sums(sites.size());
            for_each_face_of_cells(sites, [&](std::size_t i, std::span<const Vec3d> face) { sums[i].add(face, 0); });
            for (std::size_t i = 0; i < sites.size(); ++i) out[i] = sums[i].normal();
            return;
        }
        evaluate(
            sites, Wanted::rings, k_own_level, out,
            [&](const Sums& sums, Vec3d& normal) {
                FaceNormals faces;
                const std::vector<Vec3d>& p = sums.value;
                if (rows_->net().side_count() == 4)
                    for (std::size_t i = 1; i + 2 < p.size(); i += 2)
                        faces.add(std::array{p[0], p[i], p[i + 1], p[i + 2]}, 0);
                else
                    for (std::size_t i = 1; i + 1 < p.size(); ++i) faces.add(std::array{p[0], p[i], p[i + 1]}, 0);
                normal = faces.normal();
            },
            [](const RuleVertex& at, Vec3d& normal) {
                normal = face_normal_at(at.level.step.mesh, at.level.points, at.v);
            });
    }

    void frames_of_cells(std::span<const Site> sites, std::span<LimitPoint> out) const {
        std::vector<Vec3d> normal(sites.size(), Vec3d(0)), towards(sites.size());
        for_each_face_of_cells(sites, [&](std::size_t i, std::span<const Vec3d> face) {
            for (std::size_t k = 1; k + 1 < face.size(); ++k)
                normal[i] += glm::cross(face[k] - face[0], face[k + 1] - face[0]);
            towards[i] = face[1] - face[0];
        });
        std::vector<Vec3d> points(sites.size());
        points_of(sites, k_own_level, points);
        for (std::size_t i = 0; i < sites.size(); ++i) out[i] = frame_from(points[i], normal[i], towards[i]);
    }

    /// Calls visit(number of a site, points of a face around it that begin with the site's).
    template <class Visit>
    void for_each_face_of_cells(std::span<const Site> sites, const Visit& visit) const {
        std::vector<Site> corners;
        std::vector<std::pair<std::size_t, std::size_t>> faces;  ///< site, first of the corners
        for (std::size_t i = 0; i < sites.size(); ++i)
            for (const VertexCell& side : roots_.sides(site_cell(sites[i])))
                for (int corner = 0; corner < 4; ++corner) {
                    const VertexRoots::Fan fan = roots_.fan({side, corner});
                    if (!fan.is_face()) continue;
                    faces.emplace_back(i, corners.size());
                    for (const VertexRoots::Corner& c : fan.corners) corners.push_back(cell_site(c.cell));
                }
        std::vector<Vec3d> points(corners.size());
        points_of(corners, k_own_level, points);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const std::size_t begin = faces[f].second, end = f + 1 < faces.size() ? faces[f + 1].second : corners.size();
            visit(faces[f].first, std::span<const Vec3d>(points).subspan(begin, end - begin));
        }
    }

    /// Where a site is in the lattices, at the level that its result has rows of.
    struct Address {
        int level = -1;  ///< of the scheme; -1: it has none
        std::uint32_t halfedge = 0, x = 0, y = 0;
    };
    Address address(const Rows& rows, const Site& any, Wanted wanted, int level) const {
        const Site site = own_site(any);
        Address at;
        at.halfedge = rows.root_halfedge[site.root.value];
        if (at.halfedge == MeshLevel::none) return {};
        const int own = site.level + offset();
        if (level == k_own_level) level = own;
        if (wanted == Wanted::limits || wanted == Wanted::normals) {
            if (!rows.all->has_limit() || (wanted == Wanted::normals && !rows.all->has_normals())) return {};
            // The vertices of a dual scheme are those of one level.
            if (!dual()) level = std::max(level, rows.limit_level);
            if (level < rows.limit_level) return {};
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
            missing[i] = at.level < 0 ? 1 : 0;
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
            if (wanted == Wanted::rings) sums.value.resize(sums.last_row + 1);
            finish(std::as_const(sums), out[i]);
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

    bool whole_levels_;
    const ControlMesh& mesh_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    mutable WholeLevels by_rules_;
    VertexRoots roots_;
    bool triangles_;
    std::uint64_t max_memory_bytes_;
    std::uint64_t most_by_rules_ = k_most_by_rules, most_whole_ = k_most_whole;
    mutable std::mutex mutex_;
    mutable bool tried_ = false;
    mutable std::unique_ptr<Rows> rows_;
    mutable oneapi::tbb::enumerable_thread_specific<Workspace> workspaces_{};  ///< what blocks have grown
};

}  // namespace

std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, const VertexRoots* roots,
                                              const RunContext& context, bool whole_levels) {
    return std::make_shared<RowPoints>(mesh, scheme, rules, roots, context, whole_levels);
}

}  // namespace tetrakis::detail
