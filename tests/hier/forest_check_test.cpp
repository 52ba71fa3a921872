#include "../kit/random_mesh.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/forest/triangle_forest.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <utility>

namespace tetrakis::detail {

/// Breaks forests where no call can.
struct ForestSurgery {
    static auto& leaves(BisectionForest& f) { return f.leaves_; }
    static auto& sites(BisectionForest& f) { return f.sites_; }
    static auto& leaf_count(BisectionForest& f) { return f.leaf_count_; }
    static auto& midpoint_count(BisectionForest& f) { return f.midpoint_count_; }
    static auto& free_leaves(BisectionForest& f) { return f.free_leaves_; }
    static auto& free_points(BisectionForest& f) { return f.free_points_; }
    static auto& work(BisectionForest& f) { return f.scratch_.work; }

    static auto& records(TriangleForest& f) { return f.records_; }
    static auto& sites(TriangleForest& f) { return f.sites_; }
    static auto& child(TriangleForest& f) { return f.child_; }
    static auto& root_link(TriangleForest& f) { return f.root_link_; }
    static auto& leaf_count(TriangleForest& f) { return f.leaf_count_; }
    static auto& point_count(TriangleForest& f) { return f.point_count_; }
    static auto& free_records(TriangleForest& f) { return f.free_records_; }
    static auto& free_points(TriangleForest& f) { return f.free_points_; }
    static auto& marks(TriangleForest& f) { return f.marks_; }
};

}  // namespace tetrakis::detail

using namespace tetrakis;
using test::Random;
using Surgery = tetrakis::detail::ForestSurgery;

