#include "root_lattices.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

// Where a level's vertices are in the lattices of the roots: found by walking over its faces, once.
namespace tetrakis::detail {

/// Vertices of `mesh` in the order of the layout; empty if its faces do not form the lattices.
std::optional<std::vector<int>> RootLattices::lattice(const RootLayout& at, const RuleMesh& mesh,
                                                      std::span<const int> corner_halfedge) const {
    const std::uint32_t n = at.segments(), sides = side_count();
    if (at.vertex_count() != static_cast<std::uint32_t>(mesh.vertex_count())) return std::nullopt;
    std::vector<int> vertices(at.vertex_count(), -1);
    for (int v = 0; v < base_.vertex_count(); ++v)
        if (base_.first(v) == RuleMesh::none) vertices[v] = v;
    const auto across = [&](int h) { return h < 0 ? h : mesh.twin(h); };
    for (std::uint32_t f = 0; f < root_count(); ++f) {
        // Along the bottom edges of each row's cells (triangles: of those that point up).
        int row = corner_halfedge[sides * f];
        for (std::uint32_t y = 0; y < n; ++y) {
            if (row < 0) return std::nullopt;
            int h = row;
            const std::uint32_t last = sides == 4 ? n : n - y;
            for (std::uint32_t x = 0; x < last; ++x) {
                if (h < 0) return std::nullopt;
                vertices[at.at(f, x, y)] = mesh.origin(h);
                const int up = mesh.next(h);
                if (x + 1 == last) vertices[at.at(f, x + 1, y)] = mesh.origin(up);
                if (y + 1 == n) {
                    vertices[at.at(f, x, n)] = mesh.origin(mesh.prev(h));
                    if (sides == 4 && x + 1 == n) vertices[at.at(f, n, n)] = mesh.target(up);
                }
                if (x + 1 == last) break;
                h = across(up);
                if (h >= 0) h = mesh.next(h);
                if (sides == 3) {
                    h = across(h);
                    if (h >= 0) h = mesh.next(h);
                }
            }
            if (y + 1 == n) break;
            row = sides == 4 ? across(mesh.next(mesh.next(row))) : across(mesh.next(row));
            if (sides == 3 && row >= 0) row = across(mesh.next(mesh.next(row)));
        }
    }
    if (std::find(vertices.begin(), vertices.end(), -1) != vertices.end()) return std::nullopt;
    return vertices;
}

/// Vertices of `mesh` by place, for a level of a dual scheme, all of whose inner vertices have four neighbours.
std::optional<std::vector<int>> RootLattices::cells(const RootLayout& at, const RuleMesh& mesh,
                                                    std::span<const int> last_halfedge) const {
    const std::uint32_t n = at.segments();
    const Numbers numbers = point_numbers(at);
    if (numbers.count != static_cast<std::uint32_t>(mesh.vertex_count())) return std::nullopt;
    struct Way {
        int vertex = -1, edge = -1;
    };
    // The neighbour of `from.vertex` along the edge that is `turns` quarter turns counter-clockwise from `from.edge`.
    const auto after = [&](const Way& from, std::uint32_t turns) -> Way {
        if (from.vertex < 0) return {};
        const RuleMesh::Ring ring = mesh.ring(from.vertex);
        const auto edge = [&](int i) {
            return mesh.edge(i < ring.faces() ? ring.halfedge[i] : mesh.prev(ring.halfedge[i - 1]));
        };
        int i = 0;
        while (i < ring.edges() && edge(i) != from.edge) ++i;
        const int to = (i + static_cast<int>(turns)) % 4;
        if (i == ring.edges() || to >= ring.edges() || (ring.closed && ring.edges() != 4)) return {};
        return {ring.neighbour[to], edge(to)};
    };
    // `known`: by place, the edge of `mesh` that leaves its cell across side 3; in roots beyond the boundary, side 0.
    std::vector<int> vertices(place_count(at), -1), known(vertices.size(), -1);
    for (std::uint32_t f = 0; f < own_roots_; ++f) {
        Way last{mesh.origin(last_halfedge[f]), mesh.edge(last_halfedge[f])};  // the last cell of a row, its side 1
        for (std::uint32_t y = n; y-- > 0;) {
            Way cell = last;
            for (std::uint32_t x = n; x-- > 0;) {
                const std::uint32_t place = number_at(at, f, {x, y});
                vertices[place] = cell.vertex;
                cell = after(cell, 2);
                known[place] = cell.edge;
            }
            const Way below = after(last, 3);
            last = {below.vertex, after(below, 3).edge};
        }
    }
    // Roots beyond the boundary start at the neighbouring cells along their first side, and go outwards.
    for (std::uint32_t f = own_roots_; f < root_count(); ++f) {
        const std::uint32_t h = base_.twin(4 * f), to_side = (h / 4 < own_roots_ ? h + 1 : h) % 4;
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t inner = number(at, h, n - 1 - x, 0);
            Way cell = after({vertices[inner], known[inner]}, to_side);
            for (std::uint32_t y = 0; y < n; ++y, cell = after(cell, 2)) {
                vertices[number_at(at, f, {x, y})] = cell.vertex;
                known[number_at(at, f, {x, y})] = cell.edge;
            }
        }
    }
    // The places of a point must have the same vertex, and different points different vertices.
    std::vector<int> of_point(numbers.count, -1);
    std::vector<char> found(numbers.count, 0);
    for (std::uint32_t place = 0; place < vertices.size(); ++place) {
        const int v = vertices[place];
        int& first = of_point[numbers.of(place)];
        if (v < 0 || (first >= 0 && first != v)) return std::nullopt;
        if (first < 0 && std::exchange(found[static_cast<std::size_t>(v)], 1) != 0) return std::nullopt;
        first = v;
    }
    return vertices;
}

