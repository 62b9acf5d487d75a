#pragma once

#include "engine/linalg/scalar.h"

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
};

}  // namespace stiefel
