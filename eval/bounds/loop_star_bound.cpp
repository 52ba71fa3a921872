#include "loop_star_bound.hpp"

#include "../../schemes/rules/loop.hpp"
#include "box_spline_error.hpp"
#include "triangle_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

namespace tetrakis::detail {

namespace {

using Points = std::vector<Vec3d>;

/// The differences of a star, n + 6 of them.
template <class Out>
void differences(int n, const Vec3d* star, Out&& out) {
    const Vec3d& c = star[0];
    const Vec3d* ring = star + 1;
    const Vec3d* o = star + n + 1;  // (2,-1) (2,0) (1,1) (0,2) (-1,2)
    Vec3d before = ring[n - 1];
    for (int i = 0; i < n; ++i) {
        const Vec3d& after = ring[i + 1 == n ? 0 : i + 1];
        out(before + after - c - ring[i]);
        before = ring[i];
    }
    const Vec3d &a = ring[0], &b = ring[1], &a_before = ring[n - 1], &b_after = ring[n == 2 ? 0 : 2];
    const Vec3d a2 = 2.0 * a, b2 = 2.0 * b;
    out(c + o[1] - a2);
    out(b + o[0] - a2);
    out(o[2] + a_before - a2);
    out(c + o[3] - b2);
    out(a + o[4] - b2);
    out(o[2] + b_after - b2);
}

/// Linear functions of a star, in a fixed order; applied to unit stars they give their weights.
class StarFunctions {
  public:
    explicit StarFunctions(int valence) : n_(valence), beta_(Loop::beta(valence)) {}

    /// Differences two steps further down; then S - L at the samples; then three second derivatives of 4 coefficients
    /// each per piece.
    Points operator()(const Points& star) const {
        const Points first = step(star), second = step(first);
        Points out;
        differences(n_, second.data(), [&](const Vec3d& d) { out.push_back(d); });
        const std::array<Vec3d, 3> corner{loop_star_limit(n_, star.data()), regular_corner(star, 1),
                                          regular_corner(star, 2)};
        for (const auto& at : LoopStarBound::k_sample_at) {
            const Bary b{at[0] / 4.0, at[1] / 4.0, at[2] / 4.0};
            out.push_back(position(first, b) - (b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2]));
        }
        const std::array<Bary, 3> whole{Bary{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        const std::array<Bary, 3> mid{Bary{0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
        for (int quarter = 1; quarter <= 3; ++quarter) {
            const BoxSplineHessian near(loop_star_quarter(n_, second.data(), quarter));
            piece(near, whole, out);
            const BoxSplineHessian far(loop_star_quarter(n_, first.data(), quarter));
            piece(far, {whole[0], mid[0], mid[2]}, out);
            piece(far, {mid[0], whole[1], mid[1]}, out);
            piece(far, {mid[2], mid[1], whole[2]}, out);
            piece(far, {mid[1], mid[2], mid[0]}, out);
        }
        return out;
    }
    static constexpr int k_pieces = 15, k_per_edge = 4;

  private:
    Points step(const Points& star) const {
        Points out(static_cast<std::size_t>(loop_star_step_size(n_)));
        loop_star_step(n_, beta_, star.data(), out.data());
        return out;
    }
    /// Limit of a regular corner, from the quarter there.
    Vec3d regular_corner(const Points& star, int corner) const {
        return box_spline_corner(loop_star_quarter(n_, step(star).data(), corner), corner);
    }
    /// S at a point of the cell that is not inside the quarter at the centre's quarter.
    Vec3d position(const Points& first, const Bary& at) const {
        const Bary b = at;
        const int quarter = b[1] >= 0.5 ? 1 : b[2] >= 0.5 ? 2 : b[0] > 0.5 ? 0 : 3;
        Bary inside{2 * b[0], 2 * b[1], 2 * b[2]};
        if (quarter == 3)
            for (double& x : inside) x = 1 - x;
        else
            inside[quarter] -= 1;
        if (quarter == 0) return position(step(first), inside);
        return box_spline_position(loop_star_quarter(n_, first.data(), quarter), inside);
    }
    static void piece(const BoxSplineHessian& h, const std::array<Bary, 3>& at, Points& out) {
        const auto edges = edge_seconds(h, at);
        for (const EdgeSecond& e : edges) {
            for (const Vec3d& v : e.corner) out.push_back(v);
            out.push_back(e.along_edge);
        }
    }
    int n_;
    double beta_;
};

/// Symmetric positive definite systems of a few dozen unknowns.
class Cholesky {
  public:
    explicit Cholesky(std::vector<std::vector<double>> a) : l_(std::move(a)) {
        const std::size_t n = l_.size();
        for (std::size_t j = 0; j < n; ++j)
            for (std::size_t i = j; i < n; ++i) {
                double s = l_[i][j];
                for (std::size_t k = 0; k < j; ++k) s -= l_[i][k] * l_[j][k];
                l_[i][j] = i == j ? std::sqrt(s) : s / l_[j][j];
            }
    }
    std::vector<double> solve(std::vector<double> b) const {
        const std::size_t n = l_.size();
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t k = 0; k < i; ++k) b[i] -= l_[i][k] * b[k];
            b[i] /= l_[i][i];
        }
        for (std::size_t i = n; i-- > 0;) {
            for (std::size_t k = i + 1; k < n; ++k) b[i] -= l_[k][i] * b[k];
            b[i] /= l_[i][i];
        }
        return b;
    }

  private:
    std::vector<std::vector<double>> l_;
};

/// Weights on the points for each of a list of linear functions: [function][point].
template <class Functions>
std::vector<std::vector<double>> weights_of(int size, Functions&& functions) {
    std::vector<std::vector<double>> out;
    for (int i = 0; i < size; i += 3) {  // three unit stars at a time, one per coordinate
        Points unit(static_cast<std::size_t>(size), Vec3d(0));
        for (int k = 0; k < 3 && i + k < size; ++k) unit[static_cast<std::size_t>(i + k)][k] = 1;
        const Points values = functions(unit);
        out.resize(values.size(), std::vector<double>(static_cast<std::size_t>(size)));
        for (std::size_t f = 0; f < values.size(); ++f)
            for (int k = 0; k < 3 && i + k < size; ++k) out[f][static_cast<std::size_t>(i + k)] = values[f][k];
    }
    return out;
}

LoopStarBound make(int n) {
    const int size = loop_star_size(n);
    const auto count = static_cast<std::size_t>(size);
    const auto basis = weights_of(size, [&](const Points& star) {
        Points out;
        differences(n, star.data(), [&](const Vec3d& d) { out.push_back(d); });
        return out;
    });
    // The shortest combination w of the basis rows B that gives a function f that vanishes for equal points: w = B y
    // with (B^T B + 1 1^T) y = f.
    std::vector<std::vector<double>> gram(count, std::vector<double>(count, 1.0));
    for (const auto& row : basis)
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t j = 0; j < count; ++j) gram[i][j] += row[i] * row[j];
    const Cholesky solver(gram);
    std::vector<std::vector<double>> combine;  // basis rows times the inverse
    for (const auto& row : basis) combine.push_back(solver.solve(row));
    const auto norm = [&](const std::vector<double>& function) {
        double sum = 0;
        for (const auto& row : combine) {
            double w = 0;
            for (std::size_t i = 0; i < count; ++i) w += row[i] * function[i];
            sum += std::abs(w);
        }
        return sum;
    };

