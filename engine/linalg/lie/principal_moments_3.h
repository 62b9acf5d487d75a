#pragma once

#include <cmath>

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// The principal moments of Λ in three dimensions, and their differences without cancellation.
template <class Scalar>
struct PrincipalMoments3 {
  Vector3<Scalar> moments;      ///< I₁ = λ₂ + λ₃ and cyclic
  Vector3<Scalar> differences;  ///< I₂ − I₃ = λ₃ − λ₂ and cyclic

  PrincipalMoments3(const Vector3<Scalar>& I, const Vector3<Scalar>& I_differences)
      : moments(I), differences(I_differences) {}

  template <class Derived>
  explicit PrincipalMoments3(const Eigen::MatrixBase<Derived>& lambda) {
    const Vector3<Scalar> l = lambda.template cast<Scalar>();
    moments << l(1) + l(2), l(2) + l(0), l(0) + l(1);
    differences << l(2) - l(1), l(0) - l(2), l(1) - l(0);
  }

  /// Λ; the smaller two from the smallest moment, which is their sum.
  Vector3<Scalar> lambda() const {
    Eigen::Index i;
    const Scalar least = moments.minCoeff(&i);
    const Eigen::Index j = (i + 1) % 3, k = (i + 2) % 3;
    Vector3<Scalar> l;
    l(j) = (least - differences(i)) / 2;
    l(k) = (least + differences(i)) / 2;
    l(i) = moments(j) - l(k);
    return l;
  }

  /// |c|² below which a solution c is on the branch of the identity: where the symmetric part of
  /// (tr UΛ) − UΛ, whose eigenvalues are w_i + w_j with w = spec(UΛ), cannot but be positive. No
  /// λ_i < 0: that of Λ^{1/2}UΛ^{1/2} is for |c| < 1. Else, with D = max |λ_i − λ_j| and L = Σ|λ_i|
  /// + max |λ_i|, it differs by 2D|c| + 2L|c|² at most from I.
  Scalar nearness() const {
    using std::sqrt;
    const Vector3<Scalar> l = lambda();
    if (l.minCoeff() >= Scalar(0)) return Scalar(1);
    const Scalar D = differences.cwiseAbs().maxCoeff(), least = moments.minCoeff();
    const Scalar L = l.cwiseAbs().sum() + l.cwiseAbs().maxCoeff();
    const Scalar r = least / (D + sqrt(Scalar(D * D + 2 * L * least)));
    return r * r;
  }
};

}  // namespace stiefel
