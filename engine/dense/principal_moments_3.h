#pragma once

#include <cmath>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// The principal moments of Λ in three dimensions and their differences, computed without
/// cancellation.
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

  /// Returns Λ. The two smaller λ are computed from the smallest moment, which is their sum.
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

  /// Returns a bound of |c|² below which a solution c is certainly on the branch of the identity.
  /// Below it the symmetric part of (tr UΛ)I − UΛ, a matrix with the eigenvalues w_i + w_j, w =
  /// spec(UΛ), is positive. If no λ_i < 0, the symmetric part of Λ^{1/2}UΛ^{1/2} is positive for
  /// |c| < 1. Otherwise, with D = max |λ_i − λ_j| and L = Σ|λ_i| + max |λ_i|, the symmetric part of
  /// (tr UΛ)I − UΛ differs by at most 2D|c| + 2L|c|² from diag(I₁, I₂, I₃), its value at c = 0.
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
