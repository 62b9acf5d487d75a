#pragma once

#include <Eigen/Geometry>

#include "engine/numbers/scalar.h"

namespace stiefel {

// Sums with a fixed order of additions, the same for numbers and for packs.

template <class Scalar>
Scalar dot(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return (a(0) * b(0) + a(1) * b(1)) + a(2) * b(2);
}
template <class Scalar>
Scalar squared_norm(const Vector3<Scalar>& a) {
  return dot(a, a);
}

/// Returns (a₂b₃, a₃b₁, a₁b₂).
template <class Scalar>
Vector3<Scalar> cyclic_product(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return {a(1) * b(2), a(2) * b(0), a(0) * b(1)};
}

}  // namespace stiefel