    const auto functions = weights_of(size, StarFunctions(n));
    std::size_t at = 0;
    double shrink = 0;
    for (std::size_t i = 0; i < basis.size(); ++i) shrink = std::max(shrink, norm(functions[at++]));
    LoopStarBound out;
    out.valence = n;
    out.weight.resize(count);
    double sampled = 0, sampled_inside = 0;
    for (int s = 0; s < LoopStarBound::k_samples; ++s) {
        const auto& row = functions[at++];
        for (std::size_t i = 0; i < count; ++i) out.weight[i][static_cast<std::size_t>(s)] = row[i];
        const double size_of = norm(row);
        sampled = std::max(sampled, size_of);
        if (s < 2) sampled_inside = std::max(sampled_inside, size_of);
    }
    for (int p = 0; p < StarFunctions::k_pieces; ++p) {
        std::array<double, 3> edge{};
        for (double& e : edge)
            for (int i = 0; i < StarFunctions::k_per_edge; ++i) e = std::max(e, norm(functions[at++]));
        out.around = std::max(out.around, triangle_deviation(edge[0], edge[1], edge[2]));
    }
    // For the rounding of all this; the constants themselves have errors of some 1e-14.
    constexpr double k_margin = 1 + 1e-10;
    out.around *= k_margin;
    // whole = max(sampled + around, sampled_inside + shrink whole).
    out.whole = shrink < 1 ? std::max(sampled + out.around, sampled_inside / (1 - shrink)) * k_margin
                           : std::numeric_limits<double>::infinity();
    out.inner = out.whole * shrink * k_margin;
    return out;
}

}  // namespace

double LoopStarBound::largest_difference(int valence, const Vec3d* star) {
    double largest = 0;
    differences(valence, star, [&](const Vec3d& d) { largest = std::max(largest, squared(d)); });
    return std::sqrt(largest);
}

std::array<Vec3d, LoopStarBound::k_samples> LoopStarBound::deviations(const Vec3d* star) const {
    std::array<Vec3d, k_samples> out;
    // Two samples at a time, and one axis: all sums stay in registers.
    using Pair = double __attribute__((vector_size(16)));
    using WeightPair = double __attribute__((vector_size(16), aligned(8), may_alias));
    static_assert(k_samples == 12);
    for (int axis = 0; axis < 3; ++axis) {
        Pair a{}, b{}, c{}, d{}, e{}, f{};
        for (std::size_t i = 0; i < weight.size(); ++i) {
            const Pair p{star[i][axis], star[i][axis]};
            const auto* w = reinterpret_cast<const WeightPair*>(weight[i].data());
            a += w[0] * p, b += w[1] * p, c += w[2] * p;
            d += w[3] * p, e += w[4] * p, f += w[5] * p;
        }
        const Pair sums[k_samples / 2] = {a, b, c, d, e, f};
        for (std::size_t s = 0; s < k_samples; ++s) out[s][axis] = sums[s / 2][s % 2];
    }
    return out;
}

namespace {

using Quarters = std::array<int, 3>;

/// Where medians cross edges between samples, in the middle of them.
struct Crossing {
    Quarters a, b;
};
constexpr std::array<Crossing, 6> k_crossings{{{{3, 1, 0}, {3, 0, 1}},
                                               {{1, 2, 1}, {1, 1, 2}},
                                               {{1, 3, 0}, {0, 3, 1}},
                                               {{2, 1, 1}, {1, 1, 2}},
                                               {{1, 0, 3}, {0, 1, 3}},
                                               {{2, 1, 1}, {1, 2, 1}}}};
constexpr std::array<Quarters, 3> k_corners{{{4, 0, 0}, {0, 4, 0}, {0, 0, 4}}};

}  // namespace

LoopStarBound::Part LoopStarBound::part(const Vec3d* star, const std::array<Bary, 3>& at,
                                        const std::array<Vec3d, 3>& deviation) const {
    const double m = largest_difference(valence, star);
    const std::array<Vec3d, k_samples> samples = deviations(star);
    // The linear interpolant of the whole cell's corners, minus L, at the part's corners: [i][j] is the sample (i, j,
    // .)
    std::array<std::array<Vec3d, 5>, 5> value;
    for (int s = 0; s < k_samples; ++s) value[k_sample_at[s][0]][k_sample_at[s][1]] = samples[s];
    for (const Quarters& c : k_corners) value[c[0]][c[1]] = Vec3d(0);
    std::array<Vec3d, 3> offset;
    for (std::size_t i = 0; i < 3; ++i)
        offset[i] =
            deviation[i] - value[static_cast<std::size_t>(4 * at[i][0])][static_cast<std::size_t>(4 * at[i][1])];
    // Coordinates in the part from those in the cell; all numbers are multiples of an eighth over a power of two.
    const double ux = at[1][0] - at[0][0], uy = at[1][1] - at[0][1], vx = at[2][0] - at[0][0], vy = at[2][1] - at[0][1],
                 scale = 1 / (ux * vy - uy * vx);
    Part part;
    part.around = around * m;
    part.inner = inner * m;
    const auto look = [&](double x, double y, const Vec3d& v, bool attained, bool near_centre) {
        const double dx = x - at[0][0], dy = y - at[0][1];
        const double b1 = scale * (dx * vy - dy * vx), b2 = scale * (ux * dy - uy * dx), b0 = 1 - b1 - b2;
        if (b0 < 0 || b1 < 0 || b2 < 0) return;
        part.points[static_cast<std::size_t>(part.count++)] = {
            {b0, b1, b2}, v + b0 * offset[0] + b1 * offset[1] + b2 * offset[2], attained, near_centre};
    };
    for (const Quarters& q : k_corners) look(0.25 * q[0], 0.25 * q[1], value[q[0]][q[1]], true, q[0] >= 3);
    for (const Quarters& q : k_sample_at) look(0.25 * q[0], 0.25 * q[1], value[q[0]][q[1]], true, q[0] >= 3);
    for (const auto& [a, b] : k_crossings)
        look(0.125 * (a[0] + b[0]), 0.125 * (a[1] + b[1]), 0.5 * (value[a[0]][a[1]] + value[b[0]][b[1]]), false,
             a[0] == 3);
    return part;
}

const LoopStarBound* LoopStarBound::of(int valence) {
    static std::array<std::once_flag, k_max_valence + 1> made;
    static std::array<LoopStarBound, k_max_valence + 1> tables;
    if (valence < 3 || valence > k_max_valence || valence % 6 == 0) return nullptr;
    const auto n = static_cast<std::size_t>(valence);
    std::call_once(made[n], [&] { tables[n] = make(valence); });
    return &tables[n];
}

}  // namespace tetrakis::detail
