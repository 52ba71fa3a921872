#include "tetrakis/schemes/dense_eigen.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

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

std::vector<Complex> eigenvalues_of(const MatrixXcd& m) {
    if (m.rows() == 0) return {};
    const VectorXcd values = Eigen::ComplexEigenSolver<MatrixXcd>(m, false).eigenvalues();
    return {values.begin(), values.end()};
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
