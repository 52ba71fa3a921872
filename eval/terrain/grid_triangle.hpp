#pragma once

#include "height_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tetrakis::detail {

/// A vertex of a terrain's mesh. Its place is in k_grid_unit-ths of a column and a row, so that all of it is exact.
struct GridVertex {
    std::int32_t x, y;
    float z;  ///< as files and graphics cards have it: errors hold for what they get
};
inline constexpr std::int32_t k_grid_unit = 64;
constexpr double in_samples(std::int32_t place) { return static_cast<double>(place) / k_grid_unit; }

/// The middle of two places of an axis: a sample, where there is one between them.
constexpr std::int32_t middle(std::int32_t a, std::int32_t b) {
    const std::int32_t low = std::min(a, b), width = std::max(a, b) - low;
    return width >= 2 * k_grid_unit ? low + width / (2 * k_grid_unit) * k_grid_unit : low + width / 2;
}

/// The vertex at a place, with the samples' height; between them it is bilinear.
inline GridVertex sampled(const HeightGrid& grid, std::int32_t x, std::int32_t y) {
    const auto column = static_cast<std::uint32_t>(x / k_grid_unit), row = static_cast<std::uint32_t>(y / k_grid_unit);
    const double s = double(x % k_grid_unit) / k_grid_unit, t = double(y % k_grid_unit) / k_grid_unit;
    const auto along = [&](std::uint32_t r) {
        const double first = grid.at(column, r);
        return s == 0 ? first : first + s * (double{grid.at(column + 1, r)} - first);
    };
    const double first = along(row);
    return {x, y, static_cast<float>(t == 0 ? first : first + t * (along(row + 1) - first))};
}

/// Samples of a height grid under one triangle, sides and corners included, against the plane over its corners.
class GridTriangle {
  public:
    /// Corners counter-clockwise on the ground, y to the south; they are not on one line.
    GridTriangle(const HeightGrid& grid, const std::array<GridVertex, 3>& corners) : grid_(grid), corners_(corners) {
        const auto& [a, b, c] = corners;
        const std::int64_t bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
        const double bz = double{b.z} - double{a.z}, cz = double{c.z} - double{a.z};
        inverse_area_ = k_grid_unit / static_cast<double>(bx * cy - cx * by);
        slope_x_ = (bz * static_cast<double>(cy) - cz * static_cast<double>(by)) * inverse_area_;
        slope_y_ = (cz * static_cast<double>(bx) - bz * static_cast<double>(cx)) * inverse_area_;
    }

    /// The largest distance of a sample from the plane, vertically; or the first one found that is more than `enough`.
    double error(double enough) const {
        double largest = 0;
        for_each_row([&](std::int32_t y, std::int32_t begin, std::int32_t end) {
            const float* const heights = row(y) + begin;
            const double plane = plane_at(begin, y);
            double above = 0, below = 0;
            for (std::int32_t i = 0; i < end - begin; ++i) {
                const double off = double{heights[i]} - (plane + slope_x_ * i);
                above = std::max(above, off);
                below = std::min(below, off);
            }
            largest = std::max({largest, above, -below});
            return largest <= enough;
        });
        return largest;
    }

    struct Interval {
        double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    };
    /// Keeps of an interval by how much corner k can be raised with samples within a limit; low > high: no height will
    /// do.
    /// @param least  weight of the corner in samples that count
    void narrow(Interval& interval, std::size_t k, double limit, double least) const {
        const GridVertex &p = corners_[(k + 1) % 3], &q = corners_[(k + 2) % 3];
        // The corner's barycentric: linear, 0 at the other two.
        const double dx = (p.y - q.y) * inverse_area_, dy = (q.x - p.x) * inverse_area_;
        for_each_row([&](std::int32_t y, std::int32_t begin, std::int32_t end) {
            const float* const heights = row(y) + begin;
            const double plane = plane_at(begin, y),
                         first = dx * (begin - in_samples(p.x)) + dy * (y - in_samples(p.y));
            for (std::int32_t i = 0; i < end - begin; ++i) {
                const double weight = first + dx * i, off = double{heights[i]} - (plane + slope_x_ * i);
                if (weight < least) continue;
                // Rarely true: no division for most samples.
                if (off - limit > interval.low * weight) interval.low = (off - limit) / weight;
                if (off + limit < interval.high * weight) interval.high = (off + limit) / weight;
            }
            return true;
        });
    }

  private:
    const float* row(std::int32_t y) const {
        return grid_.heights.data() + static_cast<std::size_t>(y) * grid_.columns;
    }
    double plane_at(std::int32_t x, std::int32_t y) const {
        const GridVertex& a = corners_[0];
        return double{a.z} + slope_x_ * (x - in_samples(a.x)) + slope_y_ * (y - in_samples(a.y));
    }

    /// Calls visit(row, first column, column after the last one) from north to south, until it returns false.
    template <class Visit>
    void for_each_row(const Visit& visit) const {
        const GridVertex *top = corners_.data(), *mid = top + 1, *low = top + 2;
        if (mid->y < top->y) std::swap(top, mid);
        if (low->y < mid->y) std::swap(mid, low);
        if (mid->y < top->y) std::swap(top, mid);
        // Samples this far beyond a side count, too, so that rounding misses none.
        constexpr double k_beyond = 1e-6;
        const double x0 = in_samples(top->x), y0 = in_samples(top->y), x1 = in_samples(mid->x), y1 = in_samples(mid->y),
                     x2 = in_samples(low->x), y2 = in_samples(low->y);
        const double run = (x2 - x0) / (y2 - y0), upper = y1 > y0 ? (x1 - x0) / (y1 - y0) : 0,
                     lower = y2 > y1 ? (x2 - x1) / (y2 - y1) : 0;
        const bool mid_is_right = x1 > x0 + run * (y1 - y0);
        const std::int32_t last = low->y / k_grid_unit;
        for (std::int32_t y = (top->y + k_grid_unit - 1) / k_grid_unit; y <= last; ++y) {
            const double across = x0 + run * (y - y0), beside = x1 + (y < y1 ? upper : lower) * (y - y1);
            const double left = (mid_is_right ? across : beside) - k_beyond,
                         right = (mid_is_right ? beside : across) + k_beyond;
            const auto whole = static_cast<std::int32_t>(left), end = static_cast<std::int32_t>(right) + 1;
            const std::int32_t begin = whole + (left > whole ? 1 : 0);
            if (begin < end && !visit(y, begin, end)) return;
        }
    }

    const HeightGrid& grid_;
    std::array<GridVertex, 3> corners_;
    double inverse_area_ = 0;           ///< of twice the triangle; negative, as y is to the south
    double slope_x_ = 0, slope_y_ = 0;  ///< of the plane, a column and a row
};

}  // namespace tetrakis::detail
