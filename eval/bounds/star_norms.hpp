#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// How far the surface S of a cell at an extraordinary vertex is from its linear interpolant L over a triangle of the
/// cell: S - L is linear in the points around the cell, and zero where they are all one. So it is at most the sum over
/// the points of what each lies off an affine image of a reference star, times the largest its own weight in S - L
/// grows to; and what the reference star's own S - L is under that affine map. Norms depend on the valences alone.
class StarNorms {
  public:
    /// Norms are found at the first call, from any thread; null where a valence is less than 3 or more than 32.
    ///
    /// Of Catmull-Clark (QuadStar) there are eight triangles: half the cell at corner t (corners t, t + 1, t + 3) is
    /// number t, the quarter (corners: the cell's centre, t, t + 1) number 4 + t.
    static const StarNorms* catmull_clark(int valence, int far_valence);
    /// Of Loop (loop_star.hpp) there is one, the cell.
    static const StarNorms* loop(int valence);

    /// Upper bound on |S - L| over a triangle, L with the values of S at its corners; but for rounding.
    double deviation(std::span<const Vec3d> points, int triangle) const;

    /// @param deviations  (points, take) calls take(triangle, d) with vectors whose hulls hold S - L of a star with
    ///                    these points over each triangle
    template <class Deviations>
    StarNorms(std::vector<Vec2d> reference, std::size_t triangles, const Deviations& deviations);

  private:
    /// What a slot holds, which make() fills at the first call, from any thread.
    template <class Make>
    static const StarNorms* find_or_make(std::atomic<const StarNorms*>& slot, const Make& make) {
        if (const StarNorms* found = slot.load(std::memory_order_acquire)) return found;
        std::unique_ptr<const StarNorms> fresh = make();
        const StarNorms* expected = nullptr;
        return slot.compare_exchange_strong(expected, fresh.get(), std::memory_order_acq_rel) ? fresh.release()
                                                                                              : expected;
    }
    static constexpr double k_rounding_of_sums = 1 + 1e-12;  ///< of some dozens of points
    static void note(double& most, double size) { most = std::max(most, size * k_rounding_of_sums); }
    void find_fit();

    struct Triangle {
        std::vector<double> norm;        ///< by point
        double reference_deviation = 0;  ///< the reference star's S - L
    };
    std::vector<Vec2d> reference_;  ///< the reference star's points
    std::vector<Vec3d> fit_;        ///< weights of a star's points in its affine map
    std::vector<Triangle> triangles_;
};

template <class Deviations>
StarNorms::StarNorms(std::vector<Vec2d> reference, std::size_t triangles, const Deviations& deviations)
    : reference_(std::move(reference)), triangles_(triangles) {
    const std::size_t count = reference_.size();
    std::vector<Vec3d> points(count);
    for (Triangle& triangle : triangles_) triangle.norm.assign(count, 0);
    // The weights of three points at a time.
    for (std::size_t first = 0; first < count; first += 3) {
        for (std::size_t i = 0; i < count; ++i) points[i] = Vec3d(i == first, i == first + 1, i == first + 2);
        deviations(points, [&](std::size_t triangle, const Vec3d& d) {
            for (std::size_t k = 0; k < 3 && first + k < count; ++k)
                note(triangles_[triangle].norm[first + k], std::abs(d[static_cast<int>(k)]));
        });
    }
    for (std::size_t i = 0; i < count; ++i) points[i] = Vec3d(reference_[i], 0);
    deviations(points, [&](std::size_t triangle, const Vec3d& d) {
        note(triangles_[triangle].reference_deviation, glm::length(d));
    });
    find_fit();
}

}  // namespace tetrakis::detail
