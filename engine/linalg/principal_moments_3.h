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

  bool positive() const { return moments.minCoeff() > Scalar(0); }
};

}  // namespace stiefel
