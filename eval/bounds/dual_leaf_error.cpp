#include "dual_leaf_error.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/mesh_links.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../refine/adaptive/dual_charts.hpp"
#include "../triangles/point_triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrakis::detail {

namespace {

/// Per vertex its neighbours across edges that only one triangle has.
std::vector<std::array<std::uint32_t, 2>> boundary_neighbours(const DualFaces& faces, std::uint32_t vertex_count) {
    const auto edges = sorted_edge_uses(faces.face_offsets, faces.face_vertices, vertex_count);
    std::vector<std::array<std::uint32_t, 2>> beside(vertex_count);
    for (std::uint32_t v = 0; v < vertex_count; ++v) beside[v] = {v, v};
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end].same_edge(edges[i])) ++end;
        if (end == i + 1) {
            const std::uint32_t a = edges[i].low, b = edges[i].high;
            beside[a][beside[a][0] == a ? 0 : 1] = b;
            beside[b][beside[b][0] == b ? 0 : 1] = a;
        }
        i = end;
    }
    return beside;
}

/// Distance of the surface over a vertex's cell from the triangles around it, and along the boundary from the mesh's.
/// @param leaf    the vertex, or one of its sides where it is on a crease
/// @param points  limit points of the cells below it
double leaf_error(const VertexForest& forest, const DualTriangles& mesh, std::span<const Vec3d> positions,
                  std::uint32_t vertex, LeafId leaf, std::span<const Vec3d> points) {
    const std::uint32_t begin = mesh.around_begin[vertex], count = mesh.around_begin[vertex + std::size_t{1}] - begin;
    double most = 0;
    for (std::uint32_t nearest = 0; const Vec3d& p : points) {
        double squared = std::numeric_limits<double>::infinity();
        // A point's search ends at a triangle near enough not to raise the error. The next point is mostly near the
        // same triangle, so its search starts there.
        const std::uint32_t first = nearest;
        for (std::uint32_t i = 0; squared > most && i < count; ++i) {
            const std::uint32_t at = (first + i) % count;
            const auto t = mesh.triangle(mesh.around[begin + at]);
            const double found =
                nearest_on_triangle(p, positions[t[0]], positions[t[1]], positions[t[2]]).squared_distance;
            if (!(found < squared)) continue;
            squared = found;
            nearest = at;
        }
        most = std::max(most, squared);
    }
    double error = std::sqrt(most);
    // On sides where the surface ends, the samples along them are compared with the mesh's boundary.
    const std::uint32_t side = 1u << DualLeafErrors::k_bits;
    const auto point = [&](std::uint32_t x, std::uint32_t y) { return points[std::size_t{y} * side + x]; };
    for (int s = 0; s < 4; ++s) {
        if (forest.neighbours(leaf, s)[0].valid() || forest.across_crease(leaf, s).valid()) continue;
        for (std::uint32_t i = 0; i < side; ++i) {
            const Vec3d p = s == 0   ? point(i, 0)
                            : s == 1 ? point(side - 1, i)
                            : s == 2 ? point(i, side - 1)
                                     : point(0, i);
            double nearest = std::numeric_limits<double>::infinity();
            for (const std::uint32_t w : mesh.beside[vertex])
                nearest = std::min(nearest, segment_distance(p, positions[vertex], positions[w]));
            error = std::max(error, nearest);
        }
    }
    return error;
}

}  // namespace

void add_cells_below(const VertexCell& cell, int bits, std::vector<VertexCell>& cells) {
    const std::uint32_t side = 1u << bits;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x)
            cells.push_back({cell.root,
                             {(cell.at.x << bits) + x, (cell.at.y << bits) + y},
                             static_cast<std::uint8_t>(cell.level + bits)});
}

