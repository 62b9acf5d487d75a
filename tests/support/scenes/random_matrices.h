#pragma once

#include <random>
#include <vector>

#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"
#include "tests/support/scenes/stacked.h"

namespace stiefel::testing {

/// Returns Λ as a description has it.
inline std::vector<double> numbers(const Eigen::VectorXd& lambda) {
  return {lambda.begin(), lambda.end()};
}

/// Seeded random matrices of any scalar. Each number is a sum of two doubles, so that the digits
/// beyond double precision are not zeros.
template <class Scalar>
class RandomMatrices {
 public:
  explicit RandomMatrices(unsigned seed) : engine_(seed) {}

  Matrix<Scalar> matrix(Eigen::Index rows, Eigen::Index cols);
  Matrix<Scalar> skew(Eigen::Index N);
  /// Returns n orthonormal rows in R^N; for n = N the determinant is +1.
  Matrix<Scalar> frame(Eigen::Index n, Eigen::Index N);
  /// Returns N numbers between 1 and `spread`.
  Vector<Scalar> lambda(Eigen::Index N, double spread = 4);

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// Returns the largest |a_ij|.
inline double largest(const Matrix<double>& A) { return A.cwiseAbs().maxCoeff(); }

// Compiled once, in random_matrices.cc.
extern template class RandomMatrices<double>;
extern template class RandomMatrices<long double>;
extern template class RandomMatrices<Quad>;

}  // namespace stiefel::testing
