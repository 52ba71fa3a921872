#include "../kit/hierarchy_helpers.hpp"
#include "../kit/point_match.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/forest/triangle_cell.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <string>

// Adaptive is uniform, site by site: which vertex of the uniform levels a site is, is found without the library's
// addresses. Schemes that split faces number the vertices of a level alike, so the site's parameters, put on a control
// mesh of random points bilinearly (or linearly), name the vertex by its place on the same level of that mesh.

using namespace tetrakis;
using test::Random;

namespace {

struct SiteChoice {
    std::string_view scheme;
    RuleOptions rules{};
};

RuleOptions averaging_steps(int m) {
    RuleOptions rules;
    rules.averaging_steps = m;
    return rules;
}
RuleOptions cosine() {
    RuleOptions rules;
    rules.edge_beside_crease = EdgeBesideCrease::cosine;
    return rules;
}

/// Every scheme whose vertices are sites of corner cells or triangles.
std::vector<SiteChoice> primal_choices() {
    return {{"catmull-clark"},
            {"catmull-clark", cosine()},
            {"bilinear"},
            {"kobbelt"},
            {"4-8"},
            {"averaging", averaging_steps(0)},
            {"averaging", averaging_steps(2)},
            {"averaging", averaging_steps(4)},
            {"loop"},
            {"loop", cosine()},
            {"tuned-loop"},
            {"butterfly"},
            {"modified-butterfly"},
            {"midpoint"}};
}

/// Sums of weights of control points, equal where two vertices of a level are the same, and far apart otherwise.
class Places {
  public:
    Places(const ControlMesh& mesh, bool triangles, std::uint64_t seed) : mesh_(&mesh), triangles_(triangles) {
        Random random(seed + 500);
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            control_.emplace_back(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    }

    /// Where a site is, from what its coordinates mean.
    Vec3d of(const Site& site) const {
        const double n = std::ldexp(1.0, site.level), x = site.at.x / n, y = site.at.y / n;
        const HalfedgeId h = site.root;
        const Vec3d v = at(h), w = at(mesh_->next(h)), u = at(mesh_->prev(h));
        if (triangles_) return v + x * (w - v) + y * (u - v);
        const FaceId f = mesh_->face(h);
        Vec3d centre(0);
        HalfedgeId corner = mesh_->face_halfedge(f);
        for (std::uint32_t i = 0; i < mesh_->face_size(f); ++i, corner = mesh_->next(corner)) centre += at(corner);
        centre /= static_cast<double>(mesh_->face_size(f));
        return (1 - x) * (1 - y) * v + x * (1 - y) * 0.5 * (v + w) + x * y * centre + (1 - x) * y * 0.5 * (v + u);
    }

    /// Numbers the vertices of a level by their places on it.
    void number(int level) {
        const RuleRefiner refiner(*mesh_, *find_scheme(triangles_ ? "midpoint" : "bilinear"), level);
        std::vector<Vec3d> points(refiner.vertex_count());
        refiner.refine(control_, points);
        vertices_.clear();
        for (std::uint32_t v = 0; v < points.size(); ++v) vertices_.insert({points[v].x, {points[v], v}});
        corners_ = corners_of(refiner.last());
    }
    /// Whether another scheme's level has the vertices of the same numbers in its faces.
    bool same_numbers(const RuleRefiner& refiner) const {
        return refiner.vertex_count() == vertices_.size() && corners_of(refiner.last()) == corners_;
    }
    /// The vertex of the level that is at the place; none if there is no such, or more than one.
    std::optional<std::uint32_t> find(const Vec3d& place) const {
        constexpr double k_same = 1e-13;  // other sums of the same weights
        std::optional<std::uint32_t> found;
        for (auto at = vertices_.lower_bound(place.x - k_same); at != vertices_.end() && at->first <= place.x + k_same;
             ++at) {
            if (!(glm::length(at->second.first - place) <= k_same)) continue;
            if (found) return std::nullopt;
            found = at->second.second;
        }
        return found;
    }

  private:
    Vec3d at(HalfedgeId h) const { return control_[mesh_->origin(h).value]; }
    static std::vector<int> corners_of(const RuleMesh& mesh) {
        std::vector<int> result;
        for (int f = 0; f < mesh.face_count(); ++f) {
            for (const int v : mesh.corners(f)) result.push_back(v);
            result.push_back(-1);
        }
        return result;
    }

    const ControlMesh* mesh_;
    bool triangles_;
    std::vector<Vec3d> control_;
    std::multimap<double, std::pair<Vec3d, std::uint32_t>> vertices_;
    std::vector<int> corners_;
};

/// These, and the one that the tests' seeds are extended by.
std::vector<std::uint64_t> these_seeds(std::initializer_list<std::uint64_t> chosen) {
    std::vector<std::uint64_t> seeds = test::seeds(0);
    seeds.insert(seeds.begin(), chosen);
    return seeds;
}

ControlMesh site_mesh(const SiteChoice& choice, std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    // Where the faces at the boundary are left out, others are to remain.
    options.columns = options.rows = options.boundary_rule == BoundaryRule::none ? 4 : 3;
    options.triangles_only = find_scheme(choice.scheme)->family == MeshFamily::triangles;
    return test::random_mesh(seed, options);
}

/// Sites of all vertices of a level of the scheme, with all their addresses.
std::vector<Site> sites_of_level(const ControlMesh& mesh, bool triangles, int level) {
    const int lattice = triangles ? level : level - 1;
    const std::uint32_t n = 1u << lattice;
    std::vector<Site> sites;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        if (triangles && mesh.face_halfedge(mesh.face(HalfedgeId(h))).value != h) continue;
        for (std::uint32_t y = 0; y <= n; ++y)
            for (std::uint32_t x = 0; x <= (triangles ? n - y : n); ++x)
                sites.push_back({HalfedgeId(h), {x, y}, static_cast<std::uint8_t>(lattice)});
    }
    return sites;
}

/// A uniform level by the scheme's own rules on the whole of it: its net, and the limits of its vertices.
struct Level {
    std::vector<Vec3d> points, limits;

