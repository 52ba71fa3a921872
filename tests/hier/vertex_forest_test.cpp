#include "../kit/dual_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../refine/adaptive/adaptive_dual.hpp"
#include "../../refine/rules/rule_refinement.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>

using namespace tetrakis;

namespace tetrakis {

/// Breaks one link.
struct VertexForestCorruptor {
    static void break_link(VertexForest& forest) {
        for (auto& r : forest.records_)
            for (auto& link : r.link)
                if (link < VertexForest::k_coarser) {
                    link = VertexForest::k_coarser;
                    return;
                }
    }
    static void break_crease(VertexForest& forest) { forest.records_.front().creases ^= 1u; }
    static void lose_leaf(VertexForest& forest) { --forest.leaf_count_; }
    static std::size_t joints(const VertexForest& forest) { return forest.joints_.size(); }
    static void break_joint(VertexForest& forest) {
        for (auto& side : forest.joints_.front().sides)
            if (side.leads == VertexForest::Joint::Leads::to) side.slot = 0;
    }
    static void break_children(VertexForest& forest) {
        for (auto& child : forest.joints_.front().children) child.exists = true;
    }
    static void move_record(VertexForest& forest) { ++forest.records_.front().at.x; }
    static void lose_joint(VertexForest& forest) { forest.records_.front().joint = 1000000; }
    static void share_joint(VertexForest& forest) {
        auto& records = forest.records_;
        const auto has_joint = [](const auto& r) { return r.joint != VertexForest::k_no_joint; };
        const auto first = std::find_if(records.begin(), records.end(), has_joint);
        std::find_if(first + 1, records.end(), has_joint)->joint = first->joint;
    }
    static void free_joint(VertexForest& forest) { forest.free_joints_.push_back(0); }
    static void turn_smooth(VertexForest& forest) { forest.records_.front().smooth_from[0] ^= 1; }
    static void exchange_records(VertexForest& forest) {
        std::swap(forest.child_[forest.records_[0].parent], forest.child_[forest.records_[1].parent]);
    }
};

}  // namespace tetrakis

namespace {

/// Which leaves, whatever their slots.
std::vector<VertexCell> leaf_cells(const VertexForest& forest) {
    std::vector<VertexCell> cells;
    for (const LeafId leaf : forest.ordered_leaves()) cells.push_back(forest.cell(leaf));
    return cells;
}

ControlMesh model(const std::string& name) {
    return ControlMesh::build(read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / (name + ".obj")));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] vertex quadtrees: limits and normals on creases, where they cross and end, are those of a level") {
    for (const char* name : {"doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest"})
        for (const std::uint64_t seed : {6u, 8u, 9u, 14u}) {
            CAPTURE(name);
            CAPTURE(seed);
            test::RandomMeshOptions options = test::random_options(seed);
            options.hole = 0;
            options.crease = 0.25;
            options.boundary_rule = BoundaryRule::edge_and_corner;
            const bool semi_sharp = seed > 8;
            const ControlMesh mesh = test::random_dual_mesh(
                seed, options, semi_sharp ? test::DualTags::of_all_kinds : test::DualTags::infinitely_sharp);
            const int level = semi_sharp ? 3 : 2;
            AdaptiveDual dual(mesh, *find_scheme(name));
            std::vector<LeafId> created;
            for (int l = 1; l < level; ++l) dual.forest().refine(dual.forest().ordered_leaves(), created);
            const PolygonMesh got = dual.to_mesh({.limit = true, .normals = true});
            const PolygonMesh net = dual.to_mesh({.limit = false});
            const PolygonMesh at = refine_by_rules(mesh, *find_scheme(name), level);
            const RuleRefiner refiner(mesh, *find_scheme(name), level, {.limit = true, .normals = true});
            std::vector<Vec3d> limits(refiner.vertex_count()), normals(refiner.vertex_count());
            refiner.refine(mesh.positions(), limits);
            refiner.normals(mesh.positions(), normals);
            // By their points in the net, which few share.
            std::multimap<std::tuple<double, double, double>, std::uint32_t> vertices;
            for (std::uint32_t v = 0; v < at.positions.size(); ++v)
                vertices.insert({{at.positions[v].x, at.positions[v].y, at.positions[v].z}, v});
            REQUIRE(vertices.size() == net.positions.size());
            const double diagonal = mesh.bounding_box().diagonal();
            int off = 0, turned = 0;
            for (std::size_t v = 0; v < net.positions.size(); ++v) {
                const Vec3d& p = net.positions[v];
                bool there = false, same_normal = false;
                for (auto [at_point, end] = vertices.equal_range({p.x, p.y, p.z}); at_point != end; ++at_point) {
                    const std::uint32_t u = at_point->second;
                    if (!(glm::length(limits[u] - got.positions[v]) <= 1e-12 * diagonal)) continue;
                    there = true;
                    same_normal = same_normal || glm::length(normals[u] - got.normals[v]) <= 1e-9;
                }
                off += !there;
                turned += !same_normal;
            }
            CHECK(off == 0);
            // Creases that end leave triangles, where midedge-simplest has no tangent plane: both of its directions
            // shrink by 1/4, as what bends the surface does.
            if (!semi_sharp || name != std::string("midedge-simplest")) CHECK(turned == 0);
        }
}

