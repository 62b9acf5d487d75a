#include "engine/frame/rattle_stiefel.h"

#include <gtest/gtest.h>

#include "engine/body/rigid_body_maps.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/frame/stiefel_momenta.h"
#include "engine/methods/variational.h"
#include "tests/support/integrate.h"
#include "tests/support/linalg/constraint_riccati_spectral.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel {
namespace {

using testing::RandomFrame;
constexpr auto compensated = Arithmetic::compensated;

static_assert(applies<Variational, Stiefel<double>>);
static_assert(applies<Variational, RigidBody<SoN<double>>> && !applies<Variational, double>);

auto map_of(const RandomFrame<double>& frame, double h, Arithmetic arithmetic = compensated) {
  return map_of(Variational(), Stiefel<double>(frame.lambda, frame.Q.rows()), h, {2, arithmetic});
}

/// Q at t = 1.
Matrix<double> run(const RandomFrame<double>& frame, int steps) {
  auto map = map_of(frame, 1.0 / steps);
  auto state = map.start(frame.state());
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
  return state.x.value.topRows(frame.Q.rows());
}

TEST(RattleStiefel, IsOfSecondOrder) {
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 5}, {3, 6}, {4, 9}, {5, 7}, {4, 4}})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RandomFrame<double> frame(n, N, seed);
      const Matrix<long double> x =
          testing::integrate(Stiefel<long double>(frame.lambda.cast<long double>(), n),
                             Matrix<long double>(frame.state().cast<long double>()), 1.0L);
      const Matrix<double> Q = x.topRows(n).cast<double>();
      const double coarse = (run(frame, 40) - Q).norm(), fine = (run(frame, 80) - Q).norm();
      EXPECT_NEAR(std::log2(coarse / fine), 2, 0.05) << n << " " << N << " " << coarse;
    }
}

TEST(RattleStiefel, IsTheMoserVeselovMapAtFullRank) {
  for (const int N : {3, 5})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const RandomFrame<double> frame(N, N, seed);
      const auto M_of = [](const auto& Q, const auto& S) {
        return Matrix<double>(Q.transpose() * S - S.transpose() * Q);
      };
      auto map = map_of(frame, 0.1);
      auto state = map.start(frame.state());
      MoserVeselov<SoN<double>> moser_veselov(frame.lambda, 0.1);
      Matrix<double> x(2 * N, N);
      x << frame.Q, M_of(frame.Q, frame.S);
      auto other = moser_veselov.start(x);
      for (int k = 0; k < 50; ++k) {
        ASSERT_TRUE(map.step(state).reached());
        ASSERT_TRUE(moser_veselov.step(other).reached());
      }
      const Matrix<double> Q = state.x.value.topRows(N), S = state.x.value.bottomRows(N);
      EXPECT_LT((Q - other.x.value.topRows(N)).norm(), 1e-13);
      EXPECT_LT((M_of(Q, S) - other.x.value.bottomRows(N)).norm(), 1e-13 * S.norm());
    }
}

/// The equation of the constraint as the paper has it, from Q and S.
struct Equation {
  Matrix<double> A, P, E;
  Equation(const RandomFrame<double>& frame, double h) {
    const Matrix<double> inverse = frame.lambda.cwiseInverse().asDiagonal();
    const Matrix<double> G = frame.Q * inverse, D = frame.Q + h * frame.S * inverse;
    A = G * D.transpose();
    P = G * G.transpose();
    E = D * D.transpose() - Matrix<double>::Identity(G.rows(), G.rows());
  }
};

TEST(RattleStiefel, FindsTheSolutionUpToTheEdgeOfTheDomainAndNamesTheEdge) {
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 5}, {3, 6}, {3, 3}, {5, 8}})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const RandomFrame<double> frame(n, N, seed);
      double edge = 0.05;
      while (true) {
        const Equation at(frame, edge);
        if (!testing::constraint_riccati_spectral(at.A, at.P, at.E)) break;
        edge *= 1.0005;
      }
      auto beyond = map_of(frame, 1.05 * edge);
      auto state = beyond.start(frame.state());
      const Matrix<double> before = state.x.value;
      const RunStatus status = beyond.step(state);
      EXPECT_EQ(status.outcome, Outcome::left_domain);
      EXPECT_NEAR(status.largest_step.value_or(0), edge, 2e-3 * edge) << n << " " << N;
      EXPECT_NEAR(beyond.largest_step(state, 100).value_or(0), edge, 2e-3 * edge);
      EXPECT_EQ(state.x.value, before);

      for (const double h : {0.1 * edge, 0.5 * edge, 0.95 * edge, -0.3 * edge}) {
        auto map = map_of(frame, h);
        auto inside = map.start(frame.state());
        ASSERT_TRUE(map.step(inside).reached());
        const Equation at(frame, h);
        const auto Y = testing::constraint_riccati_spectral(at.A, at.P, at.E);
        ASSERT_TRUE(Y);
        const Matrix<double> inverse = frame.lambda.cwiseInverse().asDiagonal();
        const Matrix<double> Q = frame.Q + (h * frame.S + *Y * frame.Q) * inverse;
        EXPECT_LT((inside.x.value.topRows(n) - Q).norm(), 1e-11) << h / edge;
        EXPECT_LT(orthogonality_defect(inside.x.value.topRows(n)), 1e-14);
      }
    }
}

