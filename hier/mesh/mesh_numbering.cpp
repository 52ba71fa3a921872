#include "mesh_numbering.hpp"

#include "../base/disjoint_sets.hpp"
#include "mesh_check.hpp"
#include "mesh_links.hpp"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <numeric>
#include <tuple>
#include <utility>

// Finds vertices by their positions.
namespace tetrakis::detail {

namespace {

// A warning needs one coinciding boundary edge in this many; fewer may be intended.
constexpr std::uint64_t k_edges_to_one_unwelded = 4;

}  // namespace

std::vector<std::uint32_t> replace_faces(ControlMeshData& data, const NewFaces& faces) {
    for (auto* const layer : {&data.face_vertices, &data.face_uvs, &data.face_normals}) gather(*layer, faces.corners);
    for (auto* const layer : {&data.face_material, &data.face_group}) gather(*layer, faces.sources);
    gather(data.face_lines, faces.sources);
    data.face_offsets = faces.offsets;
    std::vector<std::uint32_t> gone;
    const std::vector<std::uint32_t> holes = std::exchange(data.holes, {});
    const std::vector<std::uint64_t> lines = std::exchange(data.hole_lines, {});
    for (std::uint32_t i = 0; i < holes.size(); ++i) {
        const auto [first, last] = std::equal_range(faces.sources.begin(), faces.sources.end(), holes[i]);
        if (first == last) gone.push_back(i);
        for (auto f = first; f != last; ++f) {
            data.holes.push_back(static_cast<std::uint32_t>(f - faces.sources.begin()));
            if (!lines.empty()) data.hole_lines.push_back(lines[i]);
        }
    }
    return gone;
}

bool is_sound_position(const Vec3d& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) &&
           std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= k_max_coordinate;
}

std::vector<std::uint32_t> first_at_position(std::span<const Vec3d> positions, std::vector<std::uint32_t> listed) {
    const auto key = [&](std::uint32_t v) {
        const Vec3d& p = positions[v];
        return std::tuple(p.x, p.y, p.z);
    };
    std::ranges::sort(listed, {}, [&](std::uint32_t v) { return std::pair(key(v), v); });
    std::vector<std::uint32_t> first(positions.size());
    std::iota(first.begin(), first.end(), 0u);
    for (std::size_t i = 1; i < listed.size(); ++i)
        if (key(listed[i]) == key(listed[i - 1])) first[listed[i]] = first[listed[i - 1]];
    return first;
}

