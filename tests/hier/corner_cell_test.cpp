#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/forest/bisection_path.hpp"

#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <map>
#include <set>

using namespace tetrakis;

namespace {

CellPoint point_of(const Site& s) { return {s.root, s.at.x, s.at.y}; }

bool on_side(const CellPoint& p, CellSide side, std::int64_t n) {
    switch (side) {
        case CellSide::edge:
            return p.y == 0;
        case CellSide::prev_edge:
            return p.x == 0;
        case CellSide::next_cell:
            return p.x == n;
        case CellSide::prev_cell:
            return p.y == n;
    }
    return false;
}

/// Every address of a point at one level, by crossing sides until nothing new turns up.
std::set<CellPoint> addresses(const ControlMesh& mesh, const CellPoint& start, std::int64_t n) {
    std::set<CellPoint> found{start};
    std::vector<CellPoint> todo{start};
    while (!todo.empty()) {
        const CellPoint p = todo.back();
        todo.pop_back();
        for (CellSide side : k_cell_sides) {
            if (!on_side(p, side, n)) continue;
            const CellPoint q = cross(mesh, p, side, n);
            if (q.root.valid() && found.insert(q).second) todo.push_back(q);
        }
    }
    return found;
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("a walk from cell to cell that always turns left comes home with its heading, around every lattice point") {
    for (std::uint64_t seed : test::seeds(10)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        const std::int64_t n = 2, size = 2 * n;  // half-steps: the centres of the n x n cells are odd
        struct Turtle {
            CellPoint at, ahead;  // ahead: the centre of the next cell, in the same frame
            bool operator==(const Turtle&) const = default;
        };
        // Moves into the cell ahead and turns left; false on the boundary.
        const auto step = [&](Turtle& t) {
            std::int64_t dx = t.ahead.x - t.at.x, dy = t.ahead.y - t.at.y;
            CellPoint p = t.ahead, q{p.root, p.x - dy, p.y + dx};
            const CellSide* out = nullptr;
            for (const CellSide& side : k_cell_sides) {
                const bool beyond = side == CellSide::edge        ? p.y < 0
                                    : side == CellSide::prev_edge ? p.x < 0
                                    : side == CellSide::next_cell ? p.x > size
                                                                  : p.y > size;
                if (beyond) out = &side;
            }
            if (out != nullptr) {
                p = cross(mesh, p, *out, size);
                q = cross(mesh, q, *out, size);
            }
            t = {p, q};
            return p.root.valid();
        };
        for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i)
            for (std::int64_t y = 0; y < n; ++y)
                for (std::int64_t x = 0; x < n; ++x) {
                    // From the cell (x, y) eastwards, turning about its upper right corner.
                    const CellPoint at{HalfedgeId(i), 2 * x + 1, 2 * y + 1};
                    const Turtle start{at, {at.root, at.x + 2, at.y}};
                    std::uint32_t expected = 4;
                    if (x == n - 1 && y == n - 1) expected = mesh.face_size(mesh.face(at.root));
                    Turtle t = start;
                    for (std::uint32_t k = 0; k < expected; ++k) REQUIRE(step(t));
                    CHECK(t == start);
                    // Westwards, turning about its lower left corner: may meet the boundary.
                    const Turtle west{at, {at.root, at.x - 2, at.y}};
                    t = west;
                    const VertexId v = mesh.origin(at.root);
                    const bool corner = x == 0 && y == 0;
                    const std::uint32_t turns = corner ? mesh.face_valence(v) : 4;
                    std::uint32_t k = 0;
                    while (k < turns && step(t)) ++k;
                    if (k == turns) {
                        CHECK(t == west);
                    } else {
                        CHECK((mesh.is_boundary(v) || x == 0 || y == 0));
                    }
                    if (corner) CHECK((k == turns) == !mesh.is_boundary(v));
                }
    }
}

TEST_CASE("every address of a lattice point has the same canonical site, and that is one of them") {
    for (std::uint64_t seed : test::seeds(10)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        const int level = 2;
        const std::int64_t n = 1 << level;
        std::map<Site, std::set<CellPoint>> classes;
        for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i)
            for (std::uint32_t y = 0; y <= n; ++y)
                for (std::uint32_t x = 0; x <= n; ++x) {
                    const Site site{HalfedgeId(i), {x, y}, level};
                    const Site key = canonical(mesh, site);
                    const auto all = addresses(mesh, point_of(site), n);
                    for (const CellPoint& p : all) {
                        const Site other{
                            p.root, {static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y)}, level};
                        REQUIRE(canonical(mesh, other) == key);
                    }
                    // The key itself is an address, at its lowest level, and finer addresses agree.
                    const std::uint32_t scale = 1u << (level - key.level);
                    REQUIRE(all.count({key.root, key.at.x * scale, key.at.y * scale}) == 1);
                    REQUIRE((key.level == 0 || ((key.at.x | key.at.y) & 1) == 1));
                    REQUIRE(canonical(mesh, key) == key);
                    const Site fine{site.root, {x << 28, y << 28}, k_max_level};
                    REQUIRE(canonical(mesh, fine) == key);
                    bool surface = false;
                    for (const CellPoint& p : all) surface = surface || !mesh.is_hole(mesh.face(p.root));
                    REQUIRE(surface == !mesh.is_hole(mesh.face(key.root)));
                    auto [entry, fresh] = classes.try_emplace(key, all);
                    REQUIRE((fresh || entry->second == all));
                }
        // As many points as uniform refinement has vertices: V + E + F, then the usual recursion.
        std::uint64_t v = mesh.vertex_count(), e = mesh.edge_count(), f = mesh.face_count(),
                      corners = mesh.halfedge_count();
        for (int l = 0; l <= level; ++l) {
            const std::uint64_t v2 = v + e + f, e2 = 2 * e + corners, f2 = corners;
            v = v2, e = e2, f = f2, corners = 4 * f2;
        }
        CHECK(classes.size() == v);
    }
}

TEST_SUITE_END();