    Level(const ControlMesh& mesh, const SiteChoice& choice, int level, const Places& places) {
        RefineOptions options;
        options.rules = choice.rules;
        const RuleRefiner net(mesh, *find_scheme(choice.scheme), level, options);
        options.limit = true;
        const RuleRefiner surface(mesh, *find_scheme(choice.scheme), level, options);
        REQUIRE(places.same_numbers(net));
        points.resize(net.vertex_count());
        limits.resize(net.vertex_count());
        net.refine(mesh.positions(), points);
        surface.refine(mesh.positions(), limits);
    }
};

/// Long averages take long.
int levels_for(const SiteChoice& choice) {
    return choice.scheme == "averaging" && choice.rules.averaging_steps > 2 ? 2 : 3;
}

Hierarchy hierarchy_for(const ControlMesh& mesh, const SiteChoice& choice) {
    HierarchyOptions options;
    options.rules = choice.rules;
    return make_hierarchy(mesh, choice.scheme, options);
}

/// Of each vertex of a hierarchy's mesh the finest level of a leaf around it.
std::vector<int> finest_levels(const Hierarchy& h, const HierarchyMesh& out) {
    std::vector<int> levels(out.sites.size(), 0);
    for (std::uint32_t f = 0; f < out.mesh.face_count(); ++f)
        for (std::uint32_t c = out.mesh.face_offsets[f]; c < out.mesh.face_offsets[f + 1]; ++c) {
            int& level = levels[out.mesh.face_vertices[c]];
            level = std::max<int>(level, h.view(out.leaves[f]).level);
        }
    return levels;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] primal schemes: each vertex of an adaptive mesh is where uniform refinement has its site") {
    for (const SiteChoice& choice : primal_choices())
        for (const std::uint64_t seed : these_seeds({2, 3, 4, 7})) {  // plane, tori, sphere; each boundary rule
            CAPTURE(choice.scheme);
            CAPTURE(seed);
            const int levels = levels_for(choice);
            const ControlMesh mesh = site_mesh(choice, seed);
            Hierarchy h = hierarchy_for(mesh, choice);
            Random random(seed);
            for (int pass = 0; pass < 3; ++pass) {
                auto some = test::random_subset(test::leaves_of(h), 0.3, random);
                std::erase_if(some, [&](LeafHandle leaf) { return h.view(leaf).level >= levels; });
                h.refine(some);
            }
            const HierarchyMesh limits = h.to_mesh(), finest = h.to_mesh({.positions = MeshPositions::finest});
            const std::vector<int> finest_level = finest_levels(h, limits);
            const double tolerance = 1e-12 * mesh.bounding_box().diagonal();
            Places places(mesh, h.family() == "triangles", seed);
            std::size_t compared = 0;
            for (int level = 1; level <= levels; ++level) {
                CAPTURE(level);
                places.number(level);
                const Level uniform(mesh, choice, level, places);
                const HierarchyMesh out = h.to_mesh({.positions = MeshPositions::level, .level = level});
                REQUIRE(out.sites == limits.sites);
                for (std::size_t v = 0; v < limits.sites.size(); ++v) {
                    if (h.first_level(limits.sites[v]) > level) continue;
                    const auto vertex = places.find(places.of(limits.sites[v]));
                    REQUIRE(vertex.has_value());
                    REQUIRE(glm::length(out.mesh.positions[v] - uniform.points[*vertex]) <= tolerance);
                    REQUIRE(glm::length(limits.mesh.positions[v] - uniform.limits[*vertex]) <= tolerance);
                    if (finest_level[v] != level) continue;
                    ++compared;
                    REQUIRE(glm::length(finest.mesh.positions[v] - uniform.points[*vertex]) <= tolerance);
                }
            }
            CHECK(2 * compared > limits.sites.size());
        }
}

