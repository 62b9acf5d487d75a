#include "engine/dense/orthogonal.h"
#include "engine/frame/frame_pass_on.h"
#include "engine/frame/stiefel_invariants.h"
#include "tests/extremes/twin/twin_of.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel::extremes {

std::unique_ptr<Twin> twin_of_frames(const Scene& scene, Perturbation moved) {
  const Eigen::Index n = scene.Q().rows();
  const Stiefel<Quad> system(moved.of<Quad>(scene.inertia()), n);
  Matrix<Quad> x(2 * n, scene.dimension());
  x << nearest_orthogonal(moved.of<Quad>(scene.Q())), moved.of<Quad>(scene.block("S"));
  const auto read = [n](const Matrix<Quad>& at) {
    return MotionState{at.topRows(n).cast<long double>(), at.bottomRows(n).cast<long double>()};
  };
  const auto energy = [n, lambda = system.lambda()](const Matrix<Quad>& at) {
    return stiefel_energy<Quad>(lambda, at.bottomRows(n));
  };
  return twin_of(scene, system, x, read, energy);
}

}  // namespace stiefel::extremes
