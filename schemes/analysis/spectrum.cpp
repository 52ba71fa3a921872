#include "spectrum.hpp"

#include "../parts/dense_eigen.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

namespace tetrakis {

namespace {

using detail::Complex;
using detail::DenseMatrix;
using detail::eigenvalues;
using detail::left_eigenvector;

// Eigenvalues closer than this count as one.
constexpr double k_same = 1e-6;

/// Number of eigenvalues that are the same as this one.
int count_same(const std::vector<Complex>& values, Complex value) {
    return static_cast<int>(std::ranges::count_if(values, [&](Complex z) { return std::abs(z - value) < k_same; }));
}

/// The largest eigenvalue besides one that is 1.
Complex largest(const std::vector<Complex>& values, bool skip_one) {
    Complex best = 0;
    for (const Complex& z : values) {
        if (skip_one && std::abs(z - 1.0) < k_same) {
            skip_one = false;
            continue;
        }
        // Of two of the same size the real positive one.
        if (std::abs(z) > std::abs(best) + k_same || (std::abs(z) > std::abs(best) - k_same && z.real() > best.real()))
            best = z;
    }
    return best;
}

void add(SpectralAnalysis& analysis, const std::vector<Complex>& values, int frequency, int multiplicity) {
    for (const Complex& z : values) analysis.eigenvalues.push_back({z, frequency, multiplicity});
}

/// Scales a tangent to a largest weight of one; the sign is that of its first large weight.
void normalise(std::vector<double>& weights) {
    double most = 0;
    for (const double w : weights) most = std::max(most, std::abs(w));
    if (most == 0) return;
    for (double& w : weights) w /= most;
}

/// Takes the one nearest to a value out of a list.
void take_out(std::vector<double>& values, double taken) {
    const auto at = std::min_element(values.begin(), values.end(),
                                     [&](double a, double b) { return std::abs(a - taken) < std::abs(b - taken); });
    if (at != values.end()) values.erase(at);
}

/// @param bends  of a boundary: the eigenvalues, besides 1 and the tangent's, of what varies along it alone
void finish(SpectralAnalysis& analysis, bool interior, const std::vector<double>& bends) {
    auto& values = analysis.eigenvalues;
    std::stable_sort(values.begin(), values.end(), [](const Eigenvalue& a, const Eigenvalue& b) {
        return std::abs(a.value) > std::abs(b.value) + 1e-12;
    });
    // What is left when 1 and the tangents' two are taken out.
    std::vector<double> rest;
    for (const Eigenvalue& e : values)
        for (int i = 0; i < e.multiplicity; ++i) rest.push_back(std::abs(e.value));
    // A tangent without an eigenvalue takes none out.
    for (const double taken : {1.0, analysis.lambda1, analysis.lambda2})
        if (taken > 0) take_out(rest, taken);
    const auto most = [](const std::vector<double>& of) {
        return of.empty() ? 0 : *std::max_element(of.begin(), of.end());
    };
    analysis.third = most(rest);
    // The normal goes with Jacobians of pairs of modes. That of two which vary along the boundary alone is zero, so
    // these need be smaller than the first tangent only.
    for (const double bend : bends) take_out(rest, bend);
    const double smaller = std::min(analysis.lambda1, analysis.lambda2);
    analysis.proper = smaller > k_same && std::max(analysis.lambda1, analysis.lambda2) < 1 - k_same &&
                      most(rest) < smaller - k_same && most(bends) < analysis.lambda1 - k_same;
    if (!interior) return;
    const double square = analysis.lambda1 * analysis.lambda2;
    analysis.curvature = analysis.third < square - k_same   ? CurvatureClass::zero
                         : analysis.third > square + k_same ? CurvatureClass::unbounded
                                                            : CurvatureClass::bounded;
}

/// What some symmetries of the matrix, each of which is its own inverse, take to itself or change the sign of.
class SymmetricPart {
  public:
    struct Symmetry {
        std::vector<int> image;  ///< of each point
        double sign;
    };
    SymmetricPart(int size, const std::vector<Symmetry>& symmetries) : row_(size, -1), sign_(size, 0), orbit_(size, 1) {
        for (int i = 0; i < size; ++i) {
            if (sign_[i] != 0) continue;
            std::vector<int> orbit{i};
            sign_[i] = 1;
            bool vanishes = false;
            for (std::size_t k = 0; k < orbit.size(); ++k)
                for (const auto& [image, sign] : symmetries) {
                    const int from = orbit[k], to = image[from];
                    if (sign_[to] == 0) {
                        sign_[to] = sign * sign_[from];
                        orbit.push_back(to);
                    }
                    vanishes = vanishes || sign_[to] != sign * sign_[from];
                }
            if (vanishes) continue;
            for (const int j : orbit) row_[j] = row_count_, orbit_[j] = static_cast<int>(orbit.size());
            ++row_count_;
        }
    }
    /// Those points alone for which keep(point) is true, and it is so for all that symmetries make of it.
    template <class Keep>
    SymmetricPart only(Keep&& keep) const {
        SymmetricPart result = *this;
        std::vector<int> number(row_count_, -1);
        result.row_count_ = 0;
        for (std::size_t i = 0; i < row_.size(); ++i) {
            int& row = result.row_[i];
            if (row < 0) continue;
            if (!keep(static_cast<int>(i)))
                row = -1;
            else
                row = number[row] < 0 ? number[row] = result.row_count_++ : number[row];
        }
        return result;
    }
    /// Of a matrix of the points.
    DenseMatrix block(const StencilTable& weights) const {
        DenseMatrix m(row_count_);
        int done = 0;
        for (int i = 0; i < weights.row_count(); ++i) {
            if (row_[i] != done) continue;  // another point of the orbit has been there
            for (const auto& [j, weight] : weights.row(i).terms)
                if (row_[j] >= 0) m(done, row_[j]) += sign_[j] * weight;
            ++done;
        }
        return m;
    }
    /// The mask of all points that a block's left eigenvector is.
    std::vector<double> spread(const std::vector<Complex>& y) const {
        std::vector<double> weights(row_.size(), 0.0);
        for (std::size_t i = 0; i < weights.size(); ++i)
            if (row_[i] >= 0) weights[i] = sign_[i] * y[row_[i]].real() / orbit_[i];
        return weights;
    }

