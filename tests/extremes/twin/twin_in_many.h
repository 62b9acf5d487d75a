#pragma once

#include "engine/body/body_invariants.h"
#include "engine/dense/orthogonal.h"
#include "tests/extremes/twin/twin_of.h"

namespace stiefel::extremes {

template <class Scalar>
std::unique_ptr<Twin> twin_in_many_in(const Scene& scene, Perturbation moved) {
  using Body = RigidBody<SoN<Scalar>>;
  const Body body(moved.of<Scalar>(scene.inertia()));
  const Eigen::Index N = scene.dimension();
  Matrix<Scalar> x(2 * N, N);
  x << nearest_orthogonal(moved.of<Scalar>(scene.Q())), moved.of_skew<Scalar>(scene.M());
  const auto read = [N](const Matrix<Scalar>& at) {
    return MotionState{at.topRows(N).template cast<long double>(),
                       at.bottomRows(N).template cast<long double>()};
  };
  const auto energy = [N, lambda = body.lambda()](const Matrix<Scalar>& at) {
    return stiefel::energy<Scalar>(lambda, at.bottomRows(N));
  };
  return twin_of(scene, body, x, read, energy);
}

}  // namespace stiefel::extremes
