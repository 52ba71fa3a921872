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
    int count = 0;
    for (const Complex& z : values) count += std::abs(z - value) < k_same ? 1 : 0;
    return count;
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

/// Two sectors: what changes its sign from one to the other is one mode for both tangents, which the mirror image tells
/// apart: the same on both sides of the line along the two edges (tangent 1), or of opposite sign (tangent 2). A
/// block's rows are the places of sector 0.
void analyse_two_sectors(SpectralAnalysis& analysis, const DenseMatrix<Complex>& block) {
    const FanLabels& labels = analysis.matrix.labels;
    const int places = (analysis.matrix.size() - 1) / 2;
    const auto index = [](int place, int sector) { return 1 + place * 2 + sector; };
    for (const double sign : {1.0, -1.0}) {
        // Of each place its mirror image in the same sector, and whether that is so only with the other sign.
        std::vector<int> rows, image(places);
        std::vector<double> turned(places);
        for (int p = 0; p < places; ++p) {
            const int i = labels.find(labels.mirrored(labels.all()[index(p, 0)])) - 1;
            image[p] = i / 2;
            turned[p] = i % 2 == 0 ? sign : -sign;
            if (image[p] > p || (image[p] == p && turned[p] > 0)) rows.push_back(p);
        }
        DenseMatrix<double> part(static_cast<int>(rows.size()));
        for (std::size_t a = 0; a < rows.size(); ++a)
            for (std::size_t b = 0; b < rows.size(); ++b) {
                const int q = rows[b];
                part(a, b) =
                    block(rows[a], q).real() + (image[q] == q ? 0 : turned[q] * block(rows[a], image[q]).real());
            }
        const std::vector<Complex> values = eigenvalues(part);
        const Complex lambda = largest(values, false);
        const double real = std::abs(lambda.imag()) < k_same ? lambda.real() : 0;
        (sign > 0 ? analysis.lambda1 : analysis.lambda2) = real;
        if (count_same(values, lambda) != 1 || real <= k_same) continue;
        const std::vector<double> y = left_eigenvector(part, real);
        std::vector<double>& mask = sign > 0 ? analysis.tangent1 : analysis.tangent2;
        mask.assign(analysis.matrix.size(), 0.0);
        for (std::size_t a = 0; a < rows.size(); ++a)
            for (int t = 0; t < 2; ++t) {
                const int p = rows[a];
                const double w = (t == 0 ? 1 : -1) * y[a];
                if (image[p] == p) {
                    mask[index(p, t)] = w;
                } else {
                    mask[index(p, t)] = w / 2;
                    mask[index(image[p], t)] = turned[p] * w / 2;
                }
            }
    }
}

