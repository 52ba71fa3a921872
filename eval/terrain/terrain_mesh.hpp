#pragma once

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"
#include "height_grid.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetrakis {

struct TerrainOptions {
    double max_error = 1;  ///< the largest vertical distance of a sample from the mesh, in the heights' unit; from 0 on
    bool y_up = false;     ///< y is the height, z runs to the south, as engines have it; otherwise z is the height
    bool normals = false;  ///< one a vertex: the mean of its triangles' normals by their areas
    /// Tiles across and down: no triangle crosses their borders, which lie on samples. Their sizes differ by one sample
    /// at most.
    std::array<std::uint32_t, 2> tiles{1, 1};
    RunContext context{};
};

/// A terrain's mesh, and how far the grid's samples are from it.
struct Terrain {
    /// Vertices at (x to the east, y to the north, height): x = origin.x + column * spacing.x, y = origin.y - row *
    /// spacing.y. Heights are numbers that single precision has. Counter-clockwise from above, without cracks.
    TriangleMesh mesh;
    double largest_error = 0;  ///< of all samples, vertically: at most max_error
    /// Tile t has triangles first_triangle[t] to first_triangle[t + 1]. Tiles are numbered from west to east, then from
    /// north to south.
    std::vector<std::uint32_t> first_triangle;
};

/// A mesh of a height grid with few triangles: every sample is within max_error of it, vertically. A restricted 4-8
/// bisection hierarchy is refined until that holds with the samples' own heights; then its diamonds are merged where
/// the heights of their corners can be moved so that it still does. The same mesh for any number of threads.
/// @throws Error  invalid_input: fewer than two columns or rows, sizes that do not match, a height that is missing
///                (fill_missing_heights()) or infinite, a tolerance that is negative or no number, no tiles or more of
///                them than there are intervals between samples; unsupported: more than 2^24 columns or rows;
///                memory_limit; cancelled
/// Cost: O(samples * log samples) where the tolerance asks for the finest triangles; memory: the grid's and 200 bytes a
/// triangle before merging.
Terrain terrain_mesh(const HeightGrid& grid, const TerrainOptions& options = {});

/// One tile as a mesh of its own. Vertices that it shares with other tiles have the same positions and normals there,
/// bit by bit. O(triangles of the tile * log)
/// @pre tile + 1 < terrain.first_triangle.size()
TriangleMesh terrain_tile(const Terrain& terrain, std::size_t tile);

}  // namespace tetrakis