// Places at levels of any depth: the root of a point, places beyond a side, the ring around a place.

RootPlace RootLattices::own_place(std::uint32_t segments, const RootPlace& at) const {
    if (in_cells_ || is_inside(segments, at.x, at.y)) return at;
    for (std::uint32_t s = 0, h = side_count() * at.root; s < side_count(); ++s, ++h) {
        const auto [along, away] = seen_from(segments, s, {at.x, at.y});
        if (away != 0) continue;
        if (along == 0 || along == segments)
            return place_seen(segments, base_.first(along == 0 ? base_.origin(h) : base_.target(h)), 0, 0);
        if (!base_.leads(h)) return place_seen(segments, base_.twin(h), segments - along, 0);
        break;
    }
    return at;
}

RootLattices::Around RootLattices::around(std::uint32_t segments, const RootPlace& at) const {
    const bool quads = side_count() == 4;
    Around result;
    const auto add = [&](std::uint32_t h, std::uint32_t a, std::uint32_t b) {
        result.places.push_back(own_place(segments, place_seen(segments, h, a, b)));
    };
    Place seen{at.x, at.y};
    std::uint32_t side = 0;
    for (std::uint32_t s = 0, h = side_count() * at.root; s < side_count(); ++s, ++h) {
        const auto [along, away] = seen_from(segments, s, {at.x, at.y});
        if (away != 0) continue;
        if (along == 0 || along == segments) {
            std::uint32_t last = none;
            result.closed =
                base_.for_each_leaving(along == 0 ? base_.origin(h) : base_.target(h), [&](std::uint32_t g) {
                    add(g, 1, 0);
                    if (quads) add(g, 1, 1);
                    last = g;
                });
            if (!result.closed) add(last, 0, 1);
            return result;
        }
        seen = {along, away};
        side = s;
        result.closed = base_.twin(h) != RuleMesh::none;
        break;
    }
    using Step = std::pair<int, int>;
    static constexpr std::array<Step, 8> square{{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
    static constexpr std::array<Step, 6> hexagon{{{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};
    for (const auto& [da, db] : quads ? std::span<const Step>(square) : std::span<const Step>(hexagon)) {
        if (!result.closed && db < 0) break;
        const auto p = turned_place<FarPlace>(quads, std::int64_t{segments}, side, std::int64_t{seen.x} + da,
                                              std::int64_t{seen.y} + db);
        result.places.push_back(place_beyond(segments, at.root, p.x, p.y));
    }
    return result;
}

RootPlace RootLattices::place_beyond(std::uint32_t segments, std::uint32_t root, std::int64_t x, std::int64_t y) const {
    if (x > 0 && y > 0 && is_inside(segments, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)))
        return {root, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
    const std::uint32_t sides = side_count();
    const auto n = static_cast<std::int64_t>(last_place(segments));
    for (std::uint32_t s = 0; s < sides;) {
        const FarPlace seen = turned_place<FarPlace>(sides == 4, n, s == 0 ? 0 : sides - s, x, y);
        if (seen.y >= 0) {
            ++s;
            continue;
        }
        const std::uint32_t t = base_.twin(sides * root + s);
        root = t / sides;
        const FarPlace there =
            turned_place<FarPlace>(sides == 4, n, t % sides, n - seen.x, in_cells_ ? -seen.y - 1 : -seen.y);
        x = there.x;
        y = there.y;
        s = 0;
    }
    return own_place(segments, {root, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)});
}

}  // namespace tetrakis::detail
