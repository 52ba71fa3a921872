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

/// Number of eigenvalues that are nearer than k_same to `value`.
int count_same(const std::vector<Complex>& values, Complex value) {
    return static_cast<int>(std::ranges::count_if(values, [&](Complex z) { return std::abs(z - value) < k_same; }));
}

/// The eigenvalue of largest magnitude; with `skip_one`, one that equals 1 is left out.
Complex largest(const std::vector<Complex>& values, bool skip_one) {
    Complex best = 0;
    for (const Complex& z : values) {
        if (skip_one && std::abs(z - 1.0) < k_same) {
            skip_one = false;
            continue;
        }
        // Of eigenvalues of the same magnitude, the one with the largest real part.
        if (std::abs(z) > std::abs(best) + k_same || (std::abs(z) > std::abs(best) - k_same && z.real() > best.real()))
            best = z;
    }
    return best;
}

void add(SpectralAnalysis& analysis, const std::vector<Complex>& values, int frequency, int multiplicity) {
    for (const Complex& z : values) analysis.eigenvalues.push_back({z, frequency, multiplicity});
}

/// Scales a tangent so that its largest weight has magnitude one; the signs stay.
void normalise(std::vector<double>& weights) {
    double most = 0;
    for (const double w : weights) most = std::max(most, std::abs(w));
    if (most == 0) return;
    for (double& w : weights) w /= most;
}

/// Removes the value that is nearest to `taken`.
void take_out(std::vector<double>& values, double taken) {
    const auto at = std::min_element(values.begin(), values.end(),
                                     [&](double a, double b) { return std::abs(a - taken) < std::abs(b - taken); });
    if (at != values.end()) values.erase(at);
}