TEST_CASE("[bad-input] vertex quadtrees refuse what is no leaf, too deep or of no quadtree, and stay as they are") {
    const ControlMesh mesh = model("cube");
    AdaptiveDual dual(mesh, *find_scheme("doo-sabin"));
    VertexForest& forest = dual.forest();
    std::vector<LeafId> created;
    const LeafId root(3);
    forest.refine({&root, 1}, created);
    const std::vector<VertexCell> before = leaf_cells(forest);
    const std::vector<LeafId> mixed{LeafId(0), root}, outside{LeafId(5000)};
    CHECK_THROWS_AS(forest.refine(mixed, created), Error);
    CHECK_THROWS_AS(forest.refine(outside, created), Error);
    CHECK_THROWS_AS(forest.coarsen(mixed, created), Error);
    CHECK(leaf_cells(forest) == before);
    CHECK(forest.mergeable_siblings(LeafId(0)).empty());
    CHECK(forest.mergeable_siblings(root).empty());
    LeafId deep(0);
    for (int level = 0; level < k_max_level; ++level) {
        forest.refine({&deep, 1}, created);
        deep = created.back();
    }
    CHECK_THROWS_AS(forest.refine({&deep, 1}, created), Error);
    CHECK(!forest.check().has_value());

    CHECK_THROWS_AS(AdaptiveDual(mesh, *find_scheme("catmull-clark")), Error);

    const auto corrupted = [&](auto&& damage) {
        VertexForest copy = forest;
        damage(copy);
        return copy.check().value_or("");
    };
    // Joints, along the edges of a face that are smooth at once.
    ControlMeshData data = mesh.data();
    for (std::uint32_t c = 0; c < 4; ++c)
        data.creases.push_back({data.face_vertices[c], data.face_vertices[(c + 1) % 4], 1.0f, 0});
    const ControlMesh creased = ControlMesh::build(data);
    const AdaptiveDual whole(creased, *find_scheme("doo-sabin"));
    VertexForest joined = whole.forest();
    joined.refine(joined.ordered_leaves(), created);
    REQUIRE(VertexForestCorruptor::joints(joined) == 2 * 8);
    CHECK(!joined.check().has_value());
    for (const auto damage :
         {VertexForestCorruptor::break_joint, VertexForestCorruptor::break_children, VertexForestCorruptor::lose_joint,
          VertexForestCorruptor::share_joint, VertexForestCorruptor::free_joint, VertexForestCorruptor::turn_smooth,
          VertexForestCorruptor::exchange_records}) {
        VertexForest copy = joined;
        damage(copy);
        CHECK(copy.check().has_value());
    }
    CHECK(corrupted([](VertexForest& f) { VertexForestCorruptor::break_link(f); }).find("link") < 999);
    CHECK(corrupted([](VertexForest& f) { VertexForestCorruptor::break_crease(f); }).find("other creases") < 999);
    CHECK(corrupted([](VertexForest& f) { VertexForestCorruptor::lose_leaf(f); }).find("number of leaves") < 999);
    CHECK(corrupted([](VertexForest& f) { VertexForestCorruptor::move_record(f); }).find("another place") < 999);
}

TEST_SUITE_END();
