#pragma once

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Moves Q over P, 2n × N, with almost orthonormal rows of Q, onto the frames: Q ← gQ, P ← g⁻ᵀP, gQ
/// the frame nearest to Q, by Newton–Schulz steps g = I − ½(QQᵀ − I). QᵀP − PᵀQ stays, up to the
/// square of the defect QQᵀ − I. Leaves a state whose defect is rounding, or not below 1. Does not
/// allocate after construction.
template <class Scalar>
class FrameProjection {
 public:
  explicit FrameProjection(Eigen::Index n) : n_(n), half_defect_(n, n), column_(n) {}

  void operator()(Matrix<Scalar>& x) {
    constexpr int most = 8;
    constexpr Scalar rounding = 4 * Eigen::NumTraits<Scalar>::epsilon();
    auto Q = x.topRows(n_), P = x.bottomRows(n_);
    for (int k = 0; k < most; ++k) {
      half_defect_.setZero();
      for (Eigen::Index j = 0; j < x.cols(); ++j)
        half_defect_.noalias() += Scalar(0.5) * Q.col(j) * Q.col(j).transpose();
      half_defect_.diagonal().array() -= Scalar(0.5);
      const Scalar defect = 2 * half_defect_.cwiseAbs().maxCoeff();
      if (defect <= rounding || !(defect < 1)) return;
      for (Eigen::Index j = 0; j < x.cols(); ++j) {
        column_.noalias() = half_defect_ * Q.col(j);
        Q.col(j) -= column_;
        column_.noalias() = half_defect_ * P.col(j);
        P.col(j) += column_;
      }
    }
  }

 private:
  Eigen::Index n_;
  Matrix<Scalar> half_defect_;
  Vector<Scalar> column_;
};

}  // namespace stiefel
