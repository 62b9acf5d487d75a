#include <gtest/gtest.h>

#include <cmath>

#include "engine/body/body_invariants.h"
#include "engine/body/psi.h"
#include "engine/body/rigid_body_maps.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel_invariants.h"
#include "engine/methods/variational.h"
#include "tests/support/linalg/j_d_schur.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"

namespace stiefel {
namespace {

using testing::bottom;
using testing::largest;
using testing::top;
using namespace testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using Plain = MoserVeselov<SoN<double>>;
using Symmetric = SymmetricMoserVeselov;

static_assert(Map<Symmetric>);

template <class F>
MatrixXd after(F& map, const MatrixXd& x, int steps) {
  auto state = map.start(x);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached()) << k;
  return state.x.value;
}

TEST(DiscreteRigidBodies, ReproduceTheReference) {
  for (const ReferenceCase& c : reference_cases("moser_veselov")) {
    const VectorXd lambda = c.vector("inertia");
    const MatrixXd Q0 = c.matrix("Q0"), M0 = c.matrix("M0"), Q = c.matrix("Q"), M = c.matrix("M");
    const double h = c.number("h"), epsilon = epsilon_for(M0);
    const int steps = static_cast<int>(c.number("steps"));
    const double size = largest(M0);
    Symmetric symmetric(lambda, h, epsilon);
    const MatrixXd x = after(symmetric, stacked(Q0, symmetric_P(Q0, M0, epsilon)), steps);
    EXPECT_LT(largest(top(x) - Q), 1e-12) << c.name();
    EXPECT_LT(largest(Psi<double>(top(x), bottom(x), epsilon) - M), 1e-12 * size) << c.name();
  }
}

/// Algorithm 2 and SDRBn, over a unit of time.
TEST(DiscreteRigidBodies, AgreeWithEachOther) {
  for (const int N : {2, 3, 4, 7})
    for (unsigned seed = 1; seed <= 4; ++seed)
      for (const double h : {0.01, 0.1, -0.2}) {
        const RandomBody body(N, seed);
        const int steps = static_cast<int>(std::lround(1 / std::abs(h)));
        const double epsilon = epsilon_for(body.M);
        Plain plain(body.lambda, h);
        const MatrixXd x = after(plain, stacked(body.Q, body.M), steps);
        Symmetric symmetric(body.lambda, h, epsilon);
        const MatrixXd P = symmetric_P(body.Q, body.M, epsilon);
        const MatrixXd y = after(symmetric, stacked(body.Q, P), steps);
        EXPECT_LT(largest(top(y) - top(x)), 1e-12);
        EXPECT_LT(largest(Psi<double>(top(y), bottom(y), epsilon) - bottom(x)), 1e-11);
        EXPECT_LT(largest(constant_A<double>(top(y), bottom(y)) - constant_A<double>(body.Q, P)),
                  1e-13);
      }
}

/// ε = h are the paper's own variables, (4.7) without h; another ε, the same motion.
TEST(SymmetricMoserVeselov, EpsilonIsOnlyAScale) {
  const RandomBody body(5, 2);
  constexpr double h = 0.1;
  Symmetric own(body.lambda, h, h), unit(body.lambda, 1, 1), other(body.lambda, h, 0.03);
  const MatrixXd P = symmetric_P(body.Q, body.M, h);
  const MatrixXd x = after(own, stacked(body.Q, P), 50);
  EXPECT_LT(largest(after(unit, stacked(body.Q, P), 50) - x), 1e-13);
  const MatrixXd y = after(other, stacked(body.Q, symmetric_P(body.Q, body.M, 0.03)), 50);
  EXPECT_LT(largest(top(y) - top(x)), 1e-12);
}

/// Where there is no step, each map ends with left_domain and the largest step of the Moser–Veselov
/// map of the same (Q, M), and leaves the state unchanged.
TEST(DiscreteRigidBodies, EdgesOfTheirDomain) {
  int left = 0;
  for (const int N : {3, 4, 6})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const RandomBody body(N, seed);
      constexpr double h = 3;
      const double epsilon = epsilon_for(body.M);
      const MatrixXd x = stacked(body.Q, symmetric_P(body.Q, body.M, epsilon));
      Plain plain(body.lambda, h);
      Symmetric symmetric(body.lambda, h, epsilon);
      auto state = plain.start(stacked(body.Q, body.M));
      auto other = symmetric.start(x);
      const RunStatus wanted = plain.step(state), status = symmetric.step(other);
      ASSERT_EQ(wanted.outcome, status.outcome);
      if (wanted.reached()) continue;
      ++left;
      EXPECT_NEAR(*status.largest_step, *wanted.largest_step, 1e-3 * *wanted.largest_step);
      EXPECT_EQ(other.x.value, x);
      Symmetric inside(body.lambda, *status.largest_step, epsilon);
      auto in = inside.start(x);
      EXPECT_TRUE(inside.step(in).reached());
      EXPECT_FALSE(testing::J_D_inverse_schur(body.lambda, 1.0015 * *status.largest_step * body.M));
    }
  EXPECT_GE(left, 6);
}

}  // namespace
}  // namespace stiefel
