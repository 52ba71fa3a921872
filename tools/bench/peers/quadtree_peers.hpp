#pragma once

#include <cmath>
#include <cstdint>
#include <memory>

// What p4est does of the same: quadtrees on a cube, and a moving target.
namespace tetrakis::bench {

inline constexpr int k_finest_level = 12;  // of a quadtree on the unit square

struct TargetPoint {
    double x = 0, y = 0;
};

/// On a circle in the unit square.
struct MovingTarget {
    double step = 0;  ///< length of the way from one frame to the next
    double angle = 0;
    TargetPoint next() {
        constexpr double k_radius = 0.25;
        angle += step / k_radius;
        return {0.5 + k_radius * std::cos(angle), 0.5 + k_radius * std::sin(angle)};
    }
};

#ifdef TETRAKIS_BENCH_P4EST
/// What one run of p4est took and made.
struct QuadtreeRun {
    double seconds = 0;
    std::int64_t squares = 0;
};

/// p4est on one rank: all faces of a cube refined to the level, balanced across sides.
/// @param neighbours  find the leaves across sides, too (as p4est_mesh)
QuadtreeRun run_p4est(int level, bool neighbours);

/// A quadtree on one rank, with squares as large as they are far from the target, balanced across sides.
struct MovingTargetPeer {
    virtual ~MovingTargetPeer() = default;
    /// Coarsens and refines by one level, balances, partitions. The first call refines from the root.
    /// @return  families of four that were made or merged
    virtual std::int64_t move(const TargetPoint& target) = 0;
    virtual std::int64_t leaf_count() const = 0;
    virtual bool is_balanced() const = 0;
};
std::unique_ptr<MovingTargetPeer> make_p4est_target();
#endif

}  // namespace tetrakis::bench
