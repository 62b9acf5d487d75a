#pragma once

#include "engine/linalg/matrix_equations/constraint_riccati.h"
#include "engine/linalg/matrix_equations/lyapunov_equation.h"
#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"
#include "engine/numbers/dual.h"

namespace stiefel {

// Matrix equations in dual numbers: the values by the solver for them, the derivatives by one more
// solve with the same factors along each direction.

/// KX + XK = E:   KX′ + X′K = E′ − K′X − XK′.
template <class Real, int lanes>
class SymmetricLyapunov<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  explicit SymmetricLyapunov(Eigen::Index n) : values_(n) {}

  void factor(const Matrix<Scalar>& K) {
    K_ = K;
    values_.factor(values_of(K));
  }
  /// X may be E.
  void solve(const Matrix<Scalar>& E, Matrix<Scalar>& X) {
    Matrix<Scalar> found(E.rows(), E.cols());
    found.setZero();
    Matrix<Real> part = values_of(E);
    values_.solve(part, part);
    set_values(found, part);
    const Matrix<Scalar> rest = E - K_ * found - found * K_;
    for (int k = 0; k < lanes; ++k) {
      part = lane_of(rest, k);
      values_.solve(part, part);
      set_lane(found, k, part);
    }
    X = found;
  }

 private:
  SymmetricLyapunov<Real> values_;
  Matrix<Scalar> K_;
};

/// AᵀY + YA = G:   AᵀY′ + Y′A = G′ − A′ᵀY − YA′.
template <class Real, int lanes>
class Lyapunov<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  explicit Lyapunov(Eigen::Index N) : values_(N) {}

  void factor(const Matrix<Scalar>& A) {
    A_ = A;
    values_.factor(values_of(A));
  }
  /// Y may be G.
  void solve(const Matrix<Scalar>& G, Matrix<Scalar>& Y) {
    Matrix<Scalar> found(G.rows(), G.cols());
    found.setZero();
    Matrix<Real> part = values_of(G);
    values_.solve(part, part);
    set_values(found, part);
    const Matrix<Scalar> rest = G - A_.transpose() * found - found * A_;
    for (int k = 0; k < lanes; ++k) {
      part = lane_of(rest, k);
      values_.solve(part, part);
      set_lane(found, k, part);
    }
    Y = found;
  }

 private:
  Lyapunov<Real> values_;
  Matrix<Scalar> A_;
};

/// R(Y) = E + YA + AᵀY + YPY = 0, C = A + PY:   CᵀY′ + Y′C = −R′ at constant Y.
template <class Real, int lanes>
class ConstraintRiccati<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  explicit ConstraintRiccati(Eigen::Index n) : values_(n), lyapunov_(n) {}

  /// Starts from the values of the given Y.
  bool solve(const Matrix<Scalar>& A, const Matrix<Scalar>& P, const Matrix<Scalar>& E,
             Matrix<Scalar>& Y) {
    const Matrix<Real> A_values = values_of(A), P_values = values_of(P);
    Matrix<Real> found = values_of(Y);
    if (!values_.solve(A_values, P_values, values_of(E), found)) return false;
    lyapunov_.factor(A_values + P_values * found);
    Y = found.template cast<Scalar>();
    const Matrix<Scalar> YA = Y * A, R = E + YA + YA.transpose() + Y * P * Y;
    for (int k = 0; k < lanes; ++k) {
      Matrix<Real> part = -lane_of(R, k);
      lyapunov_.solve(part, part);
      set_lane(Y, k, (part + part.transpose()) / 2);
    }
    return true;
  }

 private:
  ConstraintRiccati<Real> values_;
  Lyapunov<Real> lyapunov_;
};

}  // namespace stiefel
