#pragma once

#include <complex>

#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Computes exp(tA) of one skew A, n × n, for any t at the same cost: with iA = Z w Z†, w real,
/// exp(tA) = Z e^{−iwt} Z†, orthogonal to rounding for every t. Does not allocate after
/// construction.
template <class Scalar>
class SkewFlow {
 public:
  explicit SkewFlow(const Matrix<Scalar>& A);

  void operator()(Scalar t, Matrix<Scalar>& E);

 private:
  using Complex = std::complex<Scalar>;

  Matrix<Complex> Z_, turned_, product_;
  Vector<Scalar> w_;
};

template <class Scalar>
SkewFlow<Scalar>::SkewFlow(const Matrix<Scalar>& A) {
  if (A.rows() == 0) return;
  stop_point(25 * static_cast<double>(A.rows() * A.size()));
  const Matrix<Complex> H = Complex(0, 1) * A.template cast<Complex>();
  const Eigen::SelfAdjointEigenSolver<Matrix<Complex>> solver(H);
  Z_ = turned_ = product_ = solver.eigenvectors();
  w_ = solver.eigenvalues();
}

template <class Scalar>
void SkewFlow<Scalar>::operator()(Scalar t, Matrix<Scalar>& E) {
  using std::cos, std::sin;
  for (Eigen::Index i = 0; i < w_.size(); ++i)
    turned_.col(i) = Complex(cos(w_(i) * t), -sin(w_(i) * t)) * Z_.col(i);
  stop_point(4 * static_cast<double>(Z_.rows() * Z_.size()));
  product_.noalias() = turned_ * Z_.adjoint();
  E = product_.real();
}

// Compiled once, in exponential.cc.
extern template class SkewFlow<double>;
extern template class SkewFlow<long double>;

}  // namespace stiefel
