#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

// Which squares of a cube's surface are cut in four: the same question, put to two quadtrees with frames of their own.
namespace tetrakis::bench {

using CubePoint = std::array<std::int64_t, 3>;

/// Edge of the cube [0, k_cube_edge]^3: squares down to level 28 have an even edge, so that centres are whole numbers.
inline constexpr std::int64_t k_cube_edge = std::int64_t{1} << 29;

/// A square region of the surface: its lower corner, and the directions of its axes (unit vectors).
struct SquareFrame {
    CubePoint corner, x, y;
};

/// Of a face of the unit cube, from its lower corner and the corners beside it.
inline SquareFrame face_frame(const CubePoint& corner, const CubePoint& beside_x, const CubePoint& beside_y) {
    SquareFrame frame{corner, beside_x, beside_y};
    for (std::size_t k = 0; k < 3; ++k) {
        frame.x[k] -= corner[k];
        frame.y[k] -= corner[k];
        frame.corner[k] *= k_cube_edge;
    }
    return frame;
}

/// A linear function over a frame, so that asking costs a few integer operations whoever asks.
struct FramePattern {
    std::int64_t value = 0, along_x = 0, along_y = 0;
    /// Whether the closed rectangle of this size, with this lower corner, has a zero of the function.
    bool wants(std::int64_t u, std::int64_t v, std::int64_t width, std::int64_t height) const {
        const std::int64_t low = value + along_x * u + along_y * v;
        const std::int64_t smallest =
            low + width * std::min<std::int64_t>(along_x, 0) + height * std::min<std::int64_t>(along_y, 0);
        const std::int64_t largest =
            low + width * std::max<std::int64_t>(along_x, 0) + height * std::max<std::int64_t>(along_y, 0);
        return (smallest <= 0) & (largest >= 0);
    }
    bool wants(std::int64_t u, std::int64_t v, std::int64_t edge) const { return wants(u, v, edge, edge); }
};

/// Squares are cut down to `level` (of a whole face of the cube) everywhere, or where a tilted plane meets them.
struct CubePattern {
    int level = 0;
    bool everywhere = false;

    FramePattern in(const SquareFrame& frame) const {
        if (everywhere) return {};
        // Through all six faces, in a slope that no lattice has, just beside the centre.
        constexpr CubePoint k_normal{523, 811, 1009};
        constexpr std::int64_t k_beside = 12345;
        const auto dot = [&](const CubePoint& p) {
            return k_normal[0] * p[0] + k_normal[1] * p[1] + k_normal[2] * p[2];
        };
        return {dot(frame.corner) - dot({k_cube_edge / 2, k_cube_edge / 2, k_cube_edge / 2}) - k_beside, dot(frame.x),
                dot(frame.y)};
    }
};

#ifdef TETRAKIS_BENCH_P4EST
/// What one run of p4est took and made.
struct QuadtreeRun {
    double seconds = 0;
    std::int64_t squares = 0;
};

/// p4est on one rank: refine, then balance across sides.
/// @param neighbours  find the leaves across sides, too (as p4est_mesh)
QuadtreeRun run_p4est(const CubePattern& pattern, bool neighbours);
#endif

}  // namespace tetrakis::bench
