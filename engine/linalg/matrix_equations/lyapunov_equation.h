#pragma once

#include <Eigen/Eigenvalues>
#include <complex>

#include "engine/linalg/matrix_equations/householder.h"
#include "engine/linalg/matrix_equations/stoppable_schur.h"
#include "engine/numbers/stoppable_product.h"
#include "stiefel/stop.h"

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
  Eigen::HessenbergDecomposition<Matrix<Complex>> hessenberg_;
  Eigen::ComplexSchur<Matrix<Complex>> schur_;
  Matrix<Complex> Y_, product_;
  Vector<Complex> workspace_;
};

template <class Scalar>
Lyapunov<Scalar>::Lyapunov(Eigen::Index N)
    : hessenberg_(N), schur_(N), Y_(N, N), product_(N, N), workspace_(N) {
  // Initialises the factors with those of the identity, so that a copy made before `factor` reads
  // no uninitialised numbers.
  Y_.setIdentity();
  schur_.computeFromHessenberg(Y_, Y_, false);
}

template <class Scalar>
void Lyapunov<Scalar>::factor(const Matrix<Scalar>& A) {
  stop_point(20 * static_cast<double>(A.rows() * A.size()));
  Y_ = A.template cast<Complex>();
  hessenberg_.compute(Y_);
  stop_point();
  write_householder_product(hessenberg_.packedMatrix(), hessenberg_.householderCoefficients(),
                            workspace_, product_);
  Y_ = hessenberg_.matrixH();
  stop_point(60 * static_cast<double>(A.rows() * A.size()));
  schur_.computeFromHessenberg(Y_, product_);
}

template <class Scalar>
Scalar Lyapunov<Scalar>::smallest_pair_sum() const {
  Scalar least = std::numeric_limits<Scalar>::infinity(), second = least;
  for (Eigen::Index i = 0; i < Y_.rows(); ++i) {
    const Scalar w = schur_.matrixT()(i, i).real();
    if (w < least) {
      second = least;
      least = w;
    } else if (w < second) {
      second = w;
    }
  }
  return least + second;
}

template <class Scalar>
Scalar Lyapunov<Scalar>::smallest_real_part() const {
  return schur_.matrixT().diagonal().real().minCoeff();
}

template <class Scalar>
void Lyapunov<Scalar>::solve(const Matrix<Scalar>& G, Matrix<Scalar>& Y) {
  const auto& Z = schur_.matrixU();
  const auto& T = schur_.matrixT();
  const Eigen::Index N = Y_.rows();
  Y_ = G.template cast<Complex>();
  stop_point();
  stoppable_product(Z.adjoint(), Y_, product_);
  stop_point();
  stoppable_product(product_, Z, Y_);
  for (Eigen::Index j = 0; j < N; ++j) {
    stop_point(6 * static_cast<double>(N * N));
    for (Eigen::Index k = 0; k < j; ++k) Y_.col(j) -= T(k, j) * Y_.col(k);
    for (Eigen::Index i = 0; i < N; ++i) {
      Complex sum = Y_(i, j);
      for (Eigen::Index k = 0; k < i; ++k) sum -= std::conj(T(k, i)) * Y_(k, j);
      Y_(i, j) = sum / (std::conj(T(i, i)) + T(j, j));
    }
  }
  stop_point(16 * static_cast<double>(N * N * N));
  stoppable_product(Z, Y_, product_);
  stop_point();
  stoppable_product(product_, Z.adjoint(), Y_);
  Y = Y_.real();
}

// Compiled once, in instances.cc.
extern template class Lyapunov<double>;
extern template class Lyapunov<long double>;

}  // namespace stiefel