TEST_CASE("[inv1] [slow] primal schemes: any site has its uniform position at any level, and its limit") {
    for (const SiteChoice& choice : primal_choices())
        for (const std::uint64_t seed : these_seeds({4, 7})) {
            CAPTURE(choice.scheme);
            CAPTURE(seed);
            const int levels = levels_for(choice);
            const ControlMesh mesh = site_mesh(choice, seed);
            const Hierarchy h = hierarchy_for(mesh, choice);  // its roots' corners alone are vertices
            const bool triangles = h.family() == "triangles";
            const double tolerance = 1e-12 * mesh.bounding_box().diagonal();
            Places places(mesh, triangles, seed);
            for (int level = 1; level <= levels; ++level) {
                CAPTURE(level);
                places.number(level);
                const Level uniform(mesh, choice, level, places);
                const std::vector<Site> sites = sites_of_level(mesh, triangles, level);
                std::vector<Vec3d> points(sites.size()), limits(sites.size());
                h.positions(sites, level, points);
                h.limit_positions(sites, limits);
                std::vector<std::uint8_t> seen(uniform.points.size(), 0);
                double off = 0, off_limit = 0;
                for (std::size_t i = 0; i < sites.size(); ++i) {
                    const auto vertex = places.find(places.of(sites[i]));
                    REQUIRE(vertex.has_value());
                    seen[*vertex] = 1;
                    off = std::max(off, glm::length(points[i] - uniform.points[*vertex]));
                    off_limit = std::max(off_limit, glm::length(limits[i] - uniform.limits[*vertex]));
                }
                CHECK(std::count(seen.begin(), seen.end(), 0) == 0);
                CHECK(off <= tolerance);
                CHECK(off_limit <= tolerance);
            }
        }
}

