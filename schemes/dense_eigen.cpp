#include "tetrakis/schemes/dense_eigen.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

// All of Eigen that the project uses: its templates take long to compile, so they are compiled here once, and for
// complex matrices alone.

namespace tetrakis::detail {

namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;

template <class T>
MatrixXcd to_eigen(const DenseMatrix<T>& m) {
    MatrixXcd out(m.size(), m.size());
    for (int i = 0; i < m.size(); ++i)
        for (int j = 0; j < m.size(); ++j) out(i, j) = m(i, j);
    return out;
}

// Nothing is told apart from zero below this, and nothing farther apart than this part of itself is put together.
constexpr double k_cluster = 1e-4;

/// Whether two eigenvalues are near each other, yet not the same.
bool apart_a_little(Complex a, Complex b) {
    constexpr double k_rounding = 1e-13;
    const double distance = std::abs(a - b), size = std::max(std::abs(a), std::abs(b));
    return size > k_cluster && distance > k_rounding && distance < k_cluster * size;
}

/// How far off rounding may have put each eigenvalue, to first order: the backward error over the cosine between its
/// left and right eigenvectors. That of what a defective eigenvalue of multiplicity k has become is of the size of its
/// distance from the others, the k-th root of the rounding error; that of others is near the rounding error itself.
std::vector<double> uncertainties(const MatrixXcd& m, const MatrixXcd& right) {
    constexpr double k_backward_error = 10 * std::numeric_limits<double>::epsilon();
    const MatrixXcd left = right.partialPivLu().inverse();
    std::vector<double> result;
    for (Eigen::Index i = 0; i < m.rows(); ++i) {
        const double secant = left.row(i).norm() * right.col(i).norm();
        result.push_back(std::isfinite(secant) ? k_backward_error * m.norm() * secant : 1);
    }
    return result;
}

/// Eigenvalues that rounding alone may hold apart become their mean, which a perturbation moves no more than a simple
/// one.
void join(std::vector<Complex>& values, const std::vector<double>& uncertain) {
    const std::size_t n = values.size();
    std::vector<bool> done(n, false);
    const std::vector<Complex> old = values;
    for (std::size_t first = 0; first < n; ++first) {
        if (done[first]) continue;
        std::vector<std::size_t> cluster{first};
        done[first] = true;
        Complex sum = old[first];
        for (std::size_t k = 0; k < cluster.size(); ++k)
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t from = cluster[k];
                if (done[i] || !apart_a_little(old[from], old[i]) ||
                    std::abs(old[from] - old[i]) > uncertain[from] + uncertain[i])
                    continue;
                done[i] = true;
                sum += old[i];
                cluster.push_back(i);
            }
        for (const std::size_t i : cluster) values[i] = sum / static_cast<double>(cluster.size());
    }
}

/// The rows that depend on each other in circles, by Tarjan's algorithm: sorted by them the matrix is block triangular,
/// and its eigenvalues are those of the blocks.
class Blocks {
  public:
    explicit Blocks(const MatrixXcd& m) : m_(m), place_(static_cast<std::size_t>(m.rows()), k_new), low_(place_) {
        for (Eigen::Index row = 0; row < m.rows(); ++row)
            if (place_[static_cast<std::size_t>(row)] == k_new) visit(row);
    }
    std::vector<std::vector<Eigen::Index>> all;

