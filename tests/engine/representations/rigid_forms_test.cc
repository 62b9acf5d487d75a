#include <gtest/gtest.h>

#include <cmath>

#include "engine/body/psi.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/methods/munthe_kaas4.h"
#include "stiefel/simulation.h"
#include "tests/support/integrate.h"
#include "tests/support/linalg/j_d_schur.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"
#include "tests/support/scenes/stacked.h"

namespace stiefel {
namespace {

using testing::bottom;
using testing::top;
using namespace testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Body {
  VectorXd lambda;
  MatrixXd Q, M;
  double epsilon;

  MatrixXd pair() const { return stacked(Q, symmetric_P(Q, M, epsilon)); }
};

MatrixXd symmetric_by_munthe_kaas4(const Body& body, double t, int steps) {
  using System = SymmetricRigidBody<double>;
  MuntheKaas4::Map<System> map(System(body.lambda, body.epsilon), t / steps, 4);
  auto state = map.start(body.pair());
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
  return state.x.value;
}
MatrixXd symmetric_flow(const Body& body, double t) {
  return flow(SymmetricRigidBody<long double>(body.lambda.cast<long double>(), body.epsilon),
              body.pair(), t);
}

TEST(SymmetricRigidBody, ReproducesTheReference) {
  for (const ReferenceCase& c : reference_cases("rigid_body")) {
    Body body{c.vector("inertia"), c.matrix("Q0"), c.matrix("M0"), 0};
    body.epsilon = epsilon_for(body.M);
    const bool hard = c.name().find("wide") != std::string::npos ||
                      c.name().find("intermediate") != std::string::npos;
    // The hard ones magnify the rounding of P (200 at Λ = 1:10⁵, 10⁴ away from the axis).
    const double bound = hard ? 1e-9 : 1e-10;
    const auto expect_reached = [&](const MatrixXd& x) {
      EXPECT_LT((top(x) - c.matrix("Q")).norm(), bound) << c.name();
      EXPECT_LT((Psi<double>(top(x), bottom(x), body.epsilon) - c.matrix("M")).norm(),
                bound * c.matrix("M").norm())
          << c.name();
    };
    expect_reached(symmetric_flow(body, c.number("t")));
    if (!hard) expect_reached(symmetric_by_munthe_kaas4(body, c.number("t"), 2000));
  }
}

/// (4.4): U_{k−1} = Q_{k−1}ᵀQ_k and hM_k = ΛU_{k−1} − U_{k−1}ᵀΛ, U_k = J_D⁻¹(hM_k) on the principal
/// branch. W = UΛ of the last step solves the equation of the next one, so a pair has a next frame
/// unless spec(W) meets the imaginary axis, however far apart the two are.
TEST(BodyViews, APairMovesByAlgorithm1) {
  for (const int N : {3, 4, 6})
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const RandomBody body(N, seed);
      const MatrixXd far = RandomBody(N, seed + 50).Q;
      SceneDescription d;
      d.system = "moser_veselov_pair";
      d.inertia.assign(body.lambda.begin(), body.lambda.end());
      d.step = 0.5;
      const bool near = seed % 2;
      const MatrixXd U = testing::J_D_inverse_schur(body.lambda, 0.1 * body.M).value();
      d.initial["Q_prev"] = RowMatrix(body.Q);
      d.initial["Q"] = RowMatrix(near ? MatrixXd(body.Q * U) : far);
      const Scene scene = Scene::resolve(d).value();
      const auto motion = make_simulation(scene);
      MatrixXd before = scene.block("Q_prev"), now = scene.Q();
      for (int k = 0; k < 5; ++k) {
        EXPECT_LT((motion->get("Q_prev") - before).norm(), 1e-10) << N << " " << seed << " " << k;
        EXPECT_LT((motion->get("Q") - now).norm(), 1e-10) << N << " " << seed << " " << k;
        const MatrixXd W = body.lambda.asDiagonal() * (before.transpose() * now);
        const auto next = testing::J_D_inverse_schur(body.lambda, W - W.transpose());
        ASSERT_TRUE(next);
        const MatrixXd after = now * *next;
        before = std::exchange(now, after);
        ASSERT_TRUE(motion->advance(1).reached());
      }
    }
}

}  // namespace
}  // namespace stiefel