namespace {

/// A uniform level of refine() with limits, and of its vertices which are where.
class UniformMesh {
  public:
    UniformMesh(const ControlMesh& mesh, const SiteChoice& choice, int level, double tolerance) {
        RefineOptions options;
        options.rules = choice.rules;
        net = refine(mesh, choice.scheme, level, options);
        options.limit = true;
        try {
            const PolygonMesh surface = refine(mesh, choice.scheme, level, options);
            REQUIRE(surface.face_vertices == net.face_vertices);
            limits = surface.positions;
        } catch (const Error& e) {
            REQUIRE(e.code() == ErrorCode::unsupported);  // a vertex that the scheme has no limit mask for
        }
        match_.emplace(net.positions);
        // Where points coincide, in which of the vertices a site lies cannot be seen from its place.
        first_.resize(net.positions.size());
        shared_.assign(net.positions.size(), 0);
        std::vector<std::uint32_t> order(net.positions.size());
        std::iota(first_.begin(), first_.end(), 0u);
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(),
                         [&](auto a, auto b) { return net.positions[a].x < net.positions[b].x; });
        for (std::size_t i = 0; i < order.size(); ++i)
            for (std::size_t j = i + 1; j < order.size(); ++j) {
                const std::uint32_t a = order[i], b = order[j];
                if (net.positions[b].x - net.positions[a].x > tolerance) break;
                if (glm::length(net.positions[b] - net.positions[a]) > tolerance) continue;
                first_[a] = first_[b] = std::min(first_[a], first_[b]);
                shared_[a] = shared_[b] = 1;
            }
    }
    /// Which vertex each of a uniform hierarchy's sites is. The hierarchy's faces, which come from its own structure,
    /// must be the level's faces in these vertices: so all of them are where their neighbours say.
    std::map<Site, std::uint32_t> numbers(const HierarchyMesh& all, double tolerance) const {
        REQUIRE(all.mesh.positions.size() == net.positions.size());
        std::vector<std::uint32_t> number;
        for (const Vec3d& p : all.mesh.positions) {
            number.push_back(first_[match_->nearest(p)]);
            REQUIRE(glm::length(net.positions[number.back()] - p) <= tolerance);
        }
        const auto cycles = [](const PolygonMesh& mesh, const std::vector<std::uint32_t>& renumber) {
            std::multiset<std::vector<std::uint32_t>> result;
            for (auto face : test::faces_of(mesh)) {
                for (std::uint32_t& v : face) v = renumber[v];
                auto least = face;  // a place may be there twice
                for (std::size_t i = 1; i < face.size(); ++i) {
                    std::rotate(face.begin(), face.begin() + 1, face.end());
                    least = std::min(least, face);
                }
                result.insert(std::move(least));
            }
            return result;
        };
        CHECK(cycles(all.mesh, number) == cycles(net, first_));
        std::map<Site, std::uint32_t> result;
        for (std::size_t v = 0; v < number.size(); ++v) result[all.sites[v]] = number[v];
        std::set<std::uint32_t> taken;
        std::size_t shared = 0;
        for (const std::uint32_t v : number) {
            const bool fresh = taken.insert(v).second;
            CHECK((fresh || is_shared(v)));
            shared += is_shared(v) ? 1 : 0;
        }
        CHECK(4 * shared <= number.size());
        return result;
    }

    bool is_shared(std::uint32_t v) const { return shared_[v] != 0; }

    PolygonMesh net;
    std::vector<Vec3d> limits;  // empty: the scheme has not all of them

  private:
    std::optional<PointMatch> match_;
    std::vector<std::uint32_t> first_;  // of the vertices at one place
    std::vector<std::uint8_t> shared_;
};

/// None where the scheme has no limit mask for one of the vertices.
std::optional<HierarchyMesh> limits_of(const Hierarchy& h) {
    try {
        return h.to_mesh();
    } catch (const Error& e) {
        REQUIRE(e.code() == ErrorCode::unsupported);
        return std::nullopt;
    }
}

LeafPredicate everything() {
    return each_leaf([](const LeafView&) { return true; });
}

}  // namespace

