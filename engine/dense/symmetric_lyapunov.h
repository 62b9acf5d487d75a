#pragma once

#include <Eigen/Eigenvalues>

#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"

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

// Compiled once, in lyapunov_equation.cc.
extern template class SymmetricLyapunov<double>;
extern template class SymmetricLyapunov<long double>;
extern template class SymmetricLyapunov<Quad>;

}  // namespace stiefel