  private:
    int row_count_ = 0;
    std::vector<int> row_;      ///< of a block, per point; -1: none
    std::vector<double> sign_;  ///< against the first point of its orbit
    std::vector<int> orbit_;    ///< its size
};

std::vector<int> mirror_images(const FanLabels& labels) {
    std::vector<int> image;
    for (const FanLabel label : labels.all()) image.push_back(labels.find(labels.mirrored(label)));
    return image;
}

double real_or_zero(Complex z) { return std::abs(z.imag()) < k_same ? z.real() : 0; }

/// The largest mode of a part of some weights, and its left eigenvector where that is determined.
struct Mode {
    std::vector<Complex> values;  ///< of the whole part
    double value;
    std::vector<double> mask{};

    Mode(const SymmetricPart& part, const StencilTable& weights, bool skip_one = false) {
        const DenseMatrix block = part.block(weights);
        values = eigenvalues(block);
        const Complex lambda = largest(values, skip_one);
        value = real_or_zero(lambda);
        if (value > 0 && count_same(values, lambda) == 1) mask = part.spread(left_eigenvector(block, value));
    }
};

/// Two sectors: what changes its sign from one to the other is one mode for both tangents, which the mirror image tells
/// apart: the same on both sides of the line along the two edges (tangent 1), or of opposite sign (tangent 2).
void analyse_two_sectors(SpectralAnalysis& analysis) {
    const int size = analysis.matrix.size();
    std::vector<int> turned(size, 0);  // the centre stays, and each place has a point in either sector
    for (int i = 1; i < size; ++i) turned[i] = i % 2 != 0 ? i + 1 : i - 1;
    for (const double sign : {1.0, -1.0}) {
        const SymmetricPart part(size, {{turned, -1}, {mirror_images(analysis.matrix.labels), sign}});
        const Mode mode(part, analysis.matrix.rows);
        (sign > 0 ? analysis.lambda1 : analysis.lambda2) = mode.value;
        (sign > 0 ? analysis.tangent1 : analysis.tangent2) = mode.mask;
    }
}

/// Rotation-symmetric: one block per Fourier mode. A block's rows are the places of sector 0.
void analyse_rotation(SpectralAnalysis& analysis) {
    const LocalMatrix& s = analysis.matrix;
    const int n = s.labels.shape().faces, centre = s.labels.lattice() == FanLattice::dual ? 0 : 1;
    const int places = (s.size() - centre) / n;
    const auto index = [&](int place, int sector) { return centre + place * n + sector; };

    std::vector<Complex> wave(n);
    for (int t = 0; t < n; ++t) wave[t] = std::polar(1.0, 2 * std::numbers::pi * t / n);
    // Mode 0 has the centre, too.
    const auto block = [&](int j) {
        const int first = j == 0 ? centre : 0;
        DenseMatrix m(first + places);
        for (int p = -first; p < places; ++p)
            for (const auto& [point, weight] : s.row(p < 0 ? 0 : index(p, 0)).terms) {
                const int q = point < centre ? -1 : (point - centre) / n, ahead = q < 0 ? 0 : (point - centre) % n;
                if (q >= -first)
                    m(first + p, first + q) += wave[static_cast<std::size_t>(std::int64_t{j} * ahead % n)] * weight;
            }
        return m;
    };
    const DenseMatrix zero = block(0);
    add(analysis, eigenvalues(zero), 0, 1);
    const std::vector<Complex> limit = left_eigenvector(zero, 1);
    const double total = std::accumulate(limit.begin(), limit.end(), Complex(0)).real();
    analysis.limit.assign(s.size(), 0.0);
    if (centre == 1) analysis.limit[0] = limit[0].real() / total;
    for (int p = 0; p < places; ++p)
        for (int t = 0; t < n; ++t) analysis.limit[index(p, t)] = limit[centre + p].real() / total / n;

    for (int j = 1; 2 * j <= n; ++j) {
        const DenseMatrix mode = block(j);
        const std::vector<Complex> values = eigenvalues(mode);
        add(analysis, values, j, 2 * j < n ? 2 : 1);
        if (j == 1 && n == 2) analyse_two_sectors(analysis);
        if (j != 1 || n == 2) continue;
        const Complex lambda = largest(values, false);
        analysis.lambda1 = analysis.lambda2 = real_or_zero(lambda);
        if (count_same(values, lambda) != 1 || analysis.lambda1 <= 0) continue;
        std::vector<Complex> y = left_eigenvector(mode, lambda);
        // The first place is on the ray itself (dual: on the face's diagonal): make its weight real.
        int lead = 0;
        while (std::abs(y[lead]) < 1e-6) ++lead;
        const Complex turn = std::conj(y[lead]) / std::abs(y[lead]);
        for (Complex& z : y) z *= turn;
        analysis.tangent1.assign(s.size(), 0.0);
        analysis.tangent2.assign(s.size(), 0.0);
        for (int p = 0; p < places; ++p)
            for (int t = 0; t < n; ++t) {
                const Complex w = y[p] * std::conj(wave[t]);
                analysis.tangent1[index(p, t)] = w.real();
                analysis.tangent2[index(p, t)] = -w.imag();
            }
    }
}

bool on_boundary(const FanLabels& labels, int i) {
    const FanLabel label = labels.all()[i];
    if (labels.lattice() == FanLattice::dual || labels.lattice() == FanLattice::pentagons) return label.b == 0;
    return label.a == 0 || (label.b == 0 && (label.sector == 0 || label.sector == labels.shape().faces));
}

/// Whether the boundary's points come from the boundary's points alone.
bool depends_on_itself(const LocalMatrix& s) {
    for (int i = 0; i < s.size(); ++i) {
        if (!on_boundary(s.labels, i)) continue;
        for (const int j : s.rows.points(i))
            if (!on_boundary(s.labels, j)) return false;
    }
    return true;
}

/// Beside a dual scheme's boundary edge, where what is the same from row to row inwards stays so: it then maps to
/// itself, as do the differences from row to row.
struct Rows {
    StencilTable differences;  ///< as those of the matrix; of a point less the one before it in its column
    StencilTable columns;      ///< as those of the matrix; of the boundary's points, for the whole column
    std::vector<int> before;   ///< per label; -1 on the boundary
};

std::optional<Rows> rows_inwards(const LocalMatrix& s) {
    if (s.labels.lattice() != FanLattice::dual || !s.labels.shape().boundary) return std::nullopt;
    constexpr double k_rounding = 1e-12;
    Rows rows;
    for (const FanLabel l : s.labels.all()) rows.before.push_back(s.labels.find({l.sector, l.a, l.b - 1}));
    for (int i = 0; i < s.size(); ++i) {
        const int before = rows.before[i];
        StencilRow difference, column;
        for (int j = 0; j < s.size(); ++j) {
            const double weight = s.at(i, j) - (before < 0 ? 0 : s.at(before, j));
            // The point j is the sum of the differences up to it, and of the boundary's point.
            int k = j;
            for (; rows.before[k] >= 0; k = rows.before[k])
                if (before >= 0) difference.add(k, weight);
            column.add(k, weight);
        }
        rows.differences.push(std::move(difference));
        rows.columns.push(std::move(column));
        for (const double w : rows.columns.weights(i))
            if (before >= 0 && std::abs(w) > k_rounding) return std::nullopt;
    }
    return rows;
}

/// Mirror-symmetric: the even and the odd part. The result is what finish() takes as bends.
std::vector<double> analyse_mirror(SpectralAnalysis& analysis) {
    const LocalMatrix& s = analysis.matrix;
    const int size = s.size();
    const bool boundary = s.labels.shape().boundary;
    const std::vector<int> mirror = mirror_images(s.labels);
    const SymmetricPart even(size, {{mirror, 1}}), odd(size, {{mirror, -1}});
    Mode e(even, s.rows, true);
    add(analysis, e.values, 0, 1);
    add(analysis, eigenvalues(odd.block(s.rows)), 1, 1);
    analysis.limit = even.spread(left_eigenvector(even.block(s.rows), 1));
    const double total = std::accumulate(analysis.limit.begin(), analysis.limit.end(), 0.0);
    for (double& w : analysis.limit) w /= total;

    // A boundary runs from one side of the mirror to the other, a dart's crease along it. Where the boundary depends on
    // itself alone, the mode along it is the largest odd one of its own rules, whatever the inside does.
    const bool apart = boundary && depends_on_itself(s);
    const Mode o(apart ? odd.only([&](int i) { return on_boundary(s.labels, i); }) : odd, s.rows);
    // What varies along the boundary alone is no tangent across it, even where its eigenvalue is as large (u^2 beside
    // v^2, where the surface ends as an even function): that is the largest one of the differences across.
    std::vector<double> bends;
    if (const std::optional<Rows> inwards = rows_inwards(s)) {
        const auto is_outermost = [&](int i) { return inwards->before[i] < 0; };
        e = Mode(even.only([&](int i) { return !is_outermost(i); }), inwards->differences);
        // It is of differences: each counts against the point before it, too, which has a lower number.
        for (std::size_t i = 0; i < e.mask.size(); ++i)
            if (!is_outermost(static_cast<int>(i))) e.mask[inwards->before[i]] -= e.mask[i];
        for (const SymmetricPart* part : {&even, &odd})
            for (const Complex z : eigenvalues(part->only(is_outermost).block(inwards->columns)))
                bends.push_back(std::abs(z));
        take_out(bends, 1);
        take_out(bends, o.value);
    }
    analysis.lambda1 = boundary ? o.value : e.value;
    analysis.lambda2 = boundary ? e.value : o.value;
    analysis.tangent1 = boundary ? o.mask : e.mask;
    analysis.tangent2 = boundary ? e.mask : o.mask;
    return bends;
}

}  // namespace

std::string_view name(CurvatureClass curvature) {
    switch (curvature) {
        case CurvatureClass::bounded:
            return "bounded";
        case CurvatureClass::zero:
            return "zero";
        case CurvatureClass::unbounded:
            break;
    }
    return "unbounded";
}

SpectralAnalysis analyse(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options) {
    SpectralAnalysis analysis{.matrix = local_matrix(scheme, shape, options)};
    std::vector<double> bends;
    if (analysis.matrix.turns())
        analyse_rotation(analysis);
    else
        bends = analyse_mirror(analysis);
    finish(analysis, !shape.boundary, bends);
    // Two of the faces at the vertex; what those between do is not in the matrix.
    if (analysis.matrix.labels.lattice() == FanLattice::pentagons) analysis.proper = false;
    normalise(analysis.tangent1);
    normalise(analysis.tangent2);
    return analysis;
}

}  // namespace tetrakis
