#pragma once

#include "engine/dense/decompositions.h"
#include "engine/dense/so_3.h"
#include "engine/dense/so_n.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The Cayley transform U = (I − a)⁻¹(I + a) on a pair (Q, M), a ∈ so(N):
///
///     displacement:  (QU − Q, UᵀMU − M),
///     midpoint:      M̃ with M = (I + a)M̃(I − a), so UᵀMU = (I − a)M̃(I + a); leaves Q unset.
template <class Space>
class CayleyMidpoint;

template <class Scalar>
class CayleyMidpoint<SoN<Scalar>> {
 public:
  explicit CayleyMidpoint(Eigen::Index N) : N_(N), lu_(N), X_(N, N), Y_(N, N) {}

  void midpoint(const Matrix<Scalar>& x, const Matrix<Scalar>& a, Matrix<Scalar>& middle) {
    factor(a);
    lu_.solve(x.bottomRows(N_), X_);
    Y_ = X_.transpose();
    lu_.solve(Y_, X_);
    middle.bottomRows(N_) = X_.transpose();
  }

  /// Uses D = U − I = −2((I + a)⁻¹a)ᵀ and Y = MD + ½DᵀMD: UᵀMU − M = Y − Yᵀ.
  void displacement(const Matrix<Scalar>& x, const Matrix<Scalar>& a, Matrix<Scalar>& dx) {
    factor(a);
    lu_.solve(a, X_);
    X_ *= Scalar(-2);
    dx.noalias() = x * X_.transpose();
    Y_ = dx.bottomRows(N_);
    Y_.noalias() += Scalar(0.5) * X_ * dx.bottomRows(N_);
    dx.bottomRows(N_) = Y_ - Y_.transpose();
  }

 private:
  void factor(const Matrix<Scalar>& a) {
    X_ = a;
    X_.diagonal().array() += Scalar(1);
    stop_point();
    lu_.factor(X_);
  }

  Eigen::Index N_;
  Lu<Scalar> lu_;
  Matrix<Scalar> X_, Y_;
};

// Compiled once, in decompositions.cc.
extern template class CayleyMidpoint<SoN<double>>;

/// The transform in three dimensions: m̃ = (m − c×m)/(1 + |c|²), U = (1, c)/|(1, c)| as a
/// quaternion.
template <class Scalar, bool frame>
class CayleyMidpoint<So3<Scalar, frame>> {
 public:
  using State = typename So3<Scalar, frame>::State;
  explicit CayleyMidpoint(Eigen::Index) {}

  void midpoint(const State& x, const Vector3<Scalar>& c, State& middle) const {
    const Vector3<Scalar> m = x.template tail<3>();
    middle.template tail<3>() = (m - c.cross(m)) / (1 + c.squaredNorm());
  }

  void displacement(const State& x, const Vector3<Scalar>& c, State& dx) const {
    using std::sqrt;
    const Scalar c2 = c.squaredNorm(), norm = sqrt(1 + c2);
    if constexpr (frame)
      dx.template head<4>() =
          So3<Scalar, frame>::quaternion_times(x, -c2 / (norm * (1 + norm)), (c / norm).eval());
    const Vector3<Scalar> turn = c.cross(x.template tail<3>());
    dx.template tail<3>() = (c.cross(turn) - turn) * (2 / (1 + c2));
  }
};

}  // namespace stiefel
