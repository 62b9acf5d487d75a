#include <gtest/gtest.h>

#include "engine/body/moser_veselov.h"
#include "engine/body/psi.h"
#include "engine/body/rigid_body.h"
#include "engine/methods/rk4.h"
#include "engine/structure/symplectic_defect.h"
#include "engine/structure/tangent_spaces.h"
#include "tests/support/linalg/j_d_inverse.h"
#include "tests/support/one_step.h"
#include "tests/support/scenes/random_matrices.h"

namespace stiefel {
namespace {

using Space = SoN<double>;
using testing::one_step, testing::stacked;

template <class Scalar>
struct Body {
  Vector<Scalar> lambda;
  Matrix<Scalar> x;
  Body(int N, unsigned seed) {
    testing::RandomMatrices<Scalar> random(seed);
    lambda = random.lambda(N);
    const Matrix<Scalar> Q = random.frame(N, N), M = random.skew(N);
    x = stacked(Q, M * (Scalar(2) / skew_norm(M)));
  }
};

/// The Moser–Veselov map of the engine, in its own double arithmetic.
TEST(SymplecticDefect, OfMoserVeselovIsRounding) {
  for (const int N : {3, 4})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const Body<double> body(N, seed);
      MoserVeselov<Space> map(body.lambda, 0.2, Arithmetic::plain);
      const auto defect =
          symplectic_defect<double>(CotangentOfRotations<double>(), one_step(map), body.x);
      ASSERT_TRUE(defect);
      EXPECT_LT(*defect, 2e-12) << N << " " << seed;
    }
}

/// Its defect is that of order 5 in h: 32 times smaller at half the step.
TEST(SymplecticDefect, OfRk4IsItsLocalError) {
  const Body<double> body(4, 2);
  const auto at = [&](double h) {
    Rk4::Map<RigidBody<Space>> map(RigidBody<Space>(body.lambda), h, {4, Arithmetic::plain});
    return *symplectic_defect<double>(CotangentOfRotations<double>(), one_step(map), body.x);
  };
  const double coarse = at(0.4), fine = at(0.2);
  EXPECT_GT(fine, 1e-9);
  EXPECT_NEAR(std::log2(coarse / fine), 5, 0.6);
}

/// A wider scalar lowers the floor: (MDRBn) and (SDRBn) by the test's own J_D⁻¹.
TEST(SymplecticDefect, HasALowerFloorInAWiderScalar) {
  using Wide = long double;
  const Body<Wide> body(3, 4);
  const Wide h = 0.2L;
  const auto step = [&](const Matrix<Wide>& x) -> std::optional<Matrix<Wide>> {
    const Matrix<Wide> M = x.bottomRows(3), U = testing::J_D_inverse<Wide>(body.lambda, h * M);
    return stacked(x.topRows(3) * U, U.transpose() * M * U);
  };
  EXPECT_LT(*symplectic_defect<Wide>(CotangentOfRotations<Wide>(), step, body.x), 1e-15);
  const Matrix<Wide> Q = body.x.topRows(3), M = body.x.bottomRows(3);
  const auto symmetric = [&](const Matrix<Wide>& x) -> std::optional<Matrix<Wide>> {
    return x * testing::J_D_inverse<Wide>(body.lambda, Psi<Wide>(x.topRows(3), x.bottomRows(3)));
  };
  const Matrix<Wide> pair = stacked(Q, *Psi_inverse<Wide>(Q, M, h));
  EXPECT_LT(
      *symplectic_defect<Wide>(PairsOfRotations<Wide>{Vector<Wide>::Ones(3)}, symmetric, pair),
      1e-15);
}

/// The variational step for n = 1, where it is a quadratic equation, on (q, s), s = q̇Λ; and
/// Euler's.
TEST(SymplecticDefect, OfTheSphere) {
  testing::RandomMatrices<double> random(5);
  const Vector<double> lambda = random.lambda(4), inverse = lambda.cwiseInverse();
  const Matrix<double> q = random.frame(1, 4), qdot = q * random.skew(4);
  const Matrix<double> x = stacked(q, qdot * lambda.asDiagonal());
  const double h = 0.1;
  const auto rattle = [&](const Matrix<double>& y) -> std::optional<Matrix<double>> {
    const Eigen::RowVectorXd Q = y.row(0), S = y.row(1), g = Q * inverse.asDiagonal();
    const Eigen::RowVectorXd d = Q + h * S * inverse.asDiagonal();
    const double a = g.squaredNorm(), b = g.dot(d), c = d.squaredNorm() - 1;
    const double Y = -c / (b + std::sqrt(b * b - a * c));
    const Eigen::RowVectorXd Q_next = d + Y * g, weighted = Q_next * inverse.asDiagonal();
    const Eigen::RowVectorXd S_half = S + Y / h * Q;
    const Eigen::RowVectorXd S_next = S_half - weighted.dot(S_half) / weighted.dot(Q_next) * Q_next;
    return stacked(Q_next, S_next);
  };
  const CotangentOfFrames<double> space{lambda};
  EXPECT_LT(*symplectic_defect<double>(space, rattle, x), 2e-12);
  const auto euler = [&](const Matrix<double>& y) -> std::optional<Matrix<double>> {
    const Eigen::RowVectorXd Q = y.row(0), S = y.row(1), v = S * inverse.asDiagonal();
    const double B = -v.squaredNorm() / (Q * inverse.asDiagonal()).dot(Q);
    return stacked(Q + h * v, S + h * B * Q);
  };
  EXPECT_GT(*symplectic_defect<double>(space, euler, x), 1e-4);
}

TEST(SymplecticDefect, IsSeededAndSilentWhereThereIsNoStep) {
  const Body<double> body(3, 6);
  Rk4::Map<RigidBody<Space>> map(RigidBody<Space>(body.lambda), 0.2, {4, Arithmetic::plain});
  const CotangentOfRotations<double> space;
  const double first = *symplectic_defect<double>(space, one_step(map), body.x);
  EXPECT_EQ(*symplectic_defect<double>(space, one_step(map), body.x), first);
  EXPECT_NE(*symplectic_defect<double>(space, one_step(map), body.x, 8, 2), first);
  const auto none = [](const Matrix<double>&) { return std::optional<Matrix<double>>(); };
  EXPECT_FALSE(symplectic_defect<double>(space, none, body.x));
}

}  // namespace
}  // namespace stiefel
