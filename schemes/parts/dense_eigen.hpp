#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace tetrakis::detail {

using Complex = std::complex<double>;

/// A small dense square matrix, by rows.
class DenseMatrix {
  public:
    explicit DenseMatrix(int size) : size_(size), values_(static_cast<std::size_t>(size) * size) {}
    int size() const { return size_; }
    Complex& operator()(int row, int column) { return values_[static_cast<std::size_t>(row) * size_ + column]; }
    Complex operator()(int row, int column) const { return values_[static_cast<std::size_t>(row) * size_ + column]; }

  private:
    int size_;
    std::vector<Complex> values_;
};

/// All eigenvalues with their multiplicity, in no order. Values that rounding alone may have separated become their
/// mean: it separates a defective eigenvalue by a root of the rounding error. Cost: O(size^2), and O(k^3) for k rows
/// in the largest strongly connected component.
std::vector<Complex> eigenvalues(const DenseMatrix& m);

/// Left eigenvector y of a simple eigenvalue, y^T M = lambda y^T up to rounding; its largest entry has magnitude one.
/// It is computed by inverse iteration, with a shift close to lambda. O(size^3).
std::vector<Complex> left_eigenvector(const DenseMatrix& m, Complex lambda);

}  // namespace tetrakis::detail
