#include "dense_eigen.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

// All of Eigen that the project uses: its templates take long to compile, so they are compiled here once.

namespace tetrakis::detail {

namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;

// Real matrices are solved as complex ones: a second kind of solver would take a third of the compile time.
MatrixXcd to_eigen(const DenseMatrix& m) {
    MatrixXcd out(m.size(), m.size());
    for (int i = 0; i < m.size(); ++i)
        for (int j = 0; j < m.size(); ++j) out(i, j) = m(i, j);
    return out;
}

// Relative distance within which eigenvalues may be joined; smaller magnitudes count as zero.
constexpr double k_cluster = 1e-4;

/// Whether two eigenvalues differ by more than rounding, but by little enough to be joined.
bool apart_a_little(Complex a, Complex b) {
    constexpr double k_rounding = 1e-13;
    const double distance = std::abs(a - b), size = std::max(std::abs(a), std::abs(b));
    return size > k_cluster && distance > k_rounding && distance < k_cluster * size;
}

/// First-order rounding error of each eigenvalue: the backward error over the cosine between its left and right
/// eigenvectors. Rounding splits a defective eigenvalue of multiplicity k into k values; their errors are of the size
/// of their distances, the k-th root of the rounding error. Other errors are near the rounding error itself.
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

/// Replaces eigenvalues that rounding alone may have separated by their mean. A perturbation moves the mean no more
/// than a simple eigenvalue.
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

/// The strongly connected components of the rows' dependency graph (Tarjan 1972): sorted by them the matrix is block
/// triangular, and its eigenvalues are those of the diagonal blocks.
class Components {
  public:
    explicit Components(const MatrixXcd& m)
        : m_(m), index_(static_cast<std::size_t>(m.rows()), k_new), low_(index_.size(), k_new) {
        for (Eigen::Index row = 0; row < m.rows(); ++row)
            if (index(row) == k_new) visit(row);
    }
    std::vector<std::vector<Eigen::Index>> all;

  private:
    static constexpr Eigen::Index k_new = -1, k_done = std::numeric_limits<Eigen::Index>::max();
    Eigen::Index& index(Eigen::Index row) { return index_[static_cast<std::size_t>(row)]; }
    Eigen::Index& low(Eigen::Index row) { return low_[static_cast<std::size_t>(row)]; }

    // The recursion is as deep as the longest path: at most a few thousand rows.
    void visit(Eigen::Index row) {
        index(row) = low(row) = count_++;
        open_.push_back(row);
        for (Eigen::Index to = 0; to < m_.cols(); ++to) {
            if (m_(row, to) == 0.0 || index(to) == k_done) continue;
            if (index(to) == k_new) visit(to);
            if (index(to) != k_done) low(row) = std::min(low(row), low(to));
        }
        if (low(row) != index(row)) return;
        const auto begin = std::find(open_.begin(), open_.end(), row);
        std::vector<Eigen::Index>& component = all.emplace_back(begin, open_.end());
        open_.erase(begin, open_.end());
        for (const Eigen::Index of : component) index(of) = k_done;
        std::sort(component.begin(), component.end());
    }

    const MatrixXcd& m_;
    Eigen::Index count_ = 0;
    std::vector<Eigen::Index> index_, low_, open_;
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

// Distance of the shift from the eigenvalue, some units of rounding, so that the shifted matrix is regular.
constexpr double k_beside = 1e-14;
// An even number, so that the start vector's sign stays.
constexpr int k_solves = 4;

}  // namespace

std::vector<Complex> eigenvalues(const DenseMatrix& dense) {
    const MatrixXcd m = to_eigen(dense);
    std::vector<Complex> values;
    for (const std::vector<Eigen::Index>& component : Components(m).all) {
        const std::vector<Complex> some = eigenvalues_of_block(m(component, component));
        values.insert(values.end(), some.begin(), some.end());
    }
    // Rounding gives real eigenvalues a small imaginary part.
    constexpr double k_rounding = 1e-12;
    for (Complex& z : values)
        if (std::abs(z.imag()) < k_rounding) z = z.real();
    return values;
}

std::vector<Complex> left_eigenvector(const DenseMatrix& m, Complex lambda) {
    // The start vector is neither even nor odd, so that it has a component along every eigenvector.
    VectorXcd x(m.size());
    for (Eigen::Index i = 0; i < x.size(); ++i)
        x(i) = x.size() > 1 ? 1 + static_cast<double>(i) / static_cast<double>(x.size() - 1) : 1.0;
    MatrixXcd shifted = to_eigen(m).transpose();
    shifted.diagonal().array() -= lambda + k_beside;
    const Eigen::PartialPivLU<MatrixXcd> lu(shifted);
    for (int i = 0; i < k_solves; ++i) {
        x = lu.solve(x).eval();
        x /= x.cwiseAbs().maxCoeff();
    }
    return {x.begin(), x.end()};
}

}  // namespace tetrakis::detail
