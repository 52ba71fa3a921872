#pragma once

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"
#include "height_grid.hpp"

#include <cstdint>

namespace tetrakis {

struct TerrainOptions {
    double max_error = 1;  ///< the largest vertical distance of a sample from the mesh, in the heights' unit; from 0 on
    bool y_up = false;     ///< y is the height, z runs to the south, as engines have it; otherwise z is the height
    RunContext context{};
};

/// A terrain's mesh, and how far the grid's samples are from it.
struct Terrain {
    /// Vertices at (x to the east, y to the north, height): x = origin.x + column * spacing.x, y = origin.y - row *
    /// spacing.y. Heights are numbers that single precision has. Counter-clockwise from above, without cracks.
    TriangleMesh mesh;
    double largest_error = 0;  ///< of all samples, vertically: at most max_error
};

/// A mesh of a height grid with few triangles: every sample is within max_error of it, vertically. A restricted 4-8
/// bisection hierarchy is refined until that holds with the samples' own heights; then its diamonds are merged where
/// the heights of their corners can be moved so that it still does. The same mesh for any number of threads.
/// @throws Error  invalid_input: fewer than two columns or rows, sizes that do not match, a height that is missing
///                (fill_missing_heights()) or infinite, a tolerance that is negative or no number; unsupported: more
///                than 2^24 columns or rows; memory_limit; cancelled
/// Cost: O(samples * log samples) where the tolerance asks for the finest triangles; memory: the grid's and 200 bytes a
/// triangle before merging.
Terrain terrain_mesh(const HeightGrid& grid, const TerrainOptions& options = {});

}  // namespace tetrakis
