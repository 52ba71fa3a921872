#pragma once

#include "../bounds/plane_measure.hpp"

#include <array>
#include <cmath>
#include <optional>

namespace tetrakis::detail {

/// The samples of a leaf on a barycentric lattice with N intervals a side (corner 2 first, rows parallel to the edge
/// corner 0 - corner 1) as a small mesh over the leaf's plane.
template <int N>
class SampleSheet {
  public:
    static constexpr int k_samples = (N + 1) * (N + 2) / 2;
    using Samples = std::array<Vec3d, k_samples>;

    /// @param plane  of the leaf; it must be flat()
    SampleSheet(const PlaneMeasure& plane, const Samples& samples) {
        for (int i = 0; i < k_samples; ++i)
            at_[static_cast<std::size_t>(i)] = plane.project(samples[static_cast<std::size_t>(i)]);
    }

    /// Distance from the plane of the sheet right above or below a point of the leaf; nothing where no part of it is.
    std::optional<double> height(double b1, double b2) const {
        for (int row = 0; row < N; ++row)
            for (int i = 0; i <= row; ++i) {
                const int a = row * (row + 1) / 2 + i, b = a + row + 1, c = b + 1;
                if (const auto h = over(a, b, c, b1, b2)) return h;
                if (i == row) continue;
                if (const auto h = over(a, c, a + 1, b1, b2)) return h;
            }
        return std::nullopt;
    }

  private:
    std::optional<double> over(int a, int b, int c, double b1, double b2) const {
        const PlaneMeasure::Projection &p = at_[static_cast<std::size_t>(a)], &q = at_[static_cast<std::size_t>(b)],
                                       &r = at_[static_cast<std::size_t>(c)];
        const double ux = q.b1 - p.b1, uy = q.b2 - p.b2, vx = r.b1 - p.b1, vy = r.b2 - p.b2;
        const double dx = b1 - p.b1, dy = b2 - p.b2, area = ux * vy - uy * vx;
        const double s = dx * vy - dy * vx, t = ux * dy - uy * dx;
        // Rows run from corner 2 away: corners a, b, c are counter-clockwise, unless the sheet folds there.
        if (!(area > 0) || s < 0 || t < 0 || s + t > area) return std::nullopt;
        return std::abs(p.height + (s * (q.height - p.height) + t * (r.height - p.height)) / area);
    }

    std::array<PlaneMeasure::Projection, k_samples> at_;
};

}  // namespace tetrakis::detail
