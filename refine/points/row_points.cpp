#include "row_points.hpp"

#include "../../hier/base/error.hpp"
#include "../rules/face_normals.hpp"
#include "site_rows.hpp"
#include "whole_levels.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

using Sums = SiteRows::Sums;
using Wanted = SiteRows::Wanted;
constexpr int k_own_level = SiteRows::k_own_level;

class RowPoints final : public LevelSource {
  public:
    RowPoints(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const VertexRoots* roots,
              const RunContext& context, bool whole_levels, std::shared_ptr<const PositionSource> limit_positions)
        : roots_(roots != nullptr ? *roots : VertexRoots()),
          linear_(scheme.is_linear()),
          triangles_(scheme.family == MeshFamily::triangles),
          rows_(mesh, scheme, rules, roots_, context, whole_levels),
          by_rules_(mesh, scheme, rules, roots_, context),
          limit_positions_(std::move(limit_positions)) {}

    int first_level(const Site& site) const override {
        const Site minimal = rows_.own_site(site);
        // A quad scheme has its control vertices on level 0, one level before the lattices begin.
        const bool control = !dual() && !triangles_ && minimal.level == 0 && minimal.at == LatticePoint{0, 0};
        return control ? 0 : rows_.own_level(site);
    }
    int max_level() const override { return k_max_level + rows_.offset(); }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        check_level(sites, level);
        points_of(sites, level, out);
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        check_level(sites, level);
        std::vector<Vec3d> normals(sites.size(), Vec3d(0)), towards = normals, points = normals;
        for_each_face(sites, level, [&](std::size_t i, std::span<const Vec3d> face) {
            points[i] = face[0];
            if (towards[i] == Vec3d(0)) towards[i] = face[1] - face[0];
            for (std::size_t k = 1; k + 1 < face.size(); ++k)
                normals[i] += glm::cross(face[k] - face[0], face[k + 1] - face[0]);
        });
        for (std::size_t i = 0; i < sites.size(); ++i) out[i] = frame_from(points[i], normals[i], towards[i]);
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        limit_positions_ ? limit_positions_->positions(sites, out) : own_limit_positions(sites, out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        find_planes(sites, out);
        std::vector<Vec3d> points(sites.size());
        own_limit_positions(sites, points);
        for (std::size_t i = 0; i < points.size(); ++i) out[i].position = points[i];
    }
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const override {
        std::vector<LimitPoint> planes(sites.size());
        find_planes(sites, planes);
        for (std::size_t i = 0; i < planes.size(); ++i) out[i] = planes[i].normal;
    }

  private:
    bool dual() const { return roots_.count() != 0; }
    void check_level(std::span<const Site> sites, int level) const {
        for (const Site& site : sites)
            if (dual() && site.level + 1 != level)
                throw Error(ErrorCode::unsupported, "a dual scheme has other vertices on every level: one of level " +
                                                        std::to_string(site.level + 1) + " is none of level " +
                                                        std::to_string(level));
    }

    void own_limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const {
        evaluate(
            sites, Wanted::limits, k_own_level, out, [](const Sums& sums, Vec3d& point) { point = sums.value[0]; },
            [&](const WholeLevels::Level& made, std::size_t v, Vec3d& point) { point = made.limits[v].position; });
    }
    void points_of(std::span<const Site> sites, int level, std::span<Vec3d> out) const {
        evaluate(
            sites, Wanted::positions, level, out, [](const Sums& sums, Vec3d& point) { point = sums.value[0]; },
            [](const WholeLevels::Level& made, std::size_t v, Vec3d& point) { point = made.points[v]; });
    }

    /// @param finish   (sums of rows, result): for sites that have rows
    /// @param by_rule  (whole level, its vertex, result): for the other sites
    template <class Result, class Finish, class ByRule>
    void evaluate(std::span<const Site> sites, Wanted wanted, int level, std::span<Result> out, const Finish& finish,
                  const ByRule& by_rule) const {
        const std::vector<std::size_t> others =
            rows_.evaluate(sites, wanted, level, [&](std::size_t i, const Sums& sums) { finish(sums, out[i]); });
        // Level by level, so that the limits of a level are found together.
        std::array<std::vector<std::size_t>, k_max_level + 2> by_level;
        for (const std::size_t i : others)
            by_level[static_cast<std::size_t>(level != k_own_level ? level : rows_.own_level(sites[i]))].push_back(i);
        std::vector<int> vertices;
        for (int l = 0; l < static_cast<int>(by_level.size()); ++l) {
            const std::vector<std::size_t>& here = by_level[static_cast<std::size_t>(l)];
            if (here.empty()) continue;
            const WholeLevels::Level& made = by_rules_.level(l);
            vertices.clear();
            for (const std::size_t i : here) vertices.push_back(by_rules_.vertex(sites[i], l));
            if (wanted == Wanted::limits || wanted == Wanted::normals) by_rules_.find_limits(l, vertices);
            for (std::size_t k = 0; k < here.size(); ++k)
                by_rule(made, static_cast<std::size_t>(vertices[k]), out[here[k]]);
        }
    }