/// @param bends  magnitudes of the eigenvalues, without 1 and lambda1, of modes that vary along a boundary alone
void finish(SpectralAnalysis& analysis, bool interior, const std::vector<double>& bends) {
    auto& values = analysis.eigenvalues;
    std::stable_sort(values.begin(), values.end(), [](const Eigenvalue& a, const Eigenvalue& b) {
        return std::abs(a.value) > std::abs(b.value) + 1e-12;
    });
    // Magnitudes of all eigenvalues but 1 and the tangents' two.
    std::vector<double> rest;
    for (const Eigenvalue& e : values)
        for (int i = 0; i < e.multiplicity; ++i) rest.push_back(std::abs(e.value));
    // A tangent without a real positive eigenvalue removes none.
    for (const double taken : {1.0, analysis.lambda1, analysis.lambda2})
        if (taken > 0) take_out(rest, taken);
    const auto most = [](const std::vector<double>& of) {
        return of.empty() ? 0 : *std::max_element(of.begin(), of.end());
    };
    analysis.third = most(rest);
    // The limit normal depends on Jacobians of pairs of modes. The Jacobian of two modes that vary along the boundary
    // alone is zero, so such modes need only be smaller than lambda1.
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

/// The vectors that each given symmetry of the matrix, an involution of the points, multiplies by its sign, 1 or -1.
class SymmetricPart {
  public:
    struct Symmetry {
        std::vector<int> image;  ///< per point: the point it is mapped to
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
    /// The part on the points with keep(point), which must be the same for all points of an orbit.
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
    /// The block of a matrix of all points that acts on this part.
    DenseMatrix block(const StencilTable& weights) const {
        DenseMatrix m(row_count_);
        int done = 0;
        for (int i = 0; i < weights.row_count(); ++i) {
            if (row_[i] != done) continue;  // not in this part, or not the first point of its orbit
            for (const auto& [j, weight] : weights.row(i).terms)
                if (row_[j] >= 0) m(done, row_[j]) += sign_[j] * weight;
            ++done;
        }
        return m;
    }
    /// A block's left eigenvector as a mask on all points.
    std::vector<double> spread(const std::vector<Complex>& y) const {
        std::vector<double> weights(row_.size(), 0.0);
        for (std::size_t i = 0; i < weights.size(); ++i)
            if (row_[i] >= 0) weights[i] = sign_[i] * y[row_[i]].real() / orbit_[i];
        return weights;
    }

  private:
    int row_count_ = 0;
    std::vector<int> row_;      ///< per point its row of a block; -1: none
    std::vector<double> sign_;  ///< per point its sign relative to the first point of its orbit
    std::vector<int> orbit_;    ///< per point the size of its orbit
};

std::vector<int> mirror_images(const FanLabels& labels) {
    std::vector<int> image;
    for (const FanLabel label : labels.all()) image.push_back(labels.find(labels.mirrored(label)));
    return image;
}

double real_or_zero(Complex z) { return std::abs(z.imag()) < k_same ? z.real() : 0; }

/// The largest eigenvalue of a matrix on a symmetric part; its left eigenvector if it is simple, real and positive.
struct Mode {
    std::vector<Complex> values;  ///< all eigenvalues of the part
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

/// Two sectors: both tangents are in Fourier mode 1, whose sign changes from one sector to the other. The mirror image
/// in the line along the two edges tells them apart: tangent 1 is even, tangent 2 is odd.
void analyse_two_sectors(SpectralAnalysis& analysis) {
    const int size = analysis.matrix.size();
    std::vector<int> turned(size, 0);  // the centre, 0, stays; points 2 k - 1 and 2 k of the two sectors are exchanged
    for (int i = 1; i < size; ++i) turned[i] = i % 2 != 0 ? i + 1 : i - 1;
    for (const double sign : {1.0, -1.0}) {
        const SymmetricPart part(size, {{turned, -1}, {mirror_images(analysis.matrix.labels), sign}});
        const Mode mode(part, analysis.matrix.rows);
        (sign > 0 ? analysis.lambda1 : analysis.lambda2) = mode.value;
        (sign > 0 ? analysis.tangent1 : analysis.tangent2) = mode.mask;
    }
}

/// Analysis of a rotation-symmetric fan: one block per Fourier mode. A block's rows are the points of sector 0.
void analyse_rotation(SpectralAnalysis& analysis) {
    const LocalMatrix& s = analysis.matrix;
    const int n = s.labels.shape().faces, centre = s.labels.lattice() == FanLattice::dual ? 0 : 1;
    const int places = (s.size() - centre) / n;
    const auto index = [&](int place, int sector) { return centre + place * n + sector; };

    std::vector<Complex> wave(n);
    for (int t = 0; t < n; ++t) wave[t] = std::polar(1.0, 2 * std::numbers::pi * t / n);
    // The block of mode 0 has a row for the centre as well.
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
        // The first point is on the ray itself (dual: on the face's diagonal): make its weight real and positive.
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

/// Whether the boundary's new points are combinations of the boundary's points alone.
bool depends_on_itself(const LocalMatrix& s) {
    for (int i = 0; i < s.size(); ++i) {
        if (!on_boundary(s.labels, i)) continue;
        for (const int j : s.rows.points(i))
            if (!on_boundary(s.labels, j)) return false;
    }
    return true;
}

/// A matrix beside a dual scheme's boundary edge in block form. Points whose values are constant in each column, from
/// the boundary inwards, stay so; the matrix acts on them, and on the differences along the columns, separately.
struct Rows {
    StencilTable differences;  ///< the matrix of differences: each point less the one before it in its column
    StencilTable columns;      ///< the matrix of boundary points, each of which stands for its whole column
    std::vector<int> before;   ///< per label the point before it in its column; -1 on the boundary
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
            // Point j is the boundary's point of its column plus the differences up to j.
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

/// Analysis of a mirror-symmetric fan by its even and odd parts. @return  `bends` for finish()
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

    // A boundary crosses the mirror axis, so the mode along it is odd; a dart's crease is the axis. If the boundary
    // depends on itself alone, the mode along it is the largest odd one of the boundary's own rules.
    const bool apart = boundary && depends_on_itself(s);
    const Mode o(apart ? odd.only([&](int i) { return on_boundary(s.labels, i); }) : odd, s.rows);
    // A mode that varies along the boundary alone is no tangent across it, even if its eigenvalue is as large (u^2
    // beside v^2, for a surface that is even across its boundary). The tangent is the largest mode of the differences.
    std::vector<double> bends;
    if (const std::optional<Rows> inwards = rows_inwards(s)) {
        const auto is_outermost = [&](int i) { return inwards->before[i] < 0; };
        e = Mode(even.only([&](int i) { return !is_outermost(i); }), inwards->differences);
        // The mask is on differences: each weight is subtracted from the point before, which has a lower number.
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
    // The matrix has two of the faces at the vertex, and not those between them.
    if (analysis.matrix.labels.lattice() == FanLattice::pentagons) analysis.proper = false;
    normalise(analysis.tangent1);
    normalise(analysis.tangent2);
    return analysis;
}

}  // namespace tetrakis
