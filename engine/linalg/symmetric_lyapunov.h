#pragma once

#include <Eigen/Eigenvalues>

#include "engine/linalg/scalar.h"

namespace stiefel {

/// Solves KX + XK = E for K symmetric positive definite, n × n, and any E: with K = VDVᵀ,
/// (VᵀXV)_ij = (VᵀEV)_ij / (d_i + d_j). Symmetric E gives symmetric X. No allocation.
template <class Scalar>
class SymmetricLyapunov {
 public:
  explicit SymmetricLyapunov(Eigen::Index n);

  void factor(const Matrix<Scalar>& K);

  /// X may be E.
  void solve(const Matrix<Scalar>& E, Matrix<Scalar>& X);

 private:
  Eigen::SelfAdjointEigenSolver<Matrix<Scalar>> eigen_;
  Matrix<Scalar> product_;
  Scalar k_{};
};

template <class Scalar>
SymmetricLyapunov<Scalar>::SymmetricLyapunov(Eigen::Index n) : eigen_(n), product_(n, n) {}

template <class Scalar>
void SymmetricLyapunov<Scalar>::factor(const Matrix<Scalar>& K) {
  if (K.rows() == 1)
    k_ = K(0, 0);
  else
    eigen_.compute(K);
}

template <class Scalar>
void SymmetricLyapunov<Scalar>::solve(const Matrix<Scalar>& E, Matrix<Scalar>& X) {
  if (E.rows() == 1) {
    X(0, 0) = E(0, 0) / (2 * k_);
    return;
  }
  const Matrix<Scalar>& V = eigen_.eigenvectors();
  const Vector<Scalar>& d = eigen_.eigenvalues();
  product_.noalias() = V.transpose() * E;
  X.noalias() = product_ * V;
  for (Eigen::Index j = 0; j < X.cols(); ++j)
    for (Eigen::Index i = 0; i < X.rows(); ++i) X(i, j) /= d(i) + d(j);
  product_.noalias() = V * X;
  X.noalias() = product_ * V.transpose();
}

// Compiled once, in symmetric_lyapunov.cc.
extern template class SymmetricLyapunov<double>;
extern template class SymmetricLyapunov<long double>;

}  // namespace stiefel
