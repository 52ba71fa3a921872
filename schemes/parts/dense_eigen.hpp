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

/// All eigenvalues, each as often as it counts, in no order. Those that rounding alone may hold apart, as it does with
/// defective ones (by the root of the rounding error), come out as their mean. O(size^2), and O(size^3) of the largest
/// component.
std::vector<Complex> eigenvalues(const DenseMatrix& m);

/// y with y^T M = lambda y^T for a simple eigenvalue, to rounding, its largest entry of size one: by inverse iteration
/// a little beside it. O(size^3).
std::vector<Complex> left_eigenvector(const DenseMatrix& m, Complex lambda);

}  // namespace tetrakis::detail
