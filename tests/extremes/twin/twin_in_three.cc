#include "engine/body/body_invariants.h"
#include "engine/body/exact/euler_top.h"
#include "tests/extremes/twin/twin_of.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel {

/// The twin of `exact`.
auto map_of(Exact, const RigidBody<So3<Quad, true>>& body, Quad h, const MethodOptions&) {
  using Point = So3<Quad, true>::State;
  return closed_form_map<Point>(
      [body](const Point& start) {
        return EulerTop<Quad>(PrincipalMoments3<Quad>(body.lambda()), start);
      },
      h);
}

namespace extremes {

std::unique_ptr<Twin> twin_in_three(const Scene& scene, Perturbation moved) {
  using Body = RigidBody<So3<Quad, true>>;
  const Body body(moved.of<Quad>(scene.inertia()));
  Body::State x;
  x << moved.of<Quad>(scene.attitude()).normalized(), moved.of<Quad>(vee(scene.M()));
  const auto read = [determinant = scene.determinant()](const Body::State& at) {
    const Matrix<Quad> Q = determinant * rotation_matrix<Quad>(at.head<4>());
    const Matrix<Quad> M = hat(at.tail<3>());
    return MotionState{Q.cast<long double>(), M.cast<long double>()};
  };
  const auto energy = [lambda = body.lambda()](const Body::State& at) {
    return stiefel::energy<Quad>(lambda, hat(at.tail<3>()));
  };
  return twin_of(scene, body, x, read, energy);
}

}  // namespace extremes
}  // namespace stiefel