DualTriangles dual_triangles(const VertexForest& forest) {
    DualTriangles mesh;
    mesh.faces = forest.faces();
    DualFaces& faces = mesh.faces;
    // Triangles of a face follow each other in the cut mesh, two fewer than corners.
    const std::uint32_t vertices = mesh.vertex_count();
    const auto face_count = static_cast<std::uint32_t>(faces.control_faces.size());
    mesh.around_begin.assign(vertices + std::size_t{1}, 0);
    const auto size = [&](std::uint32_t f) { return faces.face_offsets[f + 1] - faces.face_offsets[f]; };
    for (std::uint32_t f = 0; f < face_count; ++f)
        for (std::uint32_t i = faces.face_offsets[f]; i < faces.face_offsets[f + 1]; ++i)
            mesh.around_begin[faces.face_vertices[i] + std::size_t{1}] += size(f) - 2;
    for (std::uint32_t v = 0; v < vertices; ++v) mesh.around_begin[v + std::size_t{1}] += mesh.around_begin[v];
    mesh.around.resize(mesh.around_begin[vertices]);
    std::vector<std::uint32_t> next(mesh.around_begin.begin(), mesh.around_begin.end() - 1);
    for (std::uint32_t f = 0, first = 0; f < face_count; first += size(f) - 2, ++f)
        for (std::uint32_t i = faces.face_offsets[f]; i < faces.face_offsets[f + 1]; ++i)
            for (std::uint32_t k = 0; k + 2 < size(f); ++k) mesh.around[next[faces.face_vertices[i]]++] = first + k;
    cut_into_triangles(faces);
    mesh.beside = boundary_neighbours(faces, vertices);
    return mesh;
}

std::vector<DualFaces::LeafOfVertex> DualTriangles::leaves() const {
    std::vector<DualFaces::LeafOfVertex> result = faces.other_sides;
    for (std::uint32_t v = 0; v < vertex_count(); ++v) result.push_back({v, faces.leaves[v]});
    return result;
}

void DualLeafErrors::evaluate(std::span<const VertexCell> cells, std::span<Vec3d> points,
                              const std::function<void(double)>& report) const {
    constexpr std::size_t k_block = 1u << 15;  // between two reports
    for (std::size_t begin = 0; begin < cells.size(); begin += k_block) {
        report(static_cast<double>(begin) / static_cast<double>(cells.size()));
        const std::size_t size = std::min(k_block, cells.size() - begin);
        limits_(cell_sites(cells.subspan(begin, size)), points.subspan(begin, size));
    }
}

std::vector<Vec3d> DualLeafErrors::positions(const VertexForest& forest, const DualTriangles& mesh,
                                             const std::function<void(double)>& report) const {
    std::vector<VertexCell> cells;
    for (const LeafId leaf : mesh.faces.leaves) cells.push_back(forest.cell(leaf));
    std::vector<Vec3d> positions(cells.size());
    evaluate(cells, positions, report);
    return positions;
}

std::vector<double> DualLeafErrors::errors(const VertexForest& forest, const DualTriangles& mesh,
                                           std::span<const Vec3d> positions,
                                           std::span<const DualFaces::LeafOfVertex> asked,
                                           const std::function<void(double)>& report) {
    constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    place_.resize(forest.leaf_slots(), k_none);
    const std::size_t known = points_.size();
    std::vector<VertexCell> fresh;
    for (const auto& [vertex, leaf] : asked) {
        if (place_[leaf.value] != k_none) continue;
        place_[leaf.value] = static_cast<std::uint32_t>((known + fresh.size()) / k_below);
        add_cells_below(forest.cell(leaf), k_bits, fresh);
    }
    points_.resize(known + fresh.size());
    evaluate(fresh, std::span(points_).subspan(known), report);
    std::vector<double> errors(asked.size());
    constexpr std::uint32_t k_grain = 64;
    for_each_index(
        static_cast<std::uint32_t>(asked.size()),
        [&](std::uint32_t i) {
            const auto& [vertex, leaf] = asked[i];
            errors[i] = leaf_error(forest, mesh, positions, vertex, leaf,
                                   std::span(points_).subspan(place_[leaf.value] * k_below, k_below));
        },
        k_grain);
    return errors;
}

}  // namespace tetrakis::detail