TEST(RattleStiefel, KeepsLargeFramesOrthonormal) {
  const RandomFrame<double> frame(4, 1000, 1, 100);
  auto map = map_of(frame, 0.1);
  auto state = map.start(frame.state());
  const Matrix<double> m = momentum_m<double>(frame.Q, frame.S);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(map.step(state).reached());
  const Matrix<double> Q = state.x.value.topRows(4), S = state.x.value.bottomRows(4);
  EXPECT_LT(orthogonality_defect(Q), 4e-15);
  EXPECT_LT((momentum_m<double>(Q, S) - m).norm() / frame.S.norm(), 1e-14);
}

constexpr double unit_roundoff = 0x1p-53;

/// The relative error of the lower block after `steps` steps on the sphere with Λ = 3I. There the
/// step is a rotation by asin(h‖Q̇‖) in the plane of Q and Q̇.
double error_on_the_sphere(double h, double speed, int steps) {
  using Row = Eigen::RowVector3<long double>;
  const double lambda = 3, size = lambda * speed;
  const Row q = Row(1, 2, 3).normalized(), t = q.cross(Row(2, -1, 1)).normalized();
  Matrix<double> x(2, 3);
  x << q.cast<double>(), (size * t).cast<double>();
  RattleStiefel<double> map(Vector<double>::Constant(3, lambda), 1, h, compensated);
  auto state = map.start(x);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
  const long double angle = steps * std::asin(static_cast<long double>(h) * speed);
  const Row exact = size * (std::cos(angle) * t - std::sin(angle) * q);
  const Matrix<double> found = state.x.value.row(1);
  return static_cast<double>((found.cast<long double>() - exact).norm() / exact.norm());
}

/// The speed of the rounded start is off by u, and the phase by u times the angle.
TEST(RattleStiefel, KeepsTheDigitsOfTheMomentumInSmallSteps) {
  for (const double h : {1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.125})
    for (const double speed : {1e-30, 1e-17, 1e-15, 1e-12, 1e-6, 1.0})
      for (const int steps : {1, 1000}) {
        const double bound = 4 * unit_roundoff * (std::sqrt(steps) + steps * h * speed);
        EXPECT_LE(error_on_the_sphere(h, speed, steps), bound) << h << " " << speed;
      }
}

/// The lower block against that of the same map in quadruple precision, from the same frame and
/// momentum up to rounding.
TEST(RattleStiefel, KeepsTheDigitsOfTheMomentumForEveryInertia) {
  constexpr int steps = 200;
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 4}, {3, 5}, {3, 3}})
    for (const double spread : {1.0, 4.0, 1e4})
      for (const auto& [h, size] :
           {std::pair{1e-10, 1.0}, {1e-10, 1e-30}, {1e-6, 1.0}, {1e-6, 1e-8}, {0.125, 1e-16}}) {
        const RandomFrame<testing::Quad> frame(n, N, 1, spread);
        Matrix<testing::Quad> x = frame.state();
        x.bottomRows(n) *= testing::Quad(size);
        RattleStiefel<testing::Quad> exact(frame.lambda, n, testing::Quad(h), Arithmetic::plain);
        RattleStiefel<double> map(frame.lambda.cast<double>(), n, h);
        auto found = map.start(x.cast<double>());
        auto wanted = exact.start(x);
        for (int k = 0; k < steps; ++k) {
          ASSERT_TRUE(map.step(found).reached());
          ASSERT_TRUE(exact.step(wanted).reached());
        }
        const Matrix<testing::Quad> S = wanted.x.value.bottomRows(n);
        const Matrix<double> mine = found.x.value.bottomRows(n),
                             error = (mine.cast<testing::Quad>() - S).cast<double>() / size;
        EXPECT_LE(error.norm(), 8 * unit_roundoff * std::sqrt(steps) * mine.norm() / size)
            << n << " " << N << " 1:" << spread << " h = " << h << ", size " << size;
      }
}

}  // namespace
}  // namespace stiefel
