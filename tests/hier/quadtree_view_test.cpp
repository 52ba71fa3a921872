#include "../../hier/forest/quadtree_view.hpp"

#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <tuple>

using namespace tetrakis;
using test::Random;

namespace {

using CellKey = std::tuple<std::uint32_t, int, std::uint32_t, std::uint32_t>;

/// Leaf cells by recursion from each corner cell: a cell is split where its centre is a vertex.
void collect(const ControlMesh& mesh, const std::set<Site>& vertices, HalfedgeId root, int level, LatticePoint at,
             std::set<CellKey>& cells) {
    const LatticePoint centre{2 * at.x + 1, 2 * at.y + 1};
    if (vertices.count(canonical(mesh, {root, centre, static_cast<std::uint8_t>(level + 1)})) == 0) {
        cells.emplace(root.value, level, at.x, at.y);
        return;
    }
    for (std::uint32_t k = 0; k < 4; ++k)
        collect(mesh, vertices, root, level + 1, {2 * at.x + k % 2, 2 * at.y + k / 2}, cells);
}

/// Whether the leaf is the half of that number of the cell, or has it for a child.
bool covers_half(const BisectionForest& forest, LeafId leaf, const QuadtreeCell& cell, std::size_t number) {
    const BisectionLeaf& l = forest.leaf(leaf);
    const auto is_half = [&](HalfedgeId root, const BisectionShape& shape) {
        const LatticePoint at{std::min({shape.a().x, shape.b().x, shape.apex.x}),
                              std::min({shape.a().y, shape.b().y, shape.apex.y})};
        return root == cell.root && at == cell.at && (shape.direction >= 4) == (number == 1);
    };
    if (l.depth % 2 != 0) return is_half(l.cell, l.shape());
    const HalfedgeId beside = l.depth == 0 ? forest.mesh().next(l.cell) : l.cell;
    return is_half(l.cell, l.shape().child(l.depth, 0)) || is_half(beside, l.shape().child(l.depth, 1));
}

BisectionForest random_forest(const ControlMesh& mesh, std::uint64_t seed) {
    Random random(seed);
    BisectionForest forest(mesh);
    std::vector<LeafId> marked, created;
    for (int pass = 0; pass < 9; ++pass) {
        marked.clear();
        for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
            if (forest.is_leaf(LeafId(s)) && random.chance(0.12)) marked.push_back(LeafId(s));
        forest.refine(marked, created);
    }
    return forest;
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("the quadtree view has a cell's children exactly where the forest has its centre") {
    for (std::uint64_t seed : test::seeds(12)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        const BisectionForest forest = random_forest(mesh, seed);
        std::set<Site> vertices;
        for (std::uint32_t p = mesh.vertex_count() + mesh.face_count(); p < forest.point_slots(); ++p)
            if (forest.is_point(PointId(p))) vertices.insert(forest.point_site(PointId(p)));
        std::set<CellKey> expected, found;
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
            if (!mesh.is_hole(mesh.face(HalfedgeId(h)))) collect(mesh, vertices, HalfedgeId(h), 0, {0, 0}, expected);
        const QuadtreeView view(forest);
        for (const QuadtreeCell& c : view.cells()) {
            CHECK(found.emplace(c.root.value, c.level, c.at.x, c.at.y).second);
            CHECK(c.half[0] != c.half[1]);
            for (std::size_t k = 0; k < 2; ++k) {
                const LeafId leaf = c.half[k];
                const int depth = forest.depth(leaf);
                CHECK((depth == 2 * c.level + 1 || depth == 2 * c.level));
                CHECK(covers_half(forest, leaf, c, k));
                // Of a leaf that is the half itself all corners are corners of the cell.
                if (depth % 2 == 0) continue;
                const CellTriangle t = forest.triangle(leaf);
                CHECK(t.root == c.root);
                for (const LatticePoint& p : t.corner) CHECK((p.x - c.at.x <= 1 && p.y - c.at.y <= 1));
            }
        }
        CHECK(found == expected);
    }
}

TEST_CASE("[inv4] neighbouring cells of the quadtree view differ by at most one level, and see each other") {
    for (std::uint64_t seed : test::seeds(12)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        const BisectionForest forest = random_forest(mesh, seed);
        const QuadtreeView view(forest);
        for (std::uint32_t i = 0; i < view.cells().size(); ++i) {
            const QuadtreeCell& c = view.cells()[i];
            REQUIRE(view.find(c.root, c.level, c.at) == i);
            if (c.level > 0) REQUIRE(!view.find(c.root, c.level - 1, {c.at.x / 2, c.at.y / 2}));
            REQUIRE(view.find(c.root, c.level + 1, {2 * c.at.x + 1, 2 * c.at.y}) == i);
            const std::uint32_t last = (1u << c.level) - 1;
            for (CellSide side : k_cell_sides) {
                const bool outer = side == CellSide::edge        ? c.at.y == 0
                                   : side == CellSide::prev_edge ? c.at.x == 0
                                   : side == CellSide::next_cell ? c.at.x == last
                                                                 : c.at.y == last;
                const HalfedgeId beyond = outer ? across(mesh, c.root, side) : c.root;
                const auto neighbours = view.neighbours(i, side);
                REQUIRE((neighbours.count > 0) == (beyond.valid() && !mesh.is_hole(mesh.face(beyond))));
                for (std::uint32_t n : neighbours) {
                    const QuadtreeCell& other = view.cells()[n];
                    REQUIRE(other.root == beyond);
                    REQUIRE(std::abs(other.level - c.level) <= 1);
                    REQUIRE((neighbours.count == 2) == (other.level == c.level + 1));
                    bool back = false;
                    for (CellSide s : k_cell_sides)
                        for (std::uint32_t m : view.neighbours(n, s)) back = back || m == i;
                    REQUIRE(back);
                }
            }
        }
    }
}

TEST_SUITE_END();
