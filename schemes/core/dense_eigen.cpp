#include "dense_eigen.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

// All of Eigen that the project uses: its templates take long to compile, so they are compiled here once.

namespace tetrakis::detail {

namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

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
template <class Matrix>
class Blocks {
  public:
    explicit Blocks(const Matrix& m) : m_(m), place_(static_cast<std::size_t>(m.size()), k_new), low_(place_) {
        for (Eigen::Index row = 0; row < m.size(); ++row)
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
            const Eigen::Index terms = m_.terms(row);
            while (next < terms &&
                   (!m_.any(row, next) || place_[static_cast<std::size_t>(m_.column(row, next))] == k_done))
                ++next;
            if (next < terms) {
                const Eigen::Index to = m_.column(row, next++);
                if (place_[static_cast<std::size_t>(to)] == k_new)
                    path.push_back({to, 0});
                else
                    low = std::min(low, place_[static_cast<std::size_t>(to)]);
                continue;
            }
            if (low == place) {
                const auto begin = std::find(open_.rbegin(), open_.rend(), row).base() - 1;
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

    const Matrix& m_;
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

/// What Blocks asks of a dense matrix and of a sparse one.
struct DenseRows {
    const MatrixXcd& m;
    Eigen::Index size() const { return m.rows(); }
    Eigen::Index terms(Eigen::Index) const { return m.cols(); }
    Eigen::Index column(Eigen::Index, Eigen::Index k) const { return k; }
    bool any(Eigen::Index row, Eigen::Index k) const { return m(row, k) != 0.0; }
};
struct SparseRows {
    const StencilTable& m;
    Eigen::Index size() const { return m.row_count(); }
    Eigen::Index terms(Eigen::Index row) const {
        return static_cast<Eigen::Index>(m.points(static_cast<int>(row)).size());
    }
    Eigen::Index column(Eigen::Index row, Eigen::Index k) const {
        return m.points(static_cast<int>(row))[static_cast<std::size_t>(k)];
    }
    bool any(Eigen::Index, Eigen::Index) const { return true; }
};

std::vector<Complex> eigenvalues_of(const MatrixXcd& m) {
    std::vector<Complex> values;
    for (std::vector<Eigen::Index>& block : Blocks(DenseRows{m}).all) {
        std::sort(block.begin(), block.end());
        const std::vector<Complex> some = eigenvalues_of_block(m(block, block));
        values.insert(values.end(), some.begin(), some.end());
    }
    return values;
}

/// Rounding leaves the real ones with a little of an imaginary part.
void take_rounding_out(std::vector<Complex>& values) {
    constexpr double k_rounding = 1e-12;
    for (Complex& z : values)
        if (std::abs(z.imag()) < k_rounding) z = z.real();
}

/// LU factors of a band around the diagonal, with partial pivoting (Golub, Van Loan, algorithm 4.3.2).
class BandFactors {
  public:
    BandFactors(Eigen::Index size, Eigen::Index below, Eigen::Index above)
        : size_(size), below_(below), above_(above + below), a_(MatrixXd::Zero(above + 2 * below + 1, size)) {}
    double& operator()(Eigen::Index row, Eigen::Index column) { return a_(row - column + above_, column); }

    void factor() {
        auto& a = *this;
        pivot_.resize(static_cast<std::size_t>(size_));
        for (Eigen::Index k = 0; k < size_; ++k) {
            const Eigen::Index last = std::min(k + below_, size_ - 1), right = std::min(k + above_, size_ - 1);
            Eigen::Index p = k;
            for (Eigen::Index i = k + 1; i <= last; ++i)
                if (std::abs(a(i, k)) > std::abs(a(p, k))) p = i;
            pivot_[static_cast<std::size_t>(k)] = p;
            for (Eigen::Index j = k; p != k && j <= right; ++j) std::swap(a(k, j), a(p, j));
            if (a(k, k) == 0) a(k, k) = std::numeric_limits<double>::min();
            for (Eigen::Index i = k + 1; i <= last; ++i) {
                const double factor = a(i, k) /= a(k, k);
                for (Eigen::Index j = k + 1; factor != 0 && j <= right; ++j) a(i, j) -= factor * a(k, j);
            }
        }
    }
    VectorXd solve(VectorXd x) {
        auto& a = *this;
        for (Eigen::Index k = 0; k < size_; ++k) {
            std::swap(x(k), x(pivot_[static_cast<std::size_t>(k)]));
            for (Eigen::Index i = k + 1; i <= std::min(k + below_, size_ - 1); ++i) x(i) -= a(i, k) * x(k);
        }
        for (Eigen::Index k = size_; k-- > 0;) {
            for (Eigen::Index j = k + 1; j <= std::min(k + above_, size_ - 1); ++j) x(k) -= a(k, j) * x(j);
            x(k) /= a(k, k);
        }
        return x;
    }

  private:
    Eigen::Index size_, below_, above_;  // diagonals on either side, with those that pivoting fills
    MatrixXd a_;
    std::vector<Eigen::Index> pivot_;
};

/// Solves x^T (M - lambda) = b^T several times.
class LeftSolver {
  public:
    LeftSolver(const StencilTable& m, double lambda) : size_(m.row_count()) {
        Eigen::Index below = 0, above = 0;  // of the transposed matrix
        for (int i = 0; i < m.row_count(); ++i)
            for (const int j : m.points(i)) {
                below = std::max<Eigen::Index>(below, j - i);
                above = std::max<Eigen::Index>(above, i - j);
            }
        // The band costs its width squared per row, without blocking.
        constexpr Eigen::Index k_narrow = 8;
        const auto fill = [&](auto& a) {
            for (int i = 0; i < m.row_count(); ++i)
                for (std::size_t t = 0; t < m.points(i).size(); ++t) a(m.points(i)[t], i) = m.weights(i)[t];
            for (Eigen::Index i = 0; i < size_; ++i) a(i, i) -= lambda;
        };
        if (k_narrow * (below + above) < size_) {
            band_.emplace(size_, below, above);
            fill(*band_);
            band_->factor();
        } else {
            MatrixXd dense = MatrixXd::Zero(size_, size_);
            fill(dense);
            dense_.compute(dense);
        }
    }
    VectorXd solve(const VectorXd& b) { return band_ ? band_->solve(b) : VectorXd(dense_.solve(b)); }

  private:
    Eigen::Index size_;
    std::optional<BandFactors> band_;
    Eigen::PartialPivLU<MatrixXd> dense_;
};

VectorXd to_vector(const std::vector<double>& x) {
    VectorXd result(static_cast<Eigen::Index>(x.size()));
    std::copy(x.begin(), x.end(), result.begin());
    return result;
}

// Off an eigenvalue by some units of rounding, so that the factor is regular.
constexpr double k_beside = 1e-14;
// An even number: the start's sign stays.
constexpr int k_solves = 4;

}  // namespace

std::vector<Complex> eigenvalues(const DenseMatrix<Complex>& m) { return eigenvalues_of(to_eigen(m)); }

std::vector<Complex> eigenvalues(const DenseMatrix<double>& m) {
    std::vector<Complex> values = eigenvalues_of(to_eigen(m));
    take_rounding_out(values);
    return values;
}

std::vector<Complex> eigenvalues(const StencilTable& m) {
    // Of larger ones the real Schur form takes a fourth of the time and half of the memory. That defective eigenvalues
    // come out as their mean would take all eigenvectors.
    constexpr std::size_t k_large = 300;
    std::vector<Complex> values;
    std::vector<Eigen::Index> place(static_cast<std::size_t>(m.row_count()), -1);
    for (std::vector<Eigen::Index>& block : Blocks(SparseRows{m}).all) {
        std::sort(block.begin(), block.end());
        const auto size = static_cast<Eigen::Index>(block.size());
        for (Eigen::Index i = 0; i < size; ++i) place[static_cast<std::size_t>(block[i])] = i;
        const auto fill = [&](auto& a) {
            for (Eigen::Index i = 0; i < size; ++i) {
                const auto row = static_cast<int>(block[i]);
                for (std::size_t t = 0; t < m.points(row).size(); ++t)
                    if (const Eigen::Index j = place[static_cast<std::size_t>(m.points(row)[t])]; j >= 0)
                        a(i, j) = m.weights(row)[t];
            }
        };
        if (block.size() > k_large) {
            MatrixXd a = MatrixXd::Zero(size, size);
            fill(a);
            const VectorXcd some = Eigen::EigenSolver<MatrixXd>(a, false).eigenvalues();
            values.insert(values.end(), some.begin(), some.end());
        } else {
            MatrixXcd a = MatrixXcd::Zero(size, size);
            fill(a);
            const std::vector<Complex> some = eigenvalues_of_block(a);
            values.insert(values.end(), some.begin(), some.end());
        }
        for (const Eigen::Index i : block) place[static_cast<std::size_t>(i)] = -1;
    }
    take_rounding_out(values);
    return values;
}

std::vector<Complex> left_eigenvector(const DenseMatrix<Complex>& m, Complex lambda) {
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

std::vector<double> left_eigenvector(const StencilTable& m, double lambda, std::vector<double> start) {
    LeftSolver solver(m, lambda + k_beside);
    VectorXd x = to_vector(start);
    for (int i = 0; i < k_solves; ++i) {
        x = solver.solve(x);
        x /= x.cwiseAbs().maxCoeff();
    }
    return {x.begin(), x.end()};
}

std::vector<double> left_solution(const StencilTable& m, double lambda, const std::vector<double>& b) {
    const VectorXd x = LeftSolver(m, lambda).solve(-to_vector(b));
    return {x.begin(), x.end()};
}

}  // namespace tetrakis::detail
