#pragma once

#include <Eigen/Eigenvalues>

#include "engine/linalg/matrix_equations/householder.h"
#include "engine/numbers/quadruple.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Solves KX + XK = E for K symmetric positive definite, n × n, and any E: with K = VDVᵀ, (VᵀXV)_ij
/// = (VᵀEV)_ij / (d_i + d_j). A symmetric E gives a symmetric X. Does not allocate after
/// construction.
template <class Scalar>
class SymmetricLyapunov {
 public:
  explicit SymmetricLyapunov(Eigen::Index n);

  void factor(const Matrix<Scalar>& K);

  /// Solves for X with the factors of K. X may be E.
  void solve(const Matrix<Scalar>& E, Matrix<Scalar>& X);

 private:
  Eigen::HessenbergDecomposition<Matrix<Scalar>> tridiagonal_;
  Eigen::SelfAdjointEigenSolver<Matrix<Scalar>> eigen_;
  Matrix<Scalar> V_, product_;
  Vector<Scalar> d_, diagonal_, subdiagonal_, workspace_;
  Scalar k_{};
};

template <class Scalar>
SymmetricLyapunov<Scalar>::SymmetricLyapunov(Eigen::Index n)
    : tridiagonal_(n),
      eigen_(n),
      V_(n, n),
      product_(n, n),
      d_(n),
      diagonal_(n),
      subdiagonal_(n > 0 ? n - 1 : 0),
      workspace_(n) {}

template <class Scalar>
void SymmetricLyapunov<Scalar>::factor(const Matrix<Scalar>& K) {
  if (K.rows() == 1) {
    k_ = K(0, 0);
    return;
  }
  stop_point(6 * static_cast<double>(K.rows() * K.size()));
  const Scalar scale = K.cwiseAbs().maxCoeff();
  product_ = K / scale;
  tridiagonal_.compute(product_);
  diagonal_ = tridiagonal_.packedMatrix().diagonal();
  subdiagonal_ = tridiagonal_.packedMatrix().template diagonal<-1>();
  eigen_.computeFromTridiagonal(diagonal_, subdiagonal_);
  d_ = scale * eigen_.eigenvalues();
  write_householder_product(tridiagonal_.packedMatrix(), tridiagonal_.householderCoefficients(),
                            workspace_, product_);
  V_.noalias() = product_ * eigen_.eigenvectors();
}

template <class Scalar>
void SymmetricLyapunov<Scalar>::solve(const Matrix<Scalar>& E, Matrix<Scalar>& X) {
  if (E.rows() == 1) {
    X(0, 0) = E(0, 0) / (2 * k_);
    return;
  }
  stop_point(4 * static_cast<double>(E.rows() * E.size()));
  product_.noalias() = V_.transpose() * E;
  X.noalias() = product_ * V_;
  for (Eigen::Index j = 0; j < X.cols(); ++j)
    for (Eigen::Index i = 0; i < X.rows(); ++i) X(i, j) /= d_(i) + d_(j);
  stop_point();
  product_.noalias() = V_ * X;
  X.noalias() = product_ * V_.transpose();
}

// Compiled once, in symmetric_lyapunov.cc.
extern template class SymmetricLyapunov<double>;
extern template class SymmetricLyapunov<long double>;
extern template class SymmetricLyapunov<Quad>;

}  // namespace stiefel