namespace {

/// A value changed for a while.
template <class T, class V>
void with(T& place, V value, const std::function<void()>& look) {
    const T old = std::exchange(place, static_cast<T>(value));
    REQUIRE(old != place);
    look();
    place = old;
}

/// The check must name something; and one of these words must be in what it says.
template <class Forest>
void expect_fault(const Forest& forest, std::initializer_list<std::string> words) {
    const auto fault = forest.check();
    REQUIRE(fault.has_value());
    INFO(*fault);
    bool any = words.size() == 0;
    for (const std::string& word : words) any |= fault->find(word) != std::string::npos;
    CHECK(any);
}

template <class Forest, class Split>
void grow(Forest& forest, Random& random, Split&& split) {
    for (int i = 0; i < 150; ++i) {
        const LeafId leaf(random.below(forest.leaf_slots()));
        if (!forest.is_leaf(leaf)) continue;
        if (random.chance(0.7))
            split(leaf);
        else if (forest.can_merge(leaf))
            forest.merge(leaf);
    }
    REQUIRE(!forest.check());
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("check() of a bisection forest finds whatever is wrong in any record, and names it") {
    for (const std::uint64_t seed : test::seeds(3)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        BisectionForest forest(mesh);
        Random random(seed);
        grow(forest, random, [&](LeafId leaf) {
            if (forest.depth(leaf) < 9) forest.split(leaf);
        });
        auto& leaves = Surgery::leaves(forest);
        for (std::uint32_t slot = 0; slot < forest.leaf_slots(); ++slot) {
            if (!forest.is_leaf(LeafId(slot))) continue;
            CAPTURE(slot);
            BisectionLeaf& leaf = leaves[slot];
            const auto named = [&] { expect_fault(forest, {"leaf ", "root "}); };
            if (leaf.depth > 0) with(leaf.path, leaf.path ^ 1, named);
            with(leaf.path, leaf.path | std::uint64_t{1} << 62, named);
            with(leaf.cell, HalfedgeId((leaf.cell.value + 1) % mesh.halfedge_count()), named);
            with(leaf.cell, HalfedgeId{}, named);
            with(leaf.apex.x, leaf.apex.x + 1, named);
            with(leaf.apex.y, leaf.apex.y + 2, named);
            with(leaf.direction, leaf.direction ^ 2, named);
            with(leaf.depth, leaf.depth + 2, named);
            with(leaf.depth, 61, named);
            for (std::size_t k = 0; k < 3; ++k) {
                if (leaf.neighbour[k].valid()) with(leaf.neighbour[k], LeafId{}, named);
                with(leaf.neighbour[k], LeafId(slot), named);
                with(leaf.neighbour[k], LeafId(forest.leaf_slots() + 5), named);
                with(leaf.vertex[k], leaf.vertex[(k + 1) % 3], named);
                with(leaf.vertex[k], PointId{}, named);
                Site& site = Surgery::sites(forest)[leaf.vertex[k].value];
                with(site.at.x, site.at.x + 1, named);
            }
            // A leaf that is gone: missed by its neighbours, or by the count.
            with(leaf.depth, 0xFF, [&] { expect_fault(forest, {"without leaf", "leaf count", "cover"}); });
            REQUIRE(!forest.check());
            slot += random.below(5);
        }
        with(Surgery::leaf_count(forest), forest.leaf_count() + 1, [&] { expect_fault(forest, {"leaf count"}); });
        with(Surgery::midpoint_count(forest), forest.midpoint_count() + 1,
             [&] { expect_fault(forest, {"midpoint count"}); });
        with(Surgery::work(forest)[0].mark, 1, [&] { expect_fault(forest, {"mark"}); });
        for (const std::uint32_t wrong : {0u, forest.leaf_slots() + 1}) {
            Surgery::free_leaves(forest).push_back(wrong);
            expect_fault(forest, {"slot"});
            Surgery::free_leaves(forest).pop_back();
        }
        Surgery::free_points(forest).push_back(0);
        expect_fault(forest, {"points"});
        Surgery::free_points(forest).pop_back();
        CHECK(!forest.check());
    }
}

TEST_CASE("check() of a triangle forest finds whatever is wrong in any record, and names it") {
    for (const std::uint64_t seed : test::seeds(3)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        TriangleForest forest(mesh);
        Random random(seed);
        grow(forest, random, [&](LeafId leaf) {
            if (forest.level(leaf) < 4) forest.split(leaf);
        });
        const std::uint32_t roots = mesh.face_count();
        auto& records = Surgery::records(forest);
        auto& child = Surgery::child(forest);
        int looked_at = 0;
        for (std::uint32_t i = 0; i < records.size(); ++i) {
            auto& record = records[i];
            if (child[record.parent] != i) continue;  // a free one
            ++looked_at;
            CAPTURE(i);
            const auto named = [&] { expect_fault(forest, {"triangle ", "record ", "point "}); };
            with(record.parent, (record.parent + 1) % roots, named);
            with(record.face, record.face + 1, named);
            with(record.at.x, record.at.x + 1, named);
            with(record.at.y, record.at.y + 1, named);
            with(record.level, record.level + 1, named);
            with(record.is_reversed, 1 - record.is_reversed, named);
            for (std::size_t k = 0; k < 6; ++k) {
                with(record.point[k], record.point[(k + 1) % 6], named);
                with(record.point[k], PointId::none, named);
                Site& site = Surgery::sites(forest)[record.point[k]];
                if (k >= 3) with(site.at.x, site.at.x + 1, named);
            }
            for (std::size_t e = 0; e < 3; ++e) {
                with(record.link[e], record.link[e] == 0xFFFF'FFFFu ? 0 : 0xFFFF'FFFFu, named);
                with(record.link[e], record.link[e] ^ 1, named);
            }
            with(child[record.parent], 0xFFFF'FFFFu, [&] { expect_fault(forest, {}); });
            with(child[record.parent], static_cast<std::uint32_t>(records.size()), [&] { expect_fault(forest, {}); });
            REQUIRE(!forest.check());
        }
        CHECK(looked_at > 10);
        for (std::uint32_t h = 0; h < 3 * roots; ++h) {
            auto& link = Surgery::root_link(forest)[h];
            with(link, link ^ 1, [&] { expect_fault(forest, {"triangle " + std::to_string(h / 3)}); });
        }
        with(Surgery::leaf_count(forest), forest.leaf_count() + 1, [&] { expect_fault(forest, {"leaves"}); });
        with(Surgery::point_count(forest), forest.point_count() + 1, [&] { expect_fault(forest, {"points"}); });
        with(Surgery::marks(forest)[0], 1, [&] { expect_fault(forest, {}); });
        Surgery::free_records(forest).push_back(static_cast<std::uint32_t>(records.size()));
        expect_fault(forest, {"record"});
        Surgery::free_records(forest).pop_back();
        Surgery::free_points(forest).push_back(0);
        expect_fault(forest, {"point"});
        Surgery::free_points(forest).pop_back();
        CHECK(!forest.check());
    }
}

TEST_SUITE_END();
