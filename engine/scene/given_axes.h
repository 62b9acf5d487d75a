#pragma once

#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The principal axes of a body, computed in Scalar from its doubles: I = R diag(moments) Rᵀ, det R
/// = +1. Moments and a diagonal tensor keep their axes and their order, R = 1.
template <class Scalar>
struct GivenAxes {
  Vector3<Scalar> moments;
  Eigen::Matrix<Scalar, 3, 3> rotation;
};

template <class Scalar>
GivenAxes<Scalar> given_axes(const BodyDescription& body);

// Compiled once, in given_axes.cc.
extern template GivenAxes<long double> given_axes(const BodyDescription& body);
extern template GivenAxes<Quad> given_axes(const BodyDescription& body);

}  // namespace stiefel