std::vector<std::uint32_t> welded(const std::vector<Vec3d>& positions, double distance) {
    std::vector<std::uint32_t> listed;
    double largest = 0;
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        const Vec3d& p = positions[v];
        if (!is_sound_position(p)) continue;
        listed.push_back(v);
        largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    std::vector<std::uint32_t> first = first_at_position(positions, listed);
    // Coordinates that differ as doubles are hardly nearer to each other; and cell numbers fit into 64 bits.
    constexpr double k_least_share = 0x1p-50;
    if (largest == 0 || distance <= largest * k_least_share) return first;

    // Cells whose diagonal is within the distance: all vertices of one cell are joined.
    constexpr double k_side = 0.57;  // < 1 / sqrt(3); the distance spans at most two cells
    struct Point {
        std::array<std::int64_t, 3> cell;
        std::uint32_t vertex;
        auto operator<=>(const Point&) const = default;
    };
    std::vector<Point> points;
    for (const std::uint32_t v : listed) {
        if (first[v] != v) continue;
        const Vec3d at = glm::floor(positions[v] / (k_side * distance));
        points.push_back(
            {{static_cast<std::int64_t>(at.x), static_cast<std::int64_t>(at.y), static_cast<std::int64_t>(at.z)}, v});
    }
    std::sort(points.begin(), points.end());
    std::vector<std::uint32_t> start;  // first point of each cell in `points`
    for (std::uint32_t i = 0; i < points.size(); ++i)
        if (i == 0 || points[i].cell != points[i - 1].cell) start.push_back(i);
    const std::uint32_t cells = static_cast<std::uint32_t>(start.size());
    start.push_back(static_cast<std::uint32_t>(points.size()));

    DisjointSets sets(first);
    for (std::uint32_t c = 0; c < cells; ++c)
        for (std::uint32_t i = start[c] + 1; i < start[c + 1]; ++i)
            sets.unite(points[start[c]].vertex, points[i].vertex);
    const auto join = [&](std::uint32_t c, std::uint32_t d) {
        if (sets.find(points[start[c]].vertex) == sets.find(points[start[d]].vertex)) return;
        for (std::uint32_t i = start[c]; i < start[c + 1]; ++i)
            for (std::uint32_t j = start[d]; j < start[d + 1]; ++j)
                if (glm::distance(positions[points[i].vertex], positions[points[j].vertex]) <= distance)
                    return sets.unite(points[i].vertex, points[j].vertex);
    };
    for (std::uint32_t c = 0; c < cells; ++c) {
        const std::array<std::int64_t, 3> cell = points[start[c]].cell;
        for (std::int64_t x = 0; x <= 2; ++x)  // each pair of cells once
            for (std::int64_t y = x == 0 ? 0 : -2; y <= 2; ++y) {
                const std::int64_t z = x == 0 && y == 0 ? 1 : -2;
                const std::array<std::int64_t, 3> low{cell[0] + x, cell[1] + y, cell[2] + z};
                const std::array<std::int64_t, 3> high{low[0], low[1], cell[2] + 2};
                auto d = std::lower_bound(start.begin(), start.end() - 1, low,
                                          [&](std::uint32_t i, const auto& wanted) { return points[i].cell < wanted; });
                for (; d != start.end() - 1 && points[*d].cell <= high; ++d)
                    join(c, static_cast<std::uint32_t>(static_cast<std::size_t>(d - start.begin())));
            }
    }
    for (std::uint32_t v = 0; v < first.size(); ++v) first[v] = sets.find(v);
    return first;
}

std::optional<std::string> unwelded_edges(const ControlMeshData& data, std::span<const std::uint32_t> twin) {
    struct Edge {
        std::uint32_t low, high;  // the positions of its ends
        std::uint32_t a, b;       // its ends in the direction of its face
        bool same_place(const Edge& other) const { return low == other.low && high == other.high; }
    };
    std::vector<Edge> edges;
    std::vector<std::uint32_t> ends;
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f)
        for (std::uint32_t h = data.face_offsets[f], end = data.face_offsets[f + 1]; h < end; ++h) {
            if (twin[h] != HalfedgeId::none) continue;
            edges.push_back({0, 0, data.face_vertices[h], data.face_vertices[next_corner(data, f, h)]});
            ends.push_back(edges.back().a);  // an edge starts at every boundary vertex
        }
    const std::vector<std::uint32_t> place = first_at_position(data.positions, std::move(ends));
    for (Edge& edge : edges) std::tie(edge.low, edge.high) = std::minmax(place[edge.a], place[edge.b]);
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
        return std::tie(x.low, x.high, x.a, x.b) < std::tie(y.low, y.high, y.a, y.b);
    });
    // Two edges at one position would become an interior edge. More edges, or two of the same direction, would not.
    std::vector<std::uint32_t> vertices;
    std::uint64_t unwelded = 0;
    for (std::size_t i = 0, count = 1; i < edges.size(); i += count) {
        for (count = 1; i + count < edges.size() && edges[i].same_place(edges[i + count]);) ++count;
        if (count != 2 || edges[i].low == edges[i].high || place[edges[i].a] == place[edges[i + 1].a]) continue;
        unwelded += 2;
        for (const Edge& edge : {edges[i], edges[i + 1]}) vertices.insert(vertices.end(), {edge.a, edge.b});
    }
    if (unwelded == 0 || unwelded * k_edges_to_one_unwelded < edges.size()) return std::nullopt;
    const auto distinct = [&] {
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        return vertices.size();
    };
    const std::size_t all = distinct();
    for (std::uint32_t& v : vertices) v = place[v];
    return fmt::format(
        "{} of {} boundary edges lie on one another, between {} vertices at {} places: faces side by side share no "
        "vertices, and the surface ends between them; --weld, or weld() in the library, joins them",
        unwelded, edges.size(), all, distinct());
}

}  // namespace tetrakis::detail
