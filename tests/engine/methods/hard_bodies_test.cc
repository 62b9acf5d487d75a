#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "engine/body/j_d/cayley_n.h"
#include "engine/body/rigid_body.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/newton_krylov.h"
#include "engine/dense/orthogonal.h"
#include "stiefel/diagnosis.h"
#include "stiefel/stop.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::RandomBody;

/// On a rod of thickness 1e-12 M × Ω cancels to 1e-13 of its terms; [Λ, Ω²] does not.
TEST(HardBodies, TheFieldOfAThinRodKeepsItsDigits) {
  Eigen::VectorXd lambda = Eigen::Vector3d(0.4e-12, 0.6e-12, 1);
  const Eigen::Vector3d m(0.5, -0.7, 1e-12);
  RigidBody<So3<double, false>> body(lambda);
  Eigen::Vector3d dm;
  body.field(m, dm);
  RigidBody<SoN<double>> body_n(lambda);
  Eigen::MatrixXd dM(3, 3);
  body_n.field(hat(m), dM);
  using Wide = long double;
  const Wide I_1 = Wide(lambda(1)) + lambda(2), I_2 = Wide(lambda(2)) + lambda(0);
  const Wide exact = (Wide(lambda(1)) - lambda(0)) * m(0) * m(1) / (I_1 * I_2);
  EXPECT_NEAR(dm(2) / static_cast<double>(exact), 1, 1e-15);
  EXPECT_NEAR(dM(1, 0) / static_cast<double>(exact), 1, 1e-15);
}

/// Λ over 1 : 1e12 in eight dimensions: (UΛ − ΛUᵀ − hM)_ij is small beside λ_i + λ_j, each.
TEST(HardBodies, CayleySweepsSeeNoSpread) {
  constexpr int N = 8;
  const RandomBody body(N, 3, 1e12);
  CayleyN<double> cayley(body.lambda, 0.1);
  const Eigen::MatrixXd K = 0.1 * body.M;
  cayley.start(K);
  ASSERT_TRUE(cayley.fixed_point(K));
  Accumulator<Eigen::MatrixXd> x(body.M, Arithmetic::compensated);
  cayley.transport(x);
  const Matrix<long double> D = cayley.U_minus_I().cast<long double>();
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < i; ++j) {
      const long double a = body.lambda(i), b = body.lambda(j);
      const long double residual = D(i, j) * b - a * D(j, i) - 0.1L * body.M(i, j);
      EXPECT_LT(std::abs(static_cast<double>(residual / (a + b))), 1e-16) << i << " " << j;
    }
}

TEST(HardBodies, ExponentialsOfLargeAnglesAreOrthogonal) {
  Exponential<double> exponential(6, MatrixKind::skew);
  Eigen::MatrixXd D(6, 6);
  for (const double angle : {1e-8, 1.0, 30.0, 1e4, 1e9}) {
    exponential(angle * RandomBody(6, 2).M, D);
    const Eigen::MatrixXd U = D + Eigen::MatrixXd::Identity(6, 6);
    EXPECT_LT(orthogonality_defect(U), 1e-14) << angle;
  }
}

/// z = b + Az with eigenvalues of A from −68 to 3: the fixed point diverges.
TEST(HardBodies, NewtonKrylovSolvesWhatIsStiff) {
  constexpr int n = 12;
  Eigen::VectorXd w(n);
  for (int k = 0; k < n; ++k) w(k) = k % 3 == 0 ? 3.0 : -std::pow(10, k / 6.0);
  const RandomBody body(n, 1);
  const Eigen::MatrixXd A = body.Q * w.asDiagonal() * body.Q.transpose(), b = body.M.col(0);
  NewtonKrylov<double> newton;
  Eigen::MatrixXd z = Eigen::MatrixXd::Zero(n, 1);
  ASSERT_TRUE(newton.solve(z, [&](const auto& x, auto& g) { g = b + A * x; }));
  const Eigen::MatrixXd exact = Lu<double>(Eigen::MatrixXd::Identity(n, n) - A).solve(b);
  EXPECT_LT((z - exact).norm(), 1e-13 * exact.norm());
}

/// The equation of the midpoint rule is stiff where Λ is spread wide; the step still finds its
/// solution.
TEST(HardBodies, TheMidpointRuleTakesWideInertia) {
  for (const double spread : {1e4, 1e8, 1e12}) {
    const Scene scene =
        Scene::resolve(testing::description(RandomBody(3, 2, spread), 0.1, "implicit_midpoint"))
            .value();
    const auto simulation = make_simulation(scene);
    ASSERT_TRUE(simulation->advance(100).reached()) << spread;
    EXPECT_LT(*simulation->orthogonality(), 1e-14);
  }
}

/// Units do not decide which steps have a solution.
TEST(HardBodies, TheBranchIsFoundInAllUnits) {
  const RandomBody body(3, 5);
  for (const double unit : {1e-150, 1e-100, 1.0, 1e110, 1e150})
    for (const double h : {0.8, 0.95, 1.05, 1.2, 1.5, 2.0}) {
      const auto outcome = [&](double scale) {
        SceneDescription d = testing::description(body, h, "variational");
        for (double& l : d.inertia) l *= scale;
        d.initial.at("M").values *= scale;
        return make_simulation(Scene::resolve(d).value())->advance(1).outcome;
      };
      EXPECT_EQ(outcome(unit), outcome(1)) << unit << " " << h;
    }
}

}  // namespace
}  // namespace stiefel
