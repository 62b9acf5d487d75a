#pragma once

#include <Eigen/Householder>
#include <algorithm>
#include <vector>

#include "engine/linalg/lie/skew_flow.h"
#include "engine/numbers/dual.h"

namespace stiefel {

/// exp(tA) in dual numbers, for any t at the same cost. With iA = ZwZ†, D = e^{−iwt} and B = Z†A′Z,
///
///     (exp(tA))′ = Z (φ∘B) Z† + t′ A exp(tA),
///     φ_jk = (D_j − D_k)/(i(w_k − w_j)) = t e^{−i(w_j + w_k)t/2} sinc((w_j − w_k)t/2),
///
/// which has no cancellation where two eigenvalues are close (Daleckii and Krein 1965).
template <class Real, int lanes>
class SkewFlow<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  explicit SkewFlow(const Matrix<Scalar>& A) : A_(values_of(A)), B_(lanes) {
    if (A.rows() == 0) return;
    stop_point(25 * static_cast<double>(A.rows() * A.size()));
    const Matrix<Complex> H = Complex(0, 1) * A_.template cast<Complex>();
    const Eigen::SelfAdjointEigenSolver<Matrix<Complex>> solver(H);
    Z_ = solver.eigenvectors();
    w_ = solver.eigenvalues();
    for (int k = 0; k < lanes; ++k)
      B_[static_cast<std::size_t>(k)] = Z_.adjoint() * lane_of(A, k).template cast<Complex>() * Z_;
  }

  void operator()(Scalar t, Matrix<Scalar>& E) {
    using std::abs, std::cos, std::sin;
    const Eigen::Index n = w_.size();
    E.resize(n, n);
    if (n == 0) return;
    const Real s = t.value;
    Matrix<Complex> D(n, n), phi(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      D.col(j) = Complex(cos(w_(j) * s), -sin(w_(j) * s)) * Z_.col(j);
      for (Eigen::Index i = 0; i < n; ++i) {
        const Real mean = (w_(i) + w_(j)) * s / 2, half = (w_(i) - w_(j)) * s / 2;
        const Real sinc = half == 0 ? Real(1) : sin(half) / half;
        phi(i, j) = s * sinc * Complex(cos(mean), -sin(mean));
      }
    }
    const Matrix<Real> exponential = (D * Z_.adjoint()).real(), velocity = A_ * exponential;
    set_values(E, exponential);
    for (int k = 0; k < lanes; ++k) {
      const Matrix<Complex> part = phi.cwiseProduct(B_[static_cast<std::size_t>(k)]);
      set_lane(E, k, (Z_ * part * Z_.adjoint()).real() + t.d[k] * velocity);
    }
  }

 private:
  using Complex = std::complex<Real>;

  Matrix<Real> A_;
  std::vector<Matrix<Complex>> B_;
  Matrix<Complex> Z_;
  Vector<Real> w_;
};

/// orthonormal_columns (orthogonal.h) in dual numbers, for A of full rank.
template <class Real, int lanes>
Matrix<Dual<Real, lanes>> orthonormal_columns(Matrix<Dual<Real, lanes>> A, Eigen::Index k) {
  using Scalar = Dual<Real, lanes>;
  const Eigen::Index N = A.rows(), m = std::min(k, A.cols());
  Vector<Scalar> factors(m), workspace(std::max(k, A.cols()));
  Scalar length;
  for (Eigen::Index j = 0; j < m; ++j) {
    stop_point(2 * static_cast<double>(A.size()));
    A.col(j).tail(N - j).makeHouseholderInPlace(factors(j), length);
    A.bottomRightCorner(N - j, A.cols() - j - 1)
        .applyHouseholderOnTheLeft(A.col(j).tail(N - j - 1), factors(j), workspace.data());
  }
  Matrix<Scalar> H = Matrix<Scalar>::Identity(N, k);
  for (Eigen::Index j = m - 1; j >= 0; --j) {
    stop_point(2 * static_cast<double>(H.size()));
    H.bottomRightCorner(N - j, k - j)
        .applyHouseholderOnTheLeft(A.col(j).tail(N - j - 1), factors(j), workspace.data());
  }
  return H;
}

}  // namespace stiefel
