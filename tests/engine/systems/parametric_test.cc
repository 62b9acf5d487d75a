#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/body/moser_veselov.h"
#include "engine/body/parametric_rigid_body.h"
#include "engine/dense/decompositions.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/rk4.h"
#include "stiefel/diagnosis.h"
#include "stiefel/simulation.h"
#include "tests/support/exact_motion.h"
#include "tests/support/integrate.h"
#include "tests/support/representations/rigid_formulas.h"
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

MatrixXd diagonal(const VectorXd& d) { return d.asDiagonal(); }

/// Q_μ = (I + a little of a random matrix)·Q, so really in GL(N), and P_μ with M_μ = M + μΛ².
MatrixXd start_of(const RandomBody& body, const MatrixXd& M, double mu) {
  const MatrixXd Q = body.Q + 0.3 * RandomBody(static_cast<int>(body.lambda.size()), 77).Q;
  return stacked(Q, parametric_P(Q, M + mu * diagonal(body.lambda.cwiseAbs2())));
}

TEST(Exponential, OfAGeneralMatrixAgreesWithItsSeries) {
  for (const double size : {1e-12, 1e-3, 0.4, 0.9, 3.0, 6.0})
    for (const int N : {1, 2, 3, 5, 9}) {
      MatrixXd A = RandomBody(std::max(N, 2), 5).Q.topLeftCorner(N, N);
      A.diagonal().array() += 0.2;
      A *= size / A.cwiseAbs().colwise().sum().maxCoeff();
      MatrixXd D(N, N);
      Exponential<double> exponential(N, MatrixKind::general);
      exponential(A, D);
      Matrix<long double> D_wide(N, N), term = Matrix<long double>::Identity(N, N);
      Matrix<long double> series = Matrix<long double>::Zero(N, N);
      for (int k = 1; k < 100; ++k) {
        term = (term * A.cast<long double>() / k).eval();
        series += term;
      }
      const double scale = size * std::exp(size);
      EXPECT_LT((D.cast<long double>() - series).norm(), 4e-15L * scale) << N << " " << size;
      Exponential<long double> wide(N, MatrixKind::general);
      wide(A.cast<long double>(), D_wide);
      EXPECT_LT((D_wide - series).norm(), 4e-18L * scale) << N << " " << size;
    }
}

/// On the invariant manifold M = M_μ − μΛ² moves as the rigid body, for every μ.
TEST(ParametricRigidBody, MomentumMovesAsTheRigidBody) {
  for (const double mu : {-0.1, 0.0, 0.05, 0.2})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RandomBody body(4, seed);
      const MatrixXd M = body.M / 2;
      const MatrixXd x = start_of(body, M, mu), square = mu * diagonal(body.lambda.cwiseAbs2());
      ASSERT_LT((parametric_momentum<double>(top(x), bottom(x)) - M - square).norm(), 1e-12);
      const auto exact = exact_motion(body.lambda, body.Q, M, 1);
      const MatrixXd end =
          flow(ParametricRigidBody<long double>(body.lambda.cast<long double>(), mu), x, 1);
      EXPECT_LT((parametric_momentum<double>(top(end), bottom(end)) - square - exact.M).norm(),
                1e-11)
          << mu << " " << seed;
      EXPECT_LT((parametric_spatial_momentum<double>(top(end), bottom(end)) -
                 parametric_spatial_momentum<double>(top(x), bottom(x)))
                    .norm(),
                1e-11);
    }
}

TEST(ParametricRigidBody, MuntheKaas4HasOrder4AndKeepsTheSpatialMomentum) {
  for (const int N : {3, 5})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RandomBody body(N, seed);
      constexpr double mu = 0.2;
      const MatrixXd x = start_of(body, body.M / 2, mu);
      const MatrixXd exact =
          flow(ParametricRigidBody<long double>(body.lambda.cast<long double>(), mu), x, 1);
      const auto end = [&](int steps) {
        MuntheKaas4::Map<ParametricRigidBody<double>> map(
            ParametricRigidBody<double>(body.lambda, mu), 1.0 / steps, 4);
        auto state = map.start(x);
        for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
        return state.x.value;
      };
      const MatrixXd coarse = end(20), fine = end(40);
      EXPECT_NEAR(std::log2((coarse - exact).norm() / (fine - exact).norm()), 4, 0.15)
          << N << " " << seed << " " << (coarse - exact).norm();
      const MatrixXd m = parametric_spatial_momentum<double>(top(x), bottom(x));
      EXPECT_LT((parametric_spatial_momentum<double>(top(coarse), bottom(coarse)) - m).norm(),
                1e-12 * (1 + m.norm()));
    }
}

using Plain = MoserVeselov<SoN<double>>;
using Parametric = ParametricMoserVeselov;

