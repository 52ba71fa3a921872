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
    double max_error = 1;  ///< largest vertical distance of a sample from the mesh, in the heights' unit; 0 or more
    bool y_up = false;     ///< y is the height and z runs to the south, as in game engines; otherwise z is the height
    bool normals = false;  ///< one normal a vertex: the area-weighted mean of its triangles' normals
    /// Numbers of tiles across and down. No triangle crosses the tiles' borders, which lie on samples. Sizes of tiles
    /// differ by at most one sample.
    std::array<std::uint32_t, 2> tiles{1, 1};
    RunContext context{};
};

/// A terrain's mesh, and the largest distance of the grid's samples from it.
struct Terrain {
    /// Vertices at (x to the east, y to the north, height): x = origin.x + column * spacing.x, y = origin.y - row *
    /// spacing.y. Heights are single-precision numbers. Counter-clockwise from above, without cracks.
    TriangleMesh mesh;
    double largest_error = 0;  ///< of all samples, vertically: at most max_error
    /// Tile t has triangles first_triangle[t] to first_triangle[t + 1]. Tiles are numbered from west to east, then from
    /// north to south.
    std::vector<std::uint32_t> first_triangle;
};

/// A mesh of a height grid with few triangles: every sample is within max_error of it, vertically. A restricted 4-8
/// bisection hierarchy is refined until this holds with the samples' own heights. Then diamonds are merged where it
/// still holds after a move of their corners' heights. The mesh is the same for any number of threads.
/// @throws Error  invalid_input: fewer than two columns or rows, sizes that do not match, a height that is missing
///                (fill_missing_heights()) or infinite, a tolerance that is negative or no number, no tiles or more of
///                them than there are intervals between samples; unsupported: more than 2^24 columns or rows;
///                memory_limit; cancelled
/// Cost: O(samples * log samples) if the tolerance needs the finest triangles; memory: the grid's, and 200 bytes for
/// each triangle before merging.
Terrain terrain_mesh(const HeightGrid& grid, const TerrainOptions& options = {});

/// One tile as a separate mesh. Vertices that tiles share have bitwise equal positions and normals in each of them.
/// O(n log n) for n triangles of the tile.
/// @pre tile + 1 < terrain.first_triangle.size()
TriangleMesh terrain_tile(const Terrain& terrain, std::size_t tile);

}  // namespace tetrakis