namespace {

/// Seeds have no tags, infinitely sharp ones and semi-sharp ones in turn.
void check_dual_sites(const SiteChoice& choice, std::uint64_t seed_count, int levels) {
    std::size_t with_limits = 0;
    std::set<int> levels_seen;
    for (const std::uint64_t seed : test::seeds(seed_count)) {
        CAPTURE(choice.scheme);
        CAPTURE(seed);
        test::RandomMeshOptions options = test::random_options(seed);
        options.columns = options.rows = options.boundary_rule == BoundaryRule::none ? 4 : 3;
        options.crease = seed % 3 == 0 ? 0 : 0.2;
        options.corner = seed % 3 == 0 ? 0 : 0.1;
        const ControlMesh mesh = test::random_dual_mesh(
            seed, options, seed % 3 == 2 ? test::DualTags::of_all_kinds : test::DualTags::infinitely_sharp);
        const double tolerance = 1e-12 * mesh.bounding_box().diagonal();
        Hierarchy h = hierarchy_for(mesh, choice), all = hierarchy_for(mesh, choice);
        const Hierarchy roots = hierarchy_for(mesh, choice);
        Random random(seed);
        for (int pass = 0; pass < 2; ++pass) {
            auto some = test::random_subset(test::leaves_of(h), 0.15, random);
            std::erase_if(some, [&](LeafHandle leaf) { return h.view(leaf).level >= levels; });
            h.refine(some);
        }
        const HierarchyMesh finest = h.to_mesh({.positions = MeshPositions::finest});
        std::optional<HierarchyMesh> limits;
        std::size_t compared = 0;
        for (int level = 1; level <= levels; ++level) {
            CAPTURE(level);
            all.refine_where(everything(), level - 1);
            const HierarchyMesh whole = all.to_mesh({.positions = MeshPositions::level, .level = level});
            const UniformMesh uniform(mesh, choice, level, tolerance);
            const auto numbers = uniform.numbers(whole, tolerance);
            if (!uniform.limits.empty() && !limits) limits = limits_of(h);
            std::size_t here = 0;
            for (std::size_t v = 0; v < finest.sites.size(); ++v) {
                if (h.first_level(finest.sites[v]) != level) continue;
                const auto number = numbers.find(finest.sites[v]);
                REQUIRE(number != numbers.end());
                ++here;
                REQUIRE(glm::length(finest.mesh.positions[v] - uniform.net.positions[number->second]) <= tolerance);
                if (uniform.limits.empty() || !limits || uniform.is_shared(number->second)) continue;
                ++with_limits;
                REQUIRE(glm::length(limits->mesh.positions[v] - uniform.limits[number->second]) <= tolerance);
            }
            compared += here;
            if (here > 0) levels_seen.insert(level);
            // Any site of the level, whether it is a leaf or not.
            std::vector<Vec3d> points(whole.sites.size());
            roots.positions(whole.sites, level, points);
            double off = 0;
            for (std::size_t i = 0; i < points.size(); ++i)
                off = std::max(off, glm::length(points[i] - uniform.net.positions[numbers.at(whole.sites[i])]));
            CHECK(off <= tolerance);
            if (uniform.limits.empty()) continue;
            roots.limit_positions(whole.sites, points);
            for (std::size_t i = 0; i < points.size(); ++i)
                if (const std::uint32_t v = numbers.at(whole.sites[i]); !uniform.is_shared(v))
                    off = std::max(off, glm::length(points[i] - uniform.limits[v]));
            CHECK(off <= tolerance);
        }
        CHECK(compared == finest.sites.size());
    }
    CHECK(with_limits > 0);
    CHECK(levels_seen.size() == static_cast<std::size_t>(levels));
}

}  // namespace

TEST_CASE(
    "[inv1] [slow] dual schemes: each vertex of an adaptive mesh is where uniform refinement has its site, limits "
    "too") {
    check_dual_sites({"doo-sabin"}, 12, 3);
    for (const std::string_view scheme : {"doo-sabin-cc", "midedge", "midedge-simplest"})
        check_dual_sites({scheme}, 6, 3);
}

TEST_CASE(
    "[slow] [inv1] averages: each vertex of an adaptive mesh is where uniform refinement has its site, limits too") {
    check_dual_sites({"biquartic"}, 3, 2);
    check_dual_sites({"averaging", averaging_steps(1)}, 6, 2);
    check_dual_sites({"averaging", averaging_steps(5)}, 1, 2);
}

TEST_CASE("[inv1] sqrt3: each vertex of an adaptive mesh is where uniform refinement has its site, limits too") {
    constexpr int k_steps = 4;  // two of which are a level of refine()
    for (const std::uint64_t seed : test::seeds(10)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_sqrt3_mesh(seed);
        const double tolerance = 1e-12 * mesh.bounding_box().diagonal();
        const SiteChoice choice{"sqrt3"};
        Hierarchy h = hierarchy_for(mesh, choice), all = hierarchy_for(mesh, choice);
        const Hierarchy roots = hierarchy_for(mesh, choice);
        Random random(seed);
        for (int pass = 0; pass < 4; ++pass) {
            auto some = test::random_subset(test::leaves_of(h), 0.2, random);
            std::erase_if(some, [&](LeafHandle leaf) { return h.node(leaf).depth >= 2 * k_steps - 1; });
            h.refine(some);
        }
        const HierarchyMesh limits = h.to_mesh(), finest = h.to_mesh({.positions = MeshPositions::finest});
        const std::vector<int> finest_level = finest_levels(h, limits);
        std::size_t compared = 0, compared_finest = 0;
        for (int step = 2; step <= k_steps; step += 2) {
            CAPTURE(step);
            all.refine_where(everything(), 2 * step);
            const HierarchyMesh whole = all.to_mesh({.positions = MeshPositions::level, .level = step});
            const UniformMesh uniform(mesh, choice, step / 2, tolerance);
            REQUIRE(!uniform.limits.empty());
            const auto numbers = uniform.numbers(whole, tolerance);
            const HierarchyMesh out = h.to_mesh({.positions = MeshPositions::level, .level = step});
            for (std::size_t v = 0; v < limits.sites.size(); ++v) {
                if (h.first_level(limits.sites[v]) > step) continue;
                const auto number = numbers.find(limits.sites[v]);
                REQUIRE(number != numbers.end());
                ++compared;
                REQUIRE(glm::length(out.mesh.positions[v] - uniform.net.positions[number->second]) <= tolerance);
                REQUIRE(glm::length(limits.mesh.positions[v] - uniform.limits[number->second]) <= tolerance);
                if (finest_level[v] != step) continue;
                ++compared_finest;
                REQUIRE(glm::length(finest.mesh.positions[v] - uniform.net.positions[number->second]) <= tolerance);
            }
            std::vector<Vec3d> points(whole.sites.size()), on_limit(whole.sites.size());
            roots.positions(whole.sites, step, points);
            roots.limit_positions(whole.sites, on_limit);
            double off = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                const std::uint32_t number = numbers.at(whole.sites[i]);
                off = std::max({off, glm::length(points[i] - uniform.net.positions[number]),
                                glm::length(on_limit[i] - uniform.limits[number])});
            }
            CHECK(off <= tolerance);
        }
        CHECK(compared >= limits.sites.size());
        CHECK(compared_finest > 0);
    }
}