/// (8.10) and (8.11) with the erratum, against the map without parameter.
/// Next to the manifold M is the skew part of M_μ, and the invariants are those of this M.
TEST(ParametricRigidBody, ReportsASkewMNextToTheManifold) {
  for (const char* system : {"parametric_rigid_body", "parametric_moser_veselov"})
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const std::string method = system == std::string("parametric_rigid_body") ? "rk4" : "";
      SceneDescription d = testing::any_scene(system, method, seed, 0.1);
      d = Scene::resolve(d).value().description();
      const RowMatrix off = RowMatrix::Random(4, 4);
      d.initial.at("P").values += 1e-10 * *d.epsilon * (off + off.transpose());
      const Scene scene = Scene::resolve(d).value();
      const auto simulation = make_simulation(scene);
      ASSERT_TRUE(simulation->advance(5).reached());
      const Eigen::MatrixXd M = simulation->get("M");
      EXPECT_EQ(M, Eigen::MatrixXd(-M.transpose())) << system;
      double E = 0;
      for (Eigen::Index j = 0; j < 4; ++j)
        for (Eigen::Index i = 0; i < j; ++i)
          E += M(i, j) * M(i, j) / (scene.inertia()(i) + scene.inertia()(j)) / 2;
      const Diagnosis diagnosis = diagnose(scene, *simulation);
      const auto energy = std::ranges::find(diagnosis.invariants, "energy", &InvariantDrift::name);
      ASSERT_NE(energy, diagnosis.invariants.end());
      EXPECT_NEAR(static_cast<double>(energy->value), E, 1e-14 * E) << system;
    }
}

TEST(ParametricMoserVeselov, MovesMAsTheMoserVeselovMapAndKeepsItsConstants) {
  for (const double mu : {-0.02, 0.0, 0.02})
    for (const int N : {3, 4, 6})
      for (unsigned seed = 1; seed <= 3; ++seed) {
        const RandomBody body(N, seed);
        constexpr double h = 0.1;
        const MatrixXd square = mu * diagonal(body.lambda.cwiseAbs2());
        const MatrixXd x = start_of(body, h * body.M, mu);
        Parametric map(body.lambda, h, mu);
        Plain plain(body.lambda, h);
        auto state = map.start(x);
        auto other = plain.start(stacked(MatrixXd::Identity(N, N), body.M));
        const MatrixXd m = parametric_spatial_momentum<double>(top(x), bottom(x));
        for (int k = 0; k < 10; ++k) {
          const MatrixXd at = state.x.value,
                         before = parametric_momentum<double>(top(at), bottom(at));
          other.x.value.topRows(N).setIdentity();
          other.x.carry.topRows(N).setZero();
          ASSERT_TRUE(map.step(state).reached());
          ASSERT_TRUE(plain.step(other).reached());
          const MatrixXd U = top(other.x.value), M = bottom(other.x.value), y = state.x.value;
          const MatrixXd factor = U + mu * diagonal(body.lambda);
          EXPECT_LT((y - at * factor).norm(), 1e-12 * y.norm());
          const MatrixXd after = parametric_momentum<double>(top(y), bottom(y));
          EXPECT_LT((after - h * M - square).norm(), 1e-11);
          EXPECT_LT((factor * after - before * factor).norm(), 1e-11);
          EXPECT_LT((parametric_spatial_momentum<double>(top(y), bottom(y)) - m).norm(), 1e-11);
        }
      }
}

/// As h → 0 it is the continuous system with μ/h, to first order, as (8.10) is.
TEST(ParametricMoserVeselov, TendsToTheParametricRigidBody) {
  const RandomBody body(4, 2);
  const auto error = [&](double h) {
    constexpr double rate = 0.2;
    const MatrixXd x = start_of(body, h * body.M, h * rate);
    Parametric map(body.lambda, h, h * rate);
    auto state = map.start(x);
    EXPECT_TRUE(map.step(state).reached());
    MatrixXd Omega(4, 4);
    SoN<double>::InverseInertia(body.lambda)(body.M, Omega);
    const MatrixXd velocity = top(x) * (Omega + rate * diagonal(body.lambda));
    return ((top(state.x.value) - top(x)) / h - velocity).norm();
  };
  EXPECT_NEAR(error(1e-3) / error(1e-4), 10, 0.2);
}

TEST(ParametricMoserVeselov, EdgesOfItsDomain) {
  const RandomBody body(4, 3);
  constexpr double h = 3, mu = 0.01;
  const MatrixXd x = start_of(body, h * body.M, mu);
  Parametric map(body.lambda, h, mu);
  auto state = map.start(x);
  const RunStatus status = map.step(state);
  ASSERT_EQ(status.outcome, Outcome::left_domain);
  EXPECT_EQ(state.x.value, x);
  const double largest = *status.largest_step;
  Plain inside(body.lambda, 0.999 * largest), outside(body.lambda, 1.002 * largest);
  auto in = inside.start(body.M), out = outside.start(body.M);
  EXPECT_TRUE(inside.step(in).reached());
  EXPECT_EQ(outside.step(out).outcome, Outcome::left_domain);

  MatrixXd singular = x;
  singular.row(0).setZero();
  auto lost = map.start(singular);
  EXPECT_EQ(map.step(lost).outcome, Outcome::not_finite);
}

}  // namespace
}  // namespace stiefel
