#include <gtest/gtest.h>

#include <cmath>

#include "engine/methods/munthe_kaas4.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"
#include "stiefel/simulation.h"
#include "tests/support/integrate.h"
#include "tests/support/linalg/j_d_schur.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/any_scene.h"
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

/// This test detects a wrong sign of the bracket: Ω(t) does not commute with Ω(0).
TEST(SymmetricRigidBody, MuntheKaas4HasOrder4) {
  for (const int N : {3, 4, 6})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RandomBody random(N, seed);
      const Body body{random.lambda, random.Q, random.M, epsilon_for(random.M)};
      const MatrixXd exact = symmetric_flow(body, 1);
      const double coarse = (symmetric_by_munthe_kaas4(body, 1, 30) - exact).norm();
      const double fine = (symmetric_by_munthe_kaas4(body, 1, 60) - exact).norm();
      EXPECT_NEAR(std::log2(coarse / fine), 4, 0.15) << N << " " << seed << " " << coarse;
    }
}

using Wide = long double;
using Dense = Matrix<Wide>;

/// The vector field of a system in its own variables, two blocks stacked, as the papers print it.
struct OwnField {
  static constexpr const char* name = "own";
  using Scalar = Wide;
  using State = Dense;
  std::function<void(const Dense& x, Dense& dx)> rates;
  void field(const Dense& x, Dense& dx) const { rates(x, dx); }
};

/// Returns J⁻¹(M): Ω_ij = M_ij/(λ_i + λ_j).
Dense angular_velocity(const Scene& scene, Dense M) {
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < M.rows(); ++i)
      M(i, j) /= static_cast<Wide>(scene.inertia()(i)) + static_cast<Wide>(scene.inertia()(j));
  return M;
}

/// Returns the field of a view. [RB] (RightRBn), Prop. 3.4, (8.2), (5.5).
OwnField own_field(const Scene& scene) {
  const std::string system = scene.system();
  const Eigen::Index N = scene.dimension();
  const Wide epsilon = scene.epsilon();
  Dense A(0, 0);
  if (system == "reduced_rigid_body")
    A = scene.block("P").cast<Wide>() * scene.Q().transpose().cast<Wide>();
  return {[=](const Dense& x, Dense& dx) {
    const Dense X = x.topRows(N), Y = x.bottomRows(N);
    if (system == "right_rigid_body") {
      const Dense Omega = angular_velocity(scene, Y);
      dx << Omega * X, Omega * Y - Y * Omega;
    } else if (system == "right_symmetric_rigid_body") {
      const Dense R = Y * X.transpose();
      const Dense Omega = angular_velocity(scene, (R - R.transpose()) / epsilon);
      dx << Omega * X, Omega * Y;
    } else if (system == "reduced_rigid_body") {
      const Dense Omega =
          angular_velocity(scene, X.transpose() * (A - A.transpose()) * X / epsilon);
      dx << X * Omega, A * X * Omega;
    } else {
      const Dense Omega = angular_velocity(scene, X.transpose() * Y);
      dx << X * Omega, Y * Omega;
    }
  }};
}

TEST(BodyViews, MoveByTheirOwnEquations) {
  const std::pair<const char*, const char*> views[] = {{"right_rigid_body", "M"},
                                                       {"right_symmetric_rigid_body", "P"},
                                                       {"reduced_rigid_body", "P"},
                                                       {"mclachlan_scovel", "B"}};
  for (const auto& [system, second] : views)
    for (const char* method : {"variational", "rk4", "adaptive"})
      for (const int N : {3, 4, 5}) {
        SceneDescription d = any_scene(system, method, 7, 0.01, N);
        if (d.method->name == "variational") d.method->order = 8;
        const Scene scene = Scene::resolve(d).value();
        const auto motion = make_simulation(scene);
        const auto state = [&] { return stacked(motion->get("Q"), motion->get(second)); };
        const MatrixXd start = state();
        EXPECT_EQ(start, stacked(scene.Q(), scene.block(second)))
            << "step 0 has the scene's blocks";
        ASSERT_TRUE(motion->advance(100).reached());
        const MatrixXd wanted = flow(own_field(scene), start, 100 * scene.step());
        EXPECT_LT((state() - wanted).norm(), 1e-7 * wanted.norm()) << system << " " << method << N;
        EXPECT_GT((state() - start).norm(), 0.1 * start.norm());
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
