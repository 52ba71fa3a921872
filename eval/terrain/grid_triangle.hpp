#pragma once

#include "height_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tetrakis::detail {

/// A vertex of a terrain's mesh. Coordinates are exact: integers, k_grid_unit to a column or a row.
struct GridVertex {
    std::int32_t x, y;
    float z;  ///< height in the precision of files and GPUs, so that errors hold for these
};

/// The middle of two grid coordinates. For samples at least two apart it is a sample: the middle one or that before it.
constexpr std::int32_t middle(std::int32_t a, std::int32_t b) {
    const std::int32_t low = std::min(a, b), width = std::max(a, b) - low;
    return width >= 2 * k_grid_unit ? low + width / (2 * k_grid_unit) * k_grid_unit : low + width / 2;
}

/// The vertex at (x, y); its height is bilinear between samples.
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

/// Compares the samples under one triangle, sides and corners included, with the plane through its corners.
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

    /// The largest vertical distance of a sample from the plane. The search ends after a row with one above `enough`.
    double error(double enough) const {
        double largest = 0;
        for_each_row([&](std::int32_t y, std::int32_t begin, std::int32_t end) {
            const float* const heights = row(y) + begin;
            const double plane = plane_at(begin, y);
            for (std::int32_t i = 0; i < end - begin; ++i)
                largest = std::max(largest, std::abs(double{heights[i]} - (plane + slope_x_ * i)));
            return largest <= enough;
        });
        return largest;
    }

    /// Prefetches the samples, for calls that follow some triangles later.
    void prefetch() const {
        // Only large triangles, which are few, have more rows.
        constexpr std::int32_t k_rows = 24;
        std::int32_t left = k_rows;
        for_each_row([&](std::int32_t y, std::int32_t begin, std::int32_t end) {
            __builtin_prefetch(row(y) + begin);
            __builtin_prefetch(row(y) + end - 1);
            return --left > 0;
        });
    }

    struct Interval {
        double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
        double gap() const { return low - high; }
        bool has(double value) const { return low <= value && value <= high; }
    };
    /// Narrows an interval to the raises of corner k that bring the samples within `limit`; low > high: there is none.
    /// Ends early if the gap is larger than `hopeless`.
    /// @param least  samples with a smaller weight of the corner are ignored
    void narrow(Interval& interval, std::size_t k, double limit, double least, double hopeless) const {
        const Weight corner = weight(k);
        for_each_row([&](std::int32_t y, std::int32_t begin, std::int32_t end) {
            const float* const heights = row(y) + begin;
            const double plane = plane_at(begin, y), first = corner.at(begin, y);
            for (std::int32_t i = 0; i < end - begin; ++i) {
                const double weight = first + corner.dx * i, off = double{heights[i]} - (plane + slope_x_ * i);
                if (weight < least) continue;
                // Rarely true: no division for most samples.
                if (off - limit > interval.low * weight) interval.low = (off - limit) / weight;
                if (off + limit < interval.high * weight) interval.high = (off + limit) / weight;
            }
            return interval.gap() <= hopeless;
        });
    }

    /// The part of `by` by which corner k can be raised (lowered, if negative) so that samples within `limit` stay so.
    double allowed(double by, std::size_t k, double limit) const {
        constexpr double k_least_weight = 0x1p-40;
        const auto& [a, b, c] = corners_;
        // A margin above the rounding error of a distance: samples are no higher than the corners plus the limit.
        limit -= 0x1p-40 * (limit + double{std::max({std::abs(a.z), std::abs(b.z), std::abs(c.z)})});
        const Weight corner = weight(k);
        const double sign = by < 0 ? -1 : 1;  // lowering is raising with all heights negated
        double reach = std::abs(by);
        for_each_row([&](std::int32_t y, std::int32_t begin, std::int32_t end) {
            const float* const heights = row(y) + begin;
            const double first = corner.at(begin, y), lowest = sign * plane_at(begin, y) - limit,
                         slope = sign * slope_x_;
            for (std::int32_t i = 0; i < end - begin; ++i) {
                const double weight = first + corner.dx * i, above = sign * double{heights[i]} - (lowest + slope * i);
                if (weight > k_least_weight && above < reach * weight) reach = std::max(0.0, above / weight);
            }
            return reach > 0;
        });
        return sign * reach;
    }

  private:
    /// A corner's barycentric coordinate: linear, 0 at the other two.
    struct Weight {
        double dx, dy, x, y;
        double at(std::int32_t column, std::int32_t row) const { return dx * (column - x) + dy * (row - y); }
    };
    Weight weight(std::size_t k) const {
        const GridVertex &p = corners_[(k + 1) % 3], &q = corners_[(k + 2) % 3];
        return {(p.y - q.y) * inverse_area_, (q.x - p.x) * inverse_area_, in_samples(p.x), in_samples(p.y)};
    }
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
        const auto rows_to = [](std::int32_t y) { return (y + k_grid_unit - 1) / k_grid_unit; };
        const std::int32_t first = rows_to(top->y), end = low->y / k_grid_unit + 1,
                           turn = mid->y < low->y ? rows_to(mid->y) : end;
        const bool mid_is_right =
            std::int64_t{mid->x - top->x} * (low->y - top->y) > std::int64_t{low->x - top->x} * (mid->y - top->y);
        const auto half = [&](const GridVertex* from, const GridVertex* to, std::int32_t y, std::int32_t until) {
            if (y >= until) return true;
            const Side across(*top, *low, y), beside(*from, *to, y);
            Side left = mid_is_right ? across : beside, right = mid_is_right ? beside : across;
            left.x += Side::k_column - 1 - Side::k_beyond;
            right.x += Side::k_column + Side::k_beyond;
            for (; y < until; ++y, left.x += left.step, right.x += right.step) {
                const auto begin = static_cast<std::int32_t>(left.x >> Side::k_bits),
                           behind = static_cast<std::int32_t>(right.x >> Side::k_bits);
                if (begin < behind && !visit(y, begin, behind)) return false;
            }
            return true;
        };
        if (half(top, mid, first, turn)) half(mid, low, turn, end);
    }

    /// Columns where a side crosses rows, as fixed-point numbers: they are computed early, since processors predict the
    /// ends of rows badly.
    struct Side {
        static constexpr int k_bits = 38;  // places are below 2^24
        static constexpr std::int64_t k_column = std::int64_t{1} << k_bits;
        /// Margin within which outside samples count, so that rounding misses none: 2^24 steps err by less than this.
        static constexpr std::int64_t k_beyond = k_column >> 13;
        Side(const GridVertex& from, const GridVertex& to, std::int32_t row) {
            const double slope = static_cast<double>(k_column) * (to.x - from.x) / (to.y - from.y);
            step = static_cast<std::int64_t>(slope);
            x = from.x * (k_column / k_grid_unit) + static_cast<std::int64_t>(slope * (row - in_samples(from.y)));
        }
        std::int64_t x, step;
    };

    const HeightGrid& grid_;
    std::array<GridVertex, 3> corners_;
    double inverse_area_ = 0;           ///< 1 / (twice the triangle's area); negative, as y is to the south
    double slope_x_ = 0, slope_y_ = 0;  ///< the plane's rise per column and per row
};

}  // namespace tetrakis::detail
