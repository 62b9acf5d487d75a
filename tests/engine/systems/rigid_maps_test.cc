#include <gtest/gtest.h>

#include <cmath>

#include "engine/frames/body/stiefel_invariants.h"
#include "engine/linalg/lie/orthogonal.h"
#include "engine/methods/variational.h"
#include "engine/rigid_body/body/body_invariants.h"
#include "engine/rigid_body/maps/right_rigid_body_maps.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/maps/symmetric_rigid_body_maps.h"
#include "engine/rigid_body/moser_veselov/moser_veselov_pair.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric/symmetric_invariants.h"
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
using Symmetric = SymmetricMoserVeselov<double>;
using Pairs = MoserVeselovPair<double>;

static_assert(Map<Symmetric> && Map<Pairs> && Map<Transposed<Symmetric>>);

template <class F>
MatrixXd after(F& map, const MatrixXd& x, int steps) {
  auto state = map.start(x);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached()) << k;
  return state.x.value;
}

/// Q_1 by the reference solver, to start algorithm 1 from (Q_0, M_0).
MatrixXd second_frame(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& M, double h) {
  return Q * testing::J_D_inverse_schur(lambda, h * M).value();
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
    // The pair knows hM through Q_1 alone: the Schur solver's 1e-14·Λ_max over the 1e-2 Λ of the
    // wide case would not be enough, so that Q_1 is a step of algorithm 2.
    Plain plain(lambda, h);
    Pairs pairs(lambda, h);
    const MatrixXd Q1 = top(after(plain, stacked(Q0, M0), 1));
    const MatrixXd y = after(pairs, stacked(Q0, Q1), steps);
    EXPECT_LT(largest(top(y) - Q), 1e-12) << c.name();
  }
}

/// Algorithms 1 and 2 and SDRBn, over a unit of time.
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

        Pairs pairs(body.lambda, h);
        const MatrixXd Q1 = second_frame(body.lambda, body.Q, body.M, h);
        const MatrixXd z = after(pairs, stacked(body.Q, Q1), steps);
        EXPECT_LT(largest(top(z) - top(x)), 1e-11) << N << " " << seed << " " << h;
        EXPECT_LT(largest(discrete_momentum<double>(body.lambda, top(z), bottom(z)) / h -
                          spatial_momentum<double>(body.Q, body.M)),
                  1e-11);
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

/// W = UΛ of the last step solves the equation of the next one, so a pair has a next frame unless
/// spec(W) meets the imaginary axis, however far apart the two are; what the principal branch gives
/// need not be U again. Frames that are not numbers: not_finite.
TEST(MoserVeselovPair, StepsFromFramesFarApart) {
  const VectorXd lambda = Eigen::Vector3d(1, 2, 3);
  Pairs pairs(lambda, 0.5);
  const MatrixXd I = MatrixXd::Identity(3, 3);
  // In a plane of rotation hM = (λ_1 + λ_2) sin θ: the solution of the principal branch is π − θ.
  const double angle = 2.5;
  MatrixXd turned = I;
  turned.topLeftCorner(2, 2) << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const MatrixXd x = after(pairs, stacked(I, turned), 1);
  EXPECT_NEAR((top(x).transpose() * bottom(x))(1, 0), std::sin(angle), 1e-14);
  EXPECT_NEAR((top(x).transpose() * bottom(x))(0, 0), -std::cos(angle), 1e-14);

  for (unsigned seed = 1; seed <= 10; ++seed) {
    const RandomBody body(4, seed);
    Pairs map(body.lambda, 0.5);
    const MatrixXd Q0 = body.Q, Q1 = RandomBody(4, seed + 50).Q, U0 = Q0.transpose() * Q1;
    const MatrixXd y = after(map, stacked(Q0, Q1), 1), U = top(y).transpose() * bottom(y);
    const MatrixXd hM = U0.transpose() * J_D<double>(body.lambda, U0) * U0;
    EXPECT_EQ(top(y), Q1);
    EXPECT_LT(largest(U - testing::J_D_inverse_schur(body.lambda, hM).value()), 1e-11) << seed;
  }

  auto lost = pairs.start(stacked(I, I * std::nan("")));
  EXPECT_EQ(pairs.step(lost).outcome, Outcome::not_finite);
}

/// The variational integrator of the other forms: the right ones to the last bit the transposes of
/// the left ones.
TEST(VariationalRigid, OfTheOtherFormsIsTheMoserVeselovMap) {
  const RandomBody body(5, 4);
  constexpr double h = 0.1;
  const double epsilon = epsilon_for(body.M);
  const MatrixXd P = symmetric_P(body.Q, body.M, epsilon);
  using Left = RigidBody<SoN<double>>;
  Variational::Map<Left> left(Left(body.lambda), h, 2);
  Variational::Map<RightRigidBody<double>> right(RightRigidBody<double>(body.lambda), h, 2);
  Variational::Map<SymmetricRigidBody<double>> symmetric(
      SymmetricRigidBody<double>(body.lambda, epsilon), h, 2);
  Variational::Map<RightSymmetricRigidBody<double>> right_symmetric(
      RightSymmetricRigidBody<double>(body.lambda, epsilon), h, 2);
  const MatrixXd x = after(left, stacked(body.Q, body.M), 30);
  const MatrixXd x_r = after(right, stacked(body.Q.transpose(), -body.M), 30);
  EXPECT_EQ(top(x_r), MatrixXd(top(x).transpose()));
  EXPECT_EQ(bottom(x_r), MatrixXd(-bottom(x)));
  const MatrixXd y = after(symmetric, stacked(body.Q, P), 30);
  const MatrixXd y_r = after(right_symmetric, stacked(body.Q.transpose(), P.transpose()), 30);
  EXPECT_LT(largest(top(y) - top(x)), 1e-12);
  EXPECT_EQ(top(y_r), MatrixXd(top(y).transpose()));
  EXPECT_EQ(bottom(y_r), MatrixXd(bottom(y).transpose()));
}

}  // namespace
}  // namespace stiefel
