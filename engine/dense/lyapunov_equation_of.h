#pragma once

#include <cmath>
#include <limits>

#include "engine/dense/householder.h"
#include "engine/dense/lyapunov_equation.h"
#include "engine/dense/symmetric_lyapunov.h"
#include "engine/numbers/stoppable_product.h"
#include "stiefel/stop.h"

// The solution of Lyapunov's equations in any real scalar.
namespace stiefel {

/// Computes the Schur form of the Hessenberg matrix T, and with `vectors` multiplies U by its
/// unitary factor. Iterates in pieces, before each of which it checks for a stop request: with
/// vectors and N = 512 the whole takes seconds.
template <class Complex>
void iterate_schur(Eigen::ComplexSchur<Matrix<Complex>>& schur, const Matrix<Complex>& T,
                   const Matrix<Complex>& U, bool vectors) {
  constexpr Eigen::Index of_piece = 32, most_of_row = 30;
  const auto N = static_cast<double>(T.rows());
  schur.setMaxIterations(of_piece);
  const auto piece = [&](const Matrix<Complex>& from, const Matrix<Complex>& by) {
    stop_point((vectors ? 20 : 10) * of_piece * N * N);
    schur.computeFromHessenberg(from, by, vectors);
  };
  piece(T, U);
  for (Eigen::Index k = of_piece; k < most_of_row * T.rows(); k += of_piece) {
    if (schur.info() == Eigen::Success) return;
    piece(schur.matrixT(), schur.matrixU());
  }
}

template <class Scalar>
Lyapunov<Scalar>::Lyapunov(Eigen::Index N)
    : hessenberg_(N), schur_(N), real_(N, N), Y_(N, N), product_(N, N), workspace_(N) {
  // Initialises the factors with those of the identity, so that a copy made before `factor` reads
  // no uninitialised numbers.
  Y_.setIdentity();
  schur_.computeFromHessenberg(Y_, Y_, false);
}

template <class Scalar>
void Lyapunov<Scalar>::factor(const Matrix<Scalar>& A) {
  stop_point(20 * static_cast<double>(A.rows() * A.size()));
  hessenberg_.compute(A);
  stop_point();
  write_householder_product(hessenberg_, workspace_, real_);
  product_ = real_.template cast<Complex>();
  real_ = hessenberg_.matrixH();
  Y_ = real_.template cast<Complex>();
  iterate_schur(schur_, Y_, product_, true);
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
  write_householder_product(tridiagonal_, workspace_, product_);
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

}  // namespace stiefel