    /// Finds tangents and normals.
    void find_planes(std::span<const Site> sites, std::span<LimitPoint> out) const {
        // On a crease of a dual scheme, each side has separate rows.
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
        if (!linear_)
            evaluate(
                std::span<const Site>(sides), Wanted::normals, k_own_level, std::span(found),
                [](const Sums& sums, LimitPoint& point) {
                    point.normal = RowPatterns::normal_of(sums.value.data());
                    point.tangent1 = sums.value[0];
                    point.tangent2 = sums.value[1];
                    point.has_tangent_plane = sums.last_row < 2 && point.normal != Vec3d(0);
                },
                [&](const WholeLevels::Level& made, std::size_t v, LimitPoint& point) { point = made.limits[v]; });
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

    /// Normals from the faces around the sites (FaceNormals), on the first level on which each site is a vertex.
    void face_normals(std::span<const Site> sites, std::span<Vec3d> out) const {
        std::vector<FaceNormals> sums(sites.size());
        for_each_face(sites, k_own_level, [&](std::size_t i, std::span<const Vec3d> face) { sums[i].add(face, 0); });
        for (std::size_t i = 0; i < sites.size(); ++i) out[i] = sums[i].normal();
    }

    /// Calls visit(number of a site, points of a face) for all faces around each site; the site's point comes first.
    /// The calls for one site come one after the other; those for different sites may come from different threads.
    template <class Visit>
    void for_each_face(std::span<const Site> sites, int level, const Visit& visit) const {
        if (dual()) return for_each_face_of_cells(sites, visit);
        std::vector<std::size_t> numbers(sites.size());
        std::iota(numbers.begin(), numbers.end(), std::size_t{0});
        evaluate(
            sites, Wanted::rings, level, std::span(numbers),
            [&](const Sums& sums, std::size_t i) {
                const std::vector<Vec3d>& p = sums.value;
                for (std::size_t k = 1; !triangles_ && k + 2 < p.size(); k += 2)
                    visit(i, std::array{p[0], p[k], p[k + 1], p[k + 2]});
                for (std::size_t k = 1; triangles_ && k + 1 < p.size(); ++k) visit(i, std::array{p[0], p[k], p[k + 1]});
            },
            [&](const WholeLevels::Level& made, std::size_t v, std::size_t i) {
                const RuleMesh& mesh = made.step.mesh;
                std::vector<Vec3d> face;
                for (const int first : mesh.ring(static_cast<int>(v)).halfedge) {
                    face.clear();
                    for (int h = first; face.empty() || h != first; h = mesh.next(h))
                        face.push_back(made.points[static_cast<std::size_t>(mesh.origin(h))]);
                    visit(i, face);
                }
            });
    }

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
            const std::size_t begin = faces[f].second,
                              end = f + 1 < faces.size() ? faces[f + 1].second : corners.size();
            visit(faces[f].first, std::span<const Vec3d>(points).subspan(begin, end - begin));
        }
    }

    VertexRoots roots_;
    bool linear_, triangles_;
    SiteRows rows_;
    mutable WholeLevels by_rules_;
    std::shared_ptr<const PositionSource> limit_positions_;
};

}  // namespace

LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards) {
    LimitPoint result;
    result.position = position;
    const double length = glm::length(area_normal);
    if (!(length > 0)) return result;
    result.normal = area_normal / length;
    result.tangent1 = towards - glm::dot(towards, result.normal) * result.normal;
    constexpr double k_along = 1e-12;  // relative length left by rounding if `towards` is parallel to the normal
    if (!(glm::length(result.tangent1) > k_along * glm::length(towards))) {
        const Vec3d across = std::abs(result.normal.x) < 0.9 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
        result.tangent1 = glm::cross(across, result.normal);
    }
    result.tangent2 = glm::cross(result.normal, result.tangent1);
    result.has_tangent_plane = true;
    return result;
}

std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, const VertexRoots* roots,
                                              const RunContext& context, bool whole_levels,
                                              std::shared_ptr<const PositionSource> limit_positions) {
    return std::make_shared<RowPoints>(mesh, scheme, rules, roots, context, whole_levels, std::move(limit_positions));
}

}  // namespace tetrakis::detail