  private:
    static constexpr Eigen::Index k_new = -1, k_done = std::numeric_limits<Eigen::Index>::max();
    struct Visit {
        Eigen::Index row, next;
    };
    void visit(Eigen::Index start) {
        std::vector<Visit> path{{start, 0}};
        while (!path.empty()) {
            auto& [row, next] = path.back();
            Eigen::Index &place = place_[static_cast<std::size_t>(row)], &low = low_[static_cast<std::size_t>(row)];
            if (place == k_new) {
                place = low = count_++;
                open_.push_back(row);
            }
            while (next < m_.cols() && (m_(row, next) == 0.0 || place_[static_cast<std::size_t>(next)] == k_done))
                ++next;
            if (next < m_.cols()) {
                const Eigen::Index to = next++;
                if (place_[static_cast<std::size_t>(to)] == k_new)
                    path.push_back({to, 0});
                else
                    low = std::min(low, place_[static_cast<std::size_t>(to)]);
                continue;
            }
            if (low == place) {
                const auto begin = std::find(open_.begin(), open_.end(), row);
                all.emplace_back(begin, open_.end());
                open_.erase(begin, open_.end());
                for (const Eigen::Index of : all.back()) place_[static_cast<std::size_t>(of)] = k_done;
            }
            const Eigen::Index reached = low;
            path.pop_back();
            if (path.empty()) continue;
            Eigen::Index& above = low_[static_cast<std::size_t>(path.back().row)];
            above = std::min(above, reached);
        }
    }

    const MatrixXcd& m_;
    Eigen::Index count_ = 0;
    std::vector<Eigen::Index> place_, low_, open_;
};

std::vector<Complex> eigenvalues_of_block(const MatrixXcd& m) {
    if (m.rows() == 1) return {m(0, 0)};
    const VectorXcd computed = Eigen::ComplexEigenSolver<MatrixXcd>(m, false).eigenvalues();
    std::vector<Complex> values(computed.begin(), computed.end());
    for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if (!apart_a_little(values[i], values[j])) continue;
            const Eigen::ComplexEigenSolver<MatrixXcd> whole(m, true);
            values.assign(whole.eigenvalues().begin(), whole.eigenvalues().end());
            join(values, uncertainties(m, whole.eigenvectors()));
            return values;
        }
    return values;
}

std::vector<Complex> eigenvalues_of(const MatrixXcd& m) {
    std::vector<Complex> values;
    for (std::vector<Eigen::Index>& block : Blocks(m).all) {
        std::sort(block.begin(), block.end());
        const std::vector<Complex> some = eigenvalues_of_block(m(block, block));
        values.insert(values.end(), some.begin(), some.end());
    }
    return values;
}

}  // namespace

std::vector<Complex> eigenvalues(const DenseMatrix<Complex>& m) { return eigenvalues_of(to_eigen(m)); }

std::vector<Complex> eigenvalues(const DenseMatrix<double>& m) {
    // Rounding leaves the real ones with a little of an imaginary part.
    constexpr double k_rounding = 1e-12;
    std::vector<Complex> values = eigenvalues_of(to_eigen(m));
    for (Complex& z : values)
        if (std::abs(z.imag()) < k_rounding) z = z.real();
    return values;
}

std::vector<Complex> left_eigenvector(const DenseMatrix<Complex>& m, Complex lambda) {
    // Off the eigenvalue by some units of rounding, so that the factor is regular.
    constexpr double k_beside = 1e-14;
    constexpr int k_solves = 4;
    MatrixXcd shifted = to_eigen(m).transpose();
    shifted.diagonal().array() -= lambda + k_beside;
    const Eigen::PartialPivLU<MatrixXcd> lu(shifted);
    VectorXcd x(m.size());
    for (int i = 0; i < m.size(); ++i) x(i) = m.size() > 1 ? 1.0 + i / (m.size() - 1.0) : 1.0;
    for (int i = 0; i < k_solves; ++i) {
        x = lu.solve(x);
        x /= x.cwiseAbs().maxCoeff();
    }
    return {x.begin(), x.end()};
}

std::vector<double> left_eigenvector(const DenseMatrix<double>& m, double lambda) {
    DenseMatrix<Complex> complex(m.size());
    for (int i = 0; i < m.size(); ++i)
        for (int j = 0; j < m.size(); ++j) complex(i, j) = m(i, j);
    std::vector<double> out;
    for (const Complex& z : left_eigenvector(complex, Complex(lambda))) out.push_back(z.real());
    return out;
}

}  // namespace tetrakis::detail
