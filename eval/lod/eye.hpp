#pragma once

#include "../../hier/base/vec.hpp"
#include "candidates.hpp"
#include "view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tetrakis::detail {

/// As glm::abs(), but without branches.
inline Vec3d absolute(const Vec3d& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

/// Camera data for the decisions about splits and merges.
struct Eye {
    Vec3d at{}, forward{0, 1, 0}, right{1, 0, 0}, up{0, 0, 1};
    std::array<std::array<double, 4>, 3> sides{};  ///< by axis: unit normals of the frustum's sides, to the inside
    double side_sin = 0, side_cos = 1;             ///< of half the horizontal field of view
    double above_sin = 0, above_cos = 1;           ///< of half the vertical one
    double pixels = 0;                             ///< size on screen of length 1 at distance 1

    explicit Eye(const lod::Camera& camera) : at(camera.eye), forward(unit(camera.direction)) {
        right = glm::cross(forward, unit(camera.up));
        if (!(glm::length(right) > 1e-9))
            right = glm::cross(forward, std::abs(forward.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0));
        right = glm::normalize(right);
        up = glm::cross(right, forward);
        const double y = std::tan(camera.vertical_fov / 2), x = y * camera.width / camera.height;
        pixels = camera.height / (2 * y);
        side_cos = 1 / std::hypot(1, x), side_sin = x * side_cos;
        above_cos = 1 / std::hypot(1, y), above_sin = y * above_cos;
        const std::array normals{side_sin * forward + side_cos * right, side_sin * forward - side_cos * right,
                                 above_sin * forward + above_cos * up, above_sin * forward - above_cos * up};
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t k = 0; k < normals.size(); ++k) sides[axis][k] = normals[k][axis];
    }
    /// Unit vector along `v`, without overflow or underflow for long or short ones.
    static Vec3d unit(const Vec3d& v) {
        return glm::normalize(v / std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
    }
    /// How far a box reaches inward from the side plane where this is least; negative: outside. `center`: from the eye.
    double inside(const Vec3d& center, const Vec3d& half_sides) const {
        std::array<double, 4> inward{}, extent{};
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t k = 0; k < inward.size(); ++k) {
                inward[k] += center[axis] * sides[axis][k];
                extent[k] += half_sides[axis] * std::abs(sides[axis][k]);
            }
        return std::min(std::min(inward[0] + extent[0], inward[1] + extent[1]),
                        std::min(inward[2] + extent[2], inward[3] + extent[3]));
    }
    bool has_opening_of(const Eye& other) const {
        return side_sin == other.side_sin && above_sin == other.above_sin && pixels == other.pixels;
    }
    /// Angle of the rotation between both cameras, in radians.
    double turn_to(const Eye& other) const {
        const Vec3d f = other.forward - forward, r = other.right - right, u = other.up - up;
        return 2 * std::asin(std::min(1.0, std::sqrt((glm::dot(f, f) + glm::dot(r, r) + glm::dot(u, u)) / 8)));
    }
};

/// Accumulated motion of a camera. Odometer 0 sums up its travel. Each other odometer has a length and sums up
/// travel + length * turn: the motion of points at that distance, relative to the camera.
class Odometers {
  public:
    static constexpr std::size_t k_travel = 0;

    /// @param extent  size of the surface that the camera looks at
    explicit Odometers(double extent) : extent_(extent > 0 ? extent : 1) {
        for (std::size_t i = 1; i < lengths_.size(); ++i)
            lengths_[i] = extent_ * std::exp2(static_cast<double>(i) / 2 + k_lowest);
        readings_.fill(k_start * extent_);
    }

    double reading(std::size_t odometer) const { return readings_[odometer]; }
    void move(double travel, double turn, Candidates& candidates) {
        if (travel == 0 && turn == 0) return;
        // Beyond this end a reading has too few digits left for short distances.
        if (!(readings_.back() + travel < k_end * extent_)) {
            readings_.fill(k_start * extent_);
            return candidates.restart(k_start * extent_);
        }
        for (std::size_t i = 0; i < readings_.size(); ++i) {
            // Larger even where the motion is less than the reading's last digit.
            readings_[i] = std::nextafter(readings_[i] + travel + lengths_[i] * turn, 2 * k_end * extent_);
            candidates.advance(i, readings_[i]);
        }
    }

    /// The odometer for points at distances up to `reach`: the one with the next larger length, if there is one.
    std::size_t at(double reach) const {
        constexpr int k_last = Candidates::k_odometers - 1;
        // Lengths grow by a factor of sqrt(2). Rounding does no harm: way() holds for any odometer.
        const int octave = 2 * (exponent_of(std::max(reach / extent_, 1e-300)) - k_lowest);
        if (octave >= k_last) return k_last;
        if (octave < 1) return 1;
        const auto i = static_cast<std::size_t>(octave);
        return i + (lengths_[i] < reach) + (i + 1 < k_last && lengths_[i + 1] < reach);
    }
    /// How far that odometer may advance before a point at distance `reach` or less can have moved by `gap` relative to
    /// the camera. Such a point moves by the travel plus turn times distance, and travel increases the distance: by at
    /// most (w + w^2 / (4 m)) m / length while the odometer advances by w, where m = max(reach, length).
    double way(std::size_t odometer, double gap, double reach) const {
        const double length = lengths_[odometer], m = std::max(reach, length);
        return 2 * m * (std::sqrt(1 + gap * length / (m * m)) - 1);
    }

  private:
    static constexpr int k_lowest = -14;  // lengths are multiples of 2^k_lowest extents
    // In extents. As readings do not start at 0, their exponents stay equal for long: few of the digits change by which
    // candidates are sorted.
    static constexpr double k_start = 16, k_end = 1 << 24;

    double extent_;
    std::array<double, Candidates::k_odometers> lengths_{}, readings_{};
};

}  // namespace tetrakis::detail