TEST_CASE("[inv1] sqrt3: each step, odd ones as well, is Kobbelt's on the step before, site by site") {
    for (const test::Topology topology : {test::Topology::torus, test::Topology::sphere}) {
        CAPTURE(static_cast<int>(topology));
        test::RandomMeshOptions options;
        options.topology = topology;
        options.columns = options.rows = 4;
        options.triangles_only = true;
        options.removed_faces = 0;
        options.hole = options.crease = options.corner = 0;
        const ControlMesh mesh = test::random_mesh(11, options);
        const double tolerance = 1e-12 * mesh.bounding_box().diagonal();
        Hierarchy all = make_hierarchy(mesh, "sqrt3");
        const Hierarchy roots = make_hierarchy(mesh, "sqrt3");
        HierarchyMesh before = all.to_mesh({.positions = MeshPositions::level, .level = 0});
        for (int step = 1; step <= 4; ++step) {
            CAPTURE(step);
            all.refine_where(everything(), 2 * step);
            const HierarchyMesh now = all.to_mesh({.positions = MeshPositions::level, .level = step});
            REQUIRE(now.mesh.face_count() == 3 * before.mesh.face_count());
            std::map<Site, std::uint32_t> old;
            for (std::uint32_t v = 0; v < before.sites.size(); ++v) old[before.sites[v]] = v;
            // The neighbours of each old vertex before, and the old ones around each new vertex: its triangle's
            // corners.
            std::vector<std::set<std::uint32_t>> around(before.sites.size()), corners(now.sites.size());
            std::set<std::set<std::uint32_t>> triangles, centred;
            for (const auto& t : test::faces_of(before.mesh)) {
                triangles.insert({t.begin(), t.end()});
                for (const std::uint32_t a : t)
                    for (const std::uint32_t b : t)
                        if (a != b) around[a].insert(b);
            }
            for (const auto& t : test::faces_of(now.mesh))
                for (const std::uint32_t a : t)
                    for (const std::uint32_t b : t)
                        if (const auto at = old.find(now.sites[b]); at != old.end()) corners[a].insert(at->second);
            std::vector<Vec3d> points(now.sites.size());
            roots.positions(now.sites, step, points);
            for (std::size_t v = 0; v < now.sites.size(); ++v) {
                Vec3d expected(0);
                if (const auto at = old.find(now.sites[v]); at != old.end()) {
                    const std::set<std::uint32_t>& ring = around[at->second];
                    const double n = static_cast<double>(ring.size());
                    const double alpha = (4 - 2 * std::cos(2 * std::numbers::pi / n)) / 9;  // Kobbelt 2000
                    for (const std::uint32_t w : ring) expected += alpha / n * before.mesh.positions[w];
                    expected += (1 - alpha) * before.mesh.positions[at->second];
                } else {
                    centred.insert(corners[v]);
                    for (const std::uint32_t w : corners[v]) expected += before.mesh.positions[w] / 3.0;
                }
                REQUIRE(glm::length(now.mesh.positions[v] - expected) <= tolerance);
                REQUIRE(glm::length(points[v] - expected) <= tolerance);
            }
            CHECK(centred == triangles);
            before = now;
        }
    }
}

TEST_SUITE_END();
