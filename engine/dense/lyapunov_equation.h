#pragma once

#include <Eigen/Eigenvalues>
#include <complex>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Solves AᵀY + YA = G for real N × N matrices by the complex Schur form A = ZTZᴴ (Bartels and
/// Stewart 1972): Tᴴ Ŷ + Ŷ T = Zᴴ G Z, column by column. The solution is unique when no two
/// eigenvalues of A sum to 0.
template <class Scalar>
class Lyapunov {
 public:
  using Complex = std::complex<Scalar>;

  explicit Lyapunov(Eigen::Index N);

  void factor(const Matrix<Scalar>& A);

  /// Returns the smallest Re(w_i + w_j), i < j, over the eigenvalues w of A.
  Scalar smallest_pair_sum() const;

  /// Returns the smallest Re w over the eigenvalues w of A.
  Scalar smallest_real_part() const;

  /// Solves for Y with the factors of A. Y may be G.
  void solve(const Matrix<Scalar>& G, Matrix<Scalar>& Y);

 private:
  Eigen::HessenbergDecomposition<Matrix<Scalar>> hessenberg_;
  Eigen::ComplexSchur<Matrix<Complex>> schur_;
  Matrix<Scalar> real_;
  Matrix<Complex> Y_, product_;
  Vector<Scalar> workspace_;
};

// Compiled once, in lyapunov_equation.cc.
extern template class Lyapunov<double>;
extern template class Lyapunov<long double>;

}  // namespace stiefel