/// Rotation-symmetric: one block per Fourier mode. A block's rows are the places of sector 0.
void analyse_rotation(SpectralAnalysis& analysis) {
    const LocalMatrix& s = analysis.matrix;
    const int n = s.labels.shape().faces, centre = s.labels.lattice() == FanLattice::dual ? 0 : 1;
    const int places = (s.size() - centre) / n;
    const auto index = [&](int place, int sector) { return centre + place * n + sector; };

    struct Term {
        int row, column, sector;  ///< places, and how many sectors the column's is ahead
        double weight;
    };
    std::vector<Term> terms;
    DenseMatrix<double> zero(places + centre);
    for (int p = -centre; p < places; ++p) {
        const auto points = s.rows.points(centre + p);
        const auto weights = s.rows.weights(centre + p);
        for (std::size_t k = 0; k < points.size(); ++k) {
            const bool to_centre = points[k] < centre;
            const int q = to_centre ? -1 : (points[k] - centre) / n;
            zero(centre + p, centre + q) += weights[k];
            if (p >= 0 && !to_centre) terms.push_back({p, q, (points[k] - centre) % n, weights[k]});
        }
    }
    add(analysis, eigenvalues(zero), 0, 1);
    const std::vector<double> limit = left_eigenvector(zero, 1.0);
    const double total = std::accumulate(limit.begin(), limit.end(), 0.0);
    analysis.limit.assign(s.size(), 0.0);
    if (centre == 1) analysis.limit[0] = limit[0] / total;
    for (int p = 0; p < places; ++p)
        for (int t = 0; t < n; ++t) analysis.limit[index(p, t)] = limit[centre + p] / total / n;

    std::vector<Complex> wave(n);
    for (int t = 0; t < n; ++t) wave[t] = std::polar(1.0, 2 * std::numbers::pi * t / n);
    for (int j = 1; 2 * j <= n; ++j) {
        DenseMatrix<Complex> block(places);
        for (const Term& term : terms)
            block(term.row, term.column) +=
                wave[static_cast<std::size_t>(std::int64_t{j} * term.sector % n)] * term.weight;
        const std::vector<Complex> values = eigenvalues(block);
        add(analysis, values, j, 2 * j < n ? 2 : 1);
        if (j == 1 && n == 2) analyse_two_sectors(analysis, block);
        if (j != 1 || n == 2) continue;
        const Complex lambda = largest(values, false);
        analysis.lambda1 = analysis.lambda2 = std::abs(lambda.imag()) < k_same ? lambda.real() : 0;
        if (count_same(values, lambda) != 1 || analysis.lambda1 <= 0) continue;
        std::vector<Complex> y = left_eigenvector(block, lambda);
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
    std::vector<int> mirror(size), fixed_or_first, first;
    for (int i = 0; i < size; ++i) {
        mirror[i] = s.labels.find(s.labels.mirrored(s.labels.all()[i]));
        if (mirror[i] >= i) fixed_or_first.push_back(i);
        if (mirror[i] > i) first.push_back(i);
    }
    /// Some rows, and their columns, of the even (sign 1) or odd part.
    const auto block_of = [&](const StencilTable& weights, const std::vector<int>& rows, double sign) {
        std::vector<int> place(size, -1);
        for (std::size_t b = 0; b < rows.size(); ++b) place[rows[b]] = static_cast<int>(b);
        StencilTable m;
        for (const int i : rows) {
            StencilRow row;
            for (std::size_t t = 0; t < weights.points(i).size(); ++t) {
                const int j = weights.points(i)[t];
                const double w = weights.weights(i)[t];
                if (place[j] >= 0)
                    row.add(place[j], w);
                else if (place[mirror[j]] >= 0)
                    row.add(place[mirror[j]], sign * w);
            }
            m.push(std::move(row));
        }
        return m;
    };
    const auto block = [&](const std::vector<int>& rows, double sign) { return block_of(s.rows, rows, sign); };
    const auto spread = [&](const std::vector<int>& rows, const std::vector<double>& y, double sign) {
        std::vector<double> weights(size, 0.0);
        for (std::size_t a = 0; a < rows.size(); ++a) {
            if (mirror[rows[a]] == rows[a]) {
                weights[rows[a]] = y[a];
            } else {
                weights[rows[a]] = y[a] / 2;
                weights[mirror[rows[a]]] = sign * y[a] / 2;
            }
        }
        return weights;
    };
    // Where the boundary depends on itself alone, its modes are apart from those of the inside.
    const bool apart = boundary && depends_on_itself(s);
    const auto on_its_own = [&](std::vector<int> rows, bool on) {
        std::erase_if(rows, [&](int i) { return on_boundary(s.labels, i) != on; });
        return rows;
    };
    const auto even_eigenvector = [&](double lambda) {
        return spread(fixed_or_first, left_eigenvector(block(fixed_or_first, 1), lambda), 1);
    };
    const std::vector<Complex> even_values = eigenvalues(block(fixed_or_first, 1)),
                               odd_values = eigenvalues(block(first, -1));
    add(analysis, even_values, 0, 1);
    add(analysis, odd_values, 1, 1);
    analysis.limit = even_eigenvector(1.0);
    const double total = std::accumulate(analysis.limit.begin(), analysis.limit.end(), 0.0);
    for (double& w : analysis.limit) w /= total;

    Complex e = largest(even_values, true);
    const auto real = [](Complex z) { return std::abs(z.imag()) < k_same ? z.real() : 0; };
    std::vector<double> even_mask, odd_mask;
    if (real(e) > 0 && count_same(even_values, e) == 1) even_mask = even_eigenvector(e.real());
    // A boundary runs from one side of the mirror to the other, a dart's crease along it. Where the boundary has rules
    // of its own, the mode along it is the largest odd one of these alone, whatever the inside does.
    const std::vector<int> along = apart ? on_its_own(first, true) : first;
    const StencilTable odd_part = block(along, -1);
    const std::vector<Complex> along_values = apart ? eigenvalues(odd_part) : odd_values;
    const Complex o = largest(along_values, false);
    if (real(o) > 0 && count_same(along_values, o) == 1)
        odd_mask = spread(along, left_eigenvector(odd_part, o.real()), -1);
    // What varies along the boundary alone is no tangent across it, even where its eigenvalue is as large (u^2 beside
    // v^2, where the surface ends as an even function): that is the largest one of the differences across.
    std::vector<double> bends;
    if (const std::optional<Rows> inwards = rows_inwards(s)) {
        const auto on = [&](std::vector<int> rows, bool outermost) {
            std::erase_if(rows, [&](int i) { return (inwards->before[i] < 0) != outermost; });
            return rows;
        };
        const std::vector<int> inner = on(fixed_or_first, false);
        const StencilTable across = block_of(inwards->differences, inner, 1);
        const std::vector<Complex> across_values = eigenvalues(across);
        e = largest(across_values, false);
        even_mask.clear();
        if (real(e) > 0 && count_same(across_values, e) == 1) {
            even_mask.assign(size, 0.0);
            const std::vector<double> weights = spread(inner, left_eigenvector(across, e.real()), 1);
            for (int i = 0; i < size; ++i) {
                if (inwards->before[i] < 0) continue;
                even_mask[i] += weights[i];
                even_mask[inwards->before[i]] -= weights[i];
            }
        }
        for (const double sign : {1.0, -1.0})
            for (const Complex z :
                 eigenvalues(block_of(inwards->columns, on(sign > 0 ? fixed_or_first : first, true), sign)))
                bends.push_back(std::abs(z));
        take_out(bends, 1);
        take_out(bends, real(o));
    }
    analysis.lambda1 = real(boundary ? o : e);
    analysis.lambda2 = real(boundary ? e : o);
    analysis.tangent1 = boundary ? odd_mask : even_mask;
    analysis.tangent2 = boundary ? even_mask : odd_mask;
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
    const bool rotates = !shape.boundary && !shape.dart;
    std::vector<double> bends;
    if (rotates)
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
