#include "../kit/corner_angle_mesh.hpp"
#include "../kit/hierarchy_helpers.hpp"
#include "../kit/nearest.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

// Adaptive is uniform, site by site. Which vertex of a uniform level a site is, is known from a hierarchy refined
// everywhere: its triangles lie in the level's faces.

using namespace tetrakis;
using test::everything;
using test::Random;

namespace {

struct SiteChoice {
    std::string_view scheme;
    RuleOptions rules{};
};

/// A uniform level of refine() with limits, and of its vertices which are where.
class UniformMesh {
  public:
    UniformMesh(const ControlMesh& mesh, const SiteChoice& choice, int level, double tolerance, bool with_normals) {
        RefineOptions options;
        options.rules = choice.rules;
        net = refine(mesh, choice.scheme, level, options);
        options.limit = true;
        options.normals = with_normals;
        try {
            const PolygonMesh surface = refine(mesh, choice.scheme, level, options);
            REQUIRE(surface.face_vertices == net.face_vertices);
            limits = surface.positions;
            normals = surface.normals;
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
    /// Which vertex each of a uniform hierarchy's sites is. The hierarchy's triangles, which come from its own
    /// structure, must be cut from the level's faces: so all of them are where their neighbours say.
    std::map<Site, std::uint32_t> numbers(const HierarchyMesh& all, double tolerance) const {
        REQUIRE(all.mesh.positions.size() == net.positions.size());
        std::vector<std::uint32_t> number;
        for (const Vec3d& p : all.mesh.positions) {
            number.push_back(first_[match_->nearest(p)]);
            REQUIRE(glm::length(net.positions[number.back()] - p) <= tolerance);
        }
        std::set<std::array<std::uint32_t, 3>> triangles;
        std::size_t expected = 0, strange = 0;
        for (const auto& face : test::faces_of(net)) {
            expected += face.size() - 2;
            for (std::size_t k = 2; k < face.size(); ++k)
                for (std::size_t j = 1; j < k; ++j)
                    for (std::size_t i = 0; i < j; ++i)
                        triangles.insert(from_least({first_[face[i]], first_[face[j]], first_[face[k]]}));
        }
        for (const auto& t : test::faces_of(all.mesh))
            strange += triangles.contains(from_least({number[t[0]], number[t[1]], number[t[2]]})) ? 0 : 1;
        CHECK(strange == 0);
        CHECK(all.mesh.face_count() == expected);
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
    std::vector<Vec3d> normals;

  private:
    static std::array<std::uint32_t, 3> from_least(std::array<std::uint32_t, 3> t) {
        auto least = t;  // a place may be there twice
        for (int i = 0; i < 2; ++i) {
            t = {t[1], t[2], t[0]};
            least = std::min(least, t);
        }
        return least;
    }

    std::optional<PointMatch> match_;
    std::vector<std::uint32_t> first_;  // of the vertices at one place
    std::vector<std::uint8_t> shared_;
};

/// None where the scheme has no limit mask for one of the vertices.
std::optional<HierarchyMesh> limits_of(const Hierarchy& h, bool with_normals) {
    try {
        return h.to_mesh({.normals = with_normals});
    } catch (const Error& e) {
        REQUIRE(e.code() == ErrorCode::unsupported);
        return std::nullopt;
    }
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

/// What is compared of the sites of some meshes.
struct Compared {
    std::size_t limits = 0;
    std::set<int> levels;
};

/// The vertices of an adaptive mesh, and all sites of each level, whether they are leaves or not.
void compare_sites(const SiteChoice& choice, const ControlMesh& mesh, std::uint64_t seed, int levels,
                   Compared& compared) {
    CAPTURE(choice.scheme);
    CAPTURE(seed);
    const double tolerance = 1e-12 * mesh.bounding_box().diagonal();
    const auto make = [&] { return make_hierarchy(mesh, choice.scheme, {.rules = choice.rules}); };
    Hierarchy h = make(), all = make();
    const Hierarchy roots = make();
    const bool dual = h.family() == "vertices";
    const int steps = h.family() == "sqrt3" ? 2 : 1;  // of the hierarchy for one of refine()
    Random random(seed);
    for (int pass = 0; pass < 2 + steps; ++pass) {
        auto some = test::random_subset(test::leaves_of(h), dual ? 0.15 : 0.3, random);
        std::erase_if(some, [&](LeafHandle leaf) { return h.view(leaf).level >= levels * steps; });
        h.refine(some);
    }
    const HierarchyMesh finest = h.to_mesh({.positions = MeshPositions::finest});
    const std::vector<int> finest_level = finest_levels(h, finest);
    std::optional<HierarchyMesh> limits;
    std::size_t found = 0, turned = 0;
    for (int level = 1; level <= levels; ++level) {
        CAPTURE(level);
        const int own = level * steps;
        // Leaves of families of triangles that are halved or start from the faces' centres are a level ahead.
        all.refine_where(everything(), h.family() == "bisection" ? 2 * level - 1
                                       : dual                    ? level - 1
                                       : steps == 2              ? 2 * own
                                                                 : level);
        const HierarchyMesh whole = all.to_mesh({.positions = MeshPositions::level, .level = own, .triangles = true});
        const UniformMesh uniform(mesh, choice, level, tolerance, dual);
        const auto numbers = uniform.numbers(whole, tolerance);
        if (!uniform.limits.empty() && !limits) limits = limits_of(h, dual);
        // A vertex of a dual scheme is on its own level alone.
        const HierarchyMesh out = dual ? finest : h.to_mesh({.positions = MeshPositions::level, .level = own});
        REQUIRE(out.sites == finest.sites);
        for (std::size_t v = 0; v < out.sites.size(); ++v) {
            const int first = h.first_level(out.sites[v]);
            if (dual ? first != own : first > own) continue;
            const auto number = numbers.find(out.sites[v]);
            REQUIRE(number != numbers.end());
            compared.levels.insert(level);
            const Vec3d& expected = uniform.net.positions[number->second];
            REQUIRE(glm::length(out.mesh.positions[v] - expected) <= tolerance);
            if (dual || finest_level[v] == own) {
                ++found;
                REQUIRE(glm::length(finest.mesh.positions[v] - expected) <= tolerance);
            }
            if (uniform.limits.empty() || !limits || uniform.is_shared(number->second)) continue;
            ++compared.limits;
            REQUIRE(glm::length(limits->mesh.positions[v] - uniform.limits[number->second]) <= tolerance);
            if (dual) turned += glm::length(limits->mesh.normals[v] - uniform.normals[number->second]) > 1e-9;
        }
        std::vector<Vec3d> points(whole.sites.size());
        roots.positions(whole.sites, own, points);
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
    CHECK(3 * found >= finest.sites.size());
    // Creases that end leave triangles, where midedge-simplest has no tangent plane: both of its directions shrink by
    // 1/4, as what bends the surface does.
    if (choice.scheme != "midedge-simplest") CHECK(turned == 0);
}

/// Every scheme whose vertices are sites of corner cells or triangles.
std::vector<SiteChoice> primal_choices() {
    const RuleOptions cosine{.edge_beside_crease = EdgeBesideCrease::cosine};
    return {{"catmull-clark"},
            {"catmull-clark", cosine},
            {"bilinear"},
            {"kobbelt"},
            {"4-8"},
            {"averaging", {.averaging_steps = 0}},
            {"averaging", {.averaging_steps = 2}},
            {"averaging", {.averaging_steps = 4}},
            {"loop"},
            {"loop", cosine},
            {"tuned-loop"},
            {"butterfly"},
            {"modified-butterfly"},
            {"midpoint"}};
}

/// Seeds have no tags, infinitely sharp ones and semi-sharp ones in turn.
void check_dual_sites(const SiteChoice& choice, std::uint64_t seed_count, int levels) {
    Compared compared;
    for (const std::uint64_t seed : test::seeds(seed_count)) {
        test::RandomMeshOptions options = test::random_options(seed);
        options.columns = options.rows = options.boundary_rule == BoundaryRule::none ? 4 : 3;
        options.crease = seed % 3 == 0 ? 0 : 0.2;
        options.corner = seed % 3 == 0 ? 0 : 0.1;
        const auto tags = seed % 3 == 2 ? test::DualTags::of_all_kinds : test::DualTags::infinitely_sharp;
        compare_sites(choice, test::random_dual_mesh(seed, options, tags), seed, levels, compared);
    }
    CHECK(compared.limits > 0);
    CHECK(compared.levels.size() == static_cast<std::size_t>(levels));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[slow] [inv1] primal schemes: each vertex of an adaptive mesh is where uniform refinement has its site") {
    for (const SiteChoice& choice : primal_choices()) {
        Compared compared;
        for (const std::uint64_t seed : {2, 3, 4, 7}) {  // plane, tori, sphere; each boundary rule
            test::RandomMeshOptions options = test::random_options(seed);
            // Where the faces at the boundary are left out, others are to remain.
            options.columns = options.rows = options.boundary_rule == BoundaryRule::none ? 4 : 3;
            options.triangles_only = find_scheme(choice.scheme)->family == MeshFamily::triangles;
            compare_sites(choice, test::random_mesh(seed, options), seed, 2, compared);
            // Corners with angles of their own, and by those of the control mesh.
            if (seed > 3 || !find_scheme(choice.scheme)->takes_corner_angles) continue;
            options.hole = 0;
            options.crease = options.corner = 0.4;
            SiteChoice angles = choice;
            angles.rules.measure_corner_angles = seed == 3;
            const ControlMesh mesh = test::with_mixed_angles(test::random_mesh(seed, options), seed);
            REQUIRE(mesh.has_corner_angles());
            compare_sites(angles, mesh, seed, 2, compared);
        }
        CHECK(compared.limits > 0);
        CHECK(compared.levels.size() == 2);
    }
}

TEST_CASE("[inv1] dual schemes: each vertex of an adaptive mesh is where uniform refinement has its site") {
    check_dual_sites({"doo-sabin"}, 6, 3);
    for (const std::string_view scheme : {"doo-sabin-cc", "midedge", "midedge-simplest"})
        check_dual_sites({scheme}, 3, 2);
}

TEST_CASE("[slow] [inv1] averages: each vertex of an adaptive mesh is where uniform refinement has its site") {
    check_dual_sites({"biquartic"}, 3, 2);
    check_dual_sites({"averaging", {.averaging_steps = 1}}, 3, 2);
    check_dual_sites({"averaging", {.averaging_steps = 5}}, 1, 2);
}

TEST_CASE("[inv1] sqrt3: each vertex of an adaptive mesh is where uniform refinement has its site") {
    Compared compared;
    for (const std::uint64_t seed : test::seeds(6))
        compare_sites({"sqrt3"}, test::random_sqrt3_mesh(seed), seed, 2, compared);
    CHECK(compared.limits > 0);
    CHECK(compared.levels.size() == 2);
}

TEST_CASE(
    "[inv1] semi-sharp edges that meet creases, by the rules beside these: adaptive is uniform, mirrored or not") {
    RuleOptions cosine, angle;
    cosine.edge_beside_crease = EdgeBesideCrease::cosine;
    angle.corner_angle = 1;
    const auto off = [](const std::vector<Vec3d>& points, const PointMatch& match, const std::vector<Vec3d>& others) {
        double most = 0;
        for (const Vec3d& p : points) most = std::max(most, glm::length(others[match.nearest(p)] - p));
        return most;
    };
    for (const std::string_view scheme : {"catmull-clark", "loop"})
        for (const RuleOptions& rules : {cosine, angle})
            for (std::uint64_t seed = 1; seed <= 20; ++seed) {
                CAPTURE(scheme);
                CAPTURE(seed);
                Random random(seed);
                ControlMeshData data = test::mesh_for(*find_scheme(scheme), test::model("cube")).data();
                data.creases.clear();
                const std::uint32_t n = data.face_offsets[1];
                for (std::uint32_t h = 0; h < data.face_vertices.size(); ++h)
                    if (const std::uint32_t a = data.face_vertices[h],
                        b = data.face_vertices[h % n == n - 1 ? h - n + 1 : h + 1];
                        a < b && random.below(2) == 0)
                        data.creases.push_back({a, b, random.below(2) == 0 ? 0.5f : 10.0f});
                ControlMeshData other = data;
                for (Vec3d& p : other.positions) p.x = -p.x;
                for (std::size_t f = 0; f + 1 < other.face_offsets.size(); ++f)
                    std::reverse(other.face_vertices.begin() + other.face_offsets[f],
                                 other.face_vertices.begin() + other.face_offsets[f + 1]);
                const ControlMesh mesh = ControlMesh::build(std::move(data));
                const std::vector<Vec3d> uniform = refine(mesh, scheme, 1, {.rules = rules}).positions;
                const PointMatch match(uniform);
                std::vector<Vec3d> mirrored =
                    refine(ControlMesh::build(std::move(other)), scheme, 1, {.rules = rules}).positions;
                for (Vec3d& p : mirrored) p.x = -p.x;
                CHECK(off(mirrored, match, uniform) < 1e-12);
                Hierarchy h = make_hierarchy(mesh, scheme, {.rules = rules});
                h.refine_where(everything(), 1);
                const auto adaptive = h.to_mesh({.positions = MeshPositions::level, .level = 1}).mesh.positions;
                // Its vertices are some of the level's.
                CHECK(off(adaptive, match, uniform) < 1e-12);
            }
}

TEST_SUITE_END();
