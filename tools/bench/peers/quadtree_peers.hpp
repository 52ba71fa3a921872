#pragma once

#include <cmath>
#include <cstdint>
#include <memory>

// The same benchmarks by p4est: quadtrees on a cube, and a moving target.
namespace tetrakis::bench {

inline constexpr int k_finest_level = 12;  // of a quadtree on the unit square

struct TargetPoint {
    double x = 0, y = 0;
};

/// A target that moves on a circle in the unit square.
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
/// Time and result of one run of p4est.
struct QuadtreeRun {
    double seconds = 0;
    std::int64_t squares = 0;
};

/// Refines all faces of a cube to the level with p4est on one rank, balanced across sides.
/// @param neighbours  also find the leaves across each side (as p4est_mesh)
QuadtreeRun run_p4est(int level, bool neighbours);

/// A quadtree on one rank, balanced across sides, whose squares are as large as they are far from the target.
struct MovingTargetPeer {
    virtual ~MovingTargetPeer() = default;
    /// Coarsens and refines by one level, balances, partitions. The first call refines from the root.
    /// @return  number of families of four that were created or merged
    virtual std::int64_t move(const TargetPoint& target) = 0;
    virtual std::int64_t leaf_count() const = 0;
    virtual bool is_balanced() const = 0;
};
std::unique_ptr<MovingTargetPeer> make_p4est_target();
#endif

}  // namespace tetrakis::bench
