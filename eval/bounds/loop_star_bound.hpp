#pragma once

#include "../surface/loop_star.hpp"

#include <array>
#include <vector>

namespace tetrakis::detail {

/// What bounds S - L over a whole star cell, L the linear interpolant of the limits of its corners, from its control
/// points alone: one table per valence.
///
/// S - L at 12 lattice points (quarters of the edges) is a fixed combination of the points. Between the samples it is
/// held by the largest difference M of the star: of the flaps around the centre (p_(i-1) + p_(i+1) - c - p_i) and of
/// the second differences through the two regular corners. Everything that vanishes for equal points is a combination
/// of these; its size is then at most M times the sum of the weights' absolute values. The constants come out of the
/// bound for regular pieces (triangle_deviation) with that sum as the norm; close to the centre, where no end of pieces
/// would be needed, from the factor by which the differences shrink in two steps.
struct LoopStarBound {
    static constexpr int k_samples = 12;
    /// Barycentric coordinates of the samples, times 4. The first two are next to the centre.
    static constexpr std::array<std::array<int, 3>, k_samples> k_sample_at{{{3, 1, 0},
                                                                            {3, 0, 1},
                                                                            {2, 2, 0},
                                                                            {2, 1, 1},
                                                                            {2, 0, 2},
                                                                            {1, 3, 0},
                                                                            {1, 2, 1},
                                                                            {1, 1, 2},
                                                                            {1, 0, 3},
                                                                            {0, 3, 1},
                                                                            {0, 2, 2},
                                                                            {0, 1, 3}}};
    /// Those in the middles of edges 0, 1, 2.
    static constexpr std::array<std::size_t, 3> k_middles{2, 10, 4};
    /// Those in each quarter (at most six; repeated).
    static constexpr std::array<std::array<std::size_t, 6>, 4> k_in_quarter{
        {{0, 1, 2, 3, 4, 4}, {2, 5, 6, 9, 10, 10}, {4, 7, 8, 10, 11, 11}, {2, 3, 4, 6, 7, 10}}};
    int valence = 0;
    std::vector<std::array<double, k_samples>> weight;  ///< [point][sample]
    double whole = 0;                                   ///< |S - L| <= whole M
    double around = 0;  ///< |S - L| <= the largest sample + around M, but for the quarter's quarter at the centre
    double inner = 0;   ///< there |S - L| <= the larger of the first two samples + inner M

    /// M of a star. O(valence).
    static double largest_difference(int valence, const Vec3d* star);
    /// S - L at the samples.
    std::array<Vec3d, k_samples> deviations(const Vec3d* star) const;
    /// A part of the cell that lines between the samples and medians bound (a half, or a half of it): the corners of
    /// the linear pieces that the samples make of S - L over it.
    struct Part {
        struct Point {
            Bary at;  ///< in the part
            Vec3d deviation;
            bool attained;  ///< a sample, so that S - L is known there
            bool near_centre;
        };
        std::array<Point, 3 + k_samples + 6> points;
        int count = 0;
        double around = 0;  ///< S - L differs from the linear pieces by at most this, but for the centre's quarter
        double inner = 0;   ///< there, from a linear piece through the points near the centre
    };
    /// @param at         the part's corners, samples or corners of the cell
    /// @param deviation  S - L there
    Part part(const Vec3d* star, const std::array<Bary, 3>& at, const std::array<Vec3d, 3>& deviation) const;
    /// The table of a valence, made at the first call; null where there is none: above k_max_valence, and for multiples
    /// of 6, whose flaps vanish for a ring that goes round more than once. Any thread.
    static const LoopStarBound* of(int valence);
    static constexpr int k_max_valence = 20;
};

}  // namespace tetrakis::detail
