#include "stiefel/connect.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <cmath>
#include <numbers>

#include "engine/dense/decompositions.h"
#include "stiefel/conjugate_points.h"
#include "tests/support/exact_motion.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/two_frames.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;
using testing::random_frames;

/// The multiplier form of the geodesic equation, Q̈ = BQΛ⁻¹ with B from (QQᵀ)¨ = 0, as a linear
/// system for all n² entries of B: no code of the engine.
MatrixXd frame_at(const VectorXd& lambda, const MatrixXd& Q_0, const MatrixXd& Qdot, double t) {
  using Real = long double;
  using WideMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using State = std::vector<Real>;
  const Index n = Q_0.rows(), N = Q_0.cols(), size = n * N;
  const WideMatrix I = WideMatrix::Identity(n, n);
  const auto field = [&](const State& x, State& dx, Real) {
    const Eigen::Map<const WideMatrix> Q(x.data(), n, N), V(x.data() + size, n, N);
    const WideMatrix QL = Q * lambda.cast<Real>().cwiseInverse().asDiagonal();
    const WideMatrix K = QL * Q.transpose(), rate = -2 * V * V.transpose();
    WideMatrix sum(n * n, n * n);  // of K ⊗ I and I ⊗ K
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j)
        sum.block(i * n, j * n, n, n) = K(i, j) * I + (i == j ? K : WideMatrix::Zero(n, n));
    const WideMatrix B = Lu<Real>(sum).solve(rate.reshaped()).reshaped(n, n);
    Eigen::Map<WideMatrix>(dx.data(), n, N) = V;
    Eigen::Map<WideMatrix>(dx.data() + size, n, N) = B * QL;
  };
  State x(static_cast<std::size_t>(2 * size));
  Eigen::Map<WideMatrix>(x.data(), n, N) = Q_0.cast<Real>();
  Eigen::Map<WideMatrix>(x.data() + size, n, N) = Qdot.cast<Real>();
  boost::numeric::odeint::integrate_adaptive(
      boost::numeric::odeint::bulirsch_stoer<State, Real>(1e-16L, 1e-16L), field, x, Real(0),
      Real(t), Real(t) / 100);
  return Eigen::Map<WideMatrix>(x.data(), n, N).cast<double>();
}

/// max |Q(T) − Q_T| of an answer, by integrators that the answer does not use.
double miss(const TwoPointProblem& p, const Geodesic& answer) {
  const MatrixXd end = p.Q_0.rows() == p.Q_0.cols()
                           ? testing::exact_motion(p.inertia, answer.Q, answer.M, p.time).Q
                           : frame_at(p.inertia, answer.Q, answer.Qdot, p.time);
  return (end - p.Q_T).cwiseAbs().maxCoeff();
}

double energy(const VectorXd& lambda, const MatrixXd& V) {
  return (V * lambda.asDiagonal() * V.transpose()).trace() / 2;
}

MatrixXd from_rows(const std::vector<double>& numbers, int n, int N) {
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      numbers.data(), n, N);
}

TEST(Connect, JoinsTheEndsOfReferenceMotionsWithNoMoreEnergy) {
  for (const auto& motion : testing::reference_motions()) {
    SCOPED_TRACE(motion.name);
    TwoPointProblem p;
    p.inertia = Eigen::Map<const VectorXd>(motion.lambda.data(), motion.N);
    p.Q_0 = from_rows(motion.Q_0, motion.n, motion.N);
    p.Q_T = from_rows(motion.Q, motion.n, motion.N);
    p.time = motion.t;
    const auto answer = connect(p);
    ASSERT_TRUE(answer);
    EXPECT_LT(miss(p, *answer), 1e-11);
    EXPECT_LT(answer->residual, 1e-11);

    MatrixXd V = from_rows(motion.momentum, motion.n, motion.N);
    if (motion.n == motion.N) {
      for (int i = 0; i < motion.N; ++i)
        for (int j = 0; j < motion.N; ++j)
          if (i != j) V(i, j) /= p.inertia(i) + p.inertia(j);
    } else {
      V = (V * p.inertia.cwiseInverse().asDiagonal()).eval();
    }
    EXPECT_LE(answer->energy, energy(p.inertia, V) * (1 + 1e-12));
    EXPECT_NEAR(answer->energy, energy(p.inertia, answer->Qdot), 1e-13 * answer->energy);
  }
}

TEST(Connect, JoinsRandomFrames) {
  for (const auto& [n, N] : {std::pair(1, 3), {2, 5}, {3, 8}, {5, 5}})
    for (const double spread : {4.0, 100.0})
      for (unsigned seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE(::testing::Message() << n << " " << N << " " << spread << " " << seed);
        TwoPointProblem p = random_frames(n, N, spread, seed);
        p.time = 0.7;
        p.restarts = 1;
        const auto answer = connect(p);
        ASSERT_TRUE(answer);
        EXPECT_LT(miss(p, *answer), 1e-11);
        EXPECT_GE(answer->distinct, 1);
      }
}

/// exp(A) by its series, halved and squared.
MatrixXd exponential(const MatrixXd& A) {
  constexpr int halvings = 8;
  const MatrixXd small = A / std::exp2(halvings);
  MatrixXd sum = MatrixXd::Identity(A.rows(), A.cols()), term = sum;
  for (int k = 1; k < 18; ++k) sum += term = (term * small / k).eval();
  for (int k = 0; k < halvings; ++k) sum = (sum * sum).eval();
  return sum;
}

/// Λ = λI: Q(t) in closed form (Edelman, Arias and Smith 1998, (2.42)).
MatrixXd round_geodesic(const MatrixXd& Q, const MatrixXd& Qdot, double t) {
  const Index n = Q.rows(), N = Q.cols();
  const MatrixXd Y = Q.transpose(), H = Qdot.transpose(), A = Y.transpose() * H;
  MatrixXd generator(2 * n, 2 * n), YH(N, 2 * n);
  generator << A, -H.transpose() * H, MatrixXd::Identity(n, n), A;
  YH << Y, H;
  return (YH * exponential(t * generator).leftCols(n) * exponential(-t * A)).transpose();
}

TEST(Connect, RecoversRoundGeodesicsUpToTheInjectivityRadius) {
  for (const auto& [n, N] :
       {std::pair(1, 2), {1, 3}, {2, 3}, {2, 5}, {3, 6}, {3, 3}, {4, 4}, {5, 5}})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(::testing::Message() << n << " " << N << " " << seed);
      const double radius = n == N ? std::numbers::sqrt2 * pi : pi, T = 2;
      TwoPointProblem p = random_frames(n, N, 1, seed);
      p.inertia.setConstant(1.7);
      p.time = T;
      const MatrixXd& Q = p.Q_0;
      MatrixXd V = random_frames(n, N, 1, seed + 50).Q_T;
      V -= ((V * Q.transpose() + Q * V.transpose()) / 2 * Q).eval();
      V *= 0.9 * radius / T / V.norm();
      p.Q_T = round_geodesic(Q, V, T);
      const auto answer = connect(p);
      ASSERT_TRUE(answer);
      EXPECT_LT((answer->Qdot - V).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_EQ(answer->shortest, Shortest::yes);
    }
}

/// A problem whose solution is Q̇(0) = V with T = 1: a random tangent vector of a given length.
struct Drawn {
  TwoPointProblem problem;
  MatrixXd V;
};

Drawn drawn(int n, int N, const VectorXd& lambda, double length, unsigned seed) {
  Drawn out{random_frames(n, N, 1, seed), random_frames(n, N, 1, seed + 50).Q_T};
  const MatrixXd& Q = out.problem.Q_0;
  out.V -= ((out.V * Q.transpose() + Q * out.V.transpose()) / 2 * Q).eval();
  out.V *= length / out.V.norm();
  out.problem.inertia = lambda;
  out.problem.Q_T = (lambda.array() == lambda(0)).all() ? round_geodesic(Q, out.V, 1)
                                                        : frame_at(lambda, Q, out.V, 1);
  return out;
}

VectorXd spread_inertia(int N, double spread) {
  return VectorXd::LinSpaced(N, 0, std::log(spread)).array().exp();
}

TEST(Connect, RecoversRoundGeodesicsOfAnySize) {
  for (const auto& [n, N] :
       {std::pair(3, 8), {5, 20}, {7, 15}, {10, 15}, {14, 15}, {10, 100}, {20, 400}, {2, 20000}})
    for (const double length : {1e-9, 1e-3, 0.5 * pi, 0.8 * pi}) {
      SCOPED_TRACE(::testing::Message() << n << " " << N << " " << length);
      const Drawn pair = drawn(n, N, VectorXd::Ones(N), length, 3);
      const auto answer = connect(pair.problem);
      ASSERT_TRUE(answer);
      EXPECT_LT((answer->Qdot - pair.V).cwiseAbs().maxCoeff(), 1e-13);
      EXPECT_LT(answer->residual, 1e-13);
      EXPECT_EQ(answer->shortest, Shortest::yes);
    }
}

TEST(Connect, JoinsFramesOfAnySizeAndInertiaAndTakesNoLongerWay) {
  for (const auto& [n, N] : {std::pair(3, 8), {5, 20}, {2, 300}, {6, 9}})
    for (const double spread : {10.0, 1e3}) {
      SCOPED_TRACE(::testing::Message() << n << " " << N << " " << spread);
      const Drawn pair = drawn(n, N, spread_inertia(N, spread), 0.5 * pi, 1);
      const auto answer = connect(pair.problem);
      ASSERT_TRUE(answer);
      EXPECT_LT(miss(pair.problem, *answer), 1e-11);
      EXPECT_LE(answer->energy, energy(pair.problem.inertia, pair.V) * (1 + 1e-10));
    }
}

/// Frames with a random Λ over 1:10⁴, and a tangent vector whose geodesic joins them.
Drawn very_wide(int n, int N, double length, std::uint64_t seed) {
  Drawn out{random_frames(n, N, 1e4, seed), random_frames(n, N, 1e4, seed + 1'000'000).Q_T};
  TwoPointProblem& p = out.problem;
  out.V -= ((out.V * p.Q_0.transpose() + p.Q_0 * out.V.transpose()) / 2 * p.Q_0).eval();
  out.V *= length / out.V.norm();
  p.Q_T = frame_at(p.inertia, p.Q_0, out.V, 1);
  return out;
}

/// The paths turn within a hundredth of the time. At the first nodes of the multipliers they turn
/// from one node to the next, with less action than a path of any geodesic has.
TEST(Connect, FollowsAGeodesicFromEqualToVeryWideInertias) {
  for (const auto& [length, seed] : {std::pair(0.5, 19), {0.8, 25}}) {
    Drawn pair = very_wide(3, 8, length * pi, static_cast<std::uint64_t>(seed));
    pair.problem.most_work = 1e11;
    const auto answer = connect(pair.problem);
    ASSERT_TRUE(answer) << seed;
    EXPECT_LT(miss(pair.problem, *answer), 1e-11);
    EXPECT_LE(answer->residual, 1e-12);
    EXPECT_LE(answer->energy, energy(pair.problem.inertia, pair.V) * (1 + 1e-10));
  }
}

/// Newton steps over powers of Λ follow the paths to these frames; the second path needs more nodes
/// at the end. Descents from the root of Λ, and by dense steps, took 2.5·10¹⁰ operations and more.
TEST(Connect, FollowsAPathToAVeryWideInertiaWithLittleWork) {
  for (const std::uint64_t seed : {1, 20}) {
    Drawn pair = very_wide(5, 20, 0.8 * pi, seed);
    pair.problem.most_work = 1.7e10;
    const auto answer = connect(pair.problem);
    ASSERT_TRUE(answer) << seed;
    EXPECT_LT(miss(pair.problem, *answer), 1e-11);
    EXPECT_LE(answer->energy, energy(pair.problem.inertia, pair.V) * (1 + 1e-10));
  }
}

/// Columns of one λ stay in the span of those of both frames.
TEST(Connect, JoinsFramesWithFewDifferentInertias) {
  VectorXd lambda(60);
  lambda << VectorXd::Constant(30, 2.5), VectorXd::Constant(25, 1.0), VectorXd::Constant(5, 4.0);
  const Drawn pair = drawn(2, 60, lambda, 1.2, 4);
  const auto answer = connect(pair.problem);
  ASSERT_TRUE(answer);
  EXPECT_LT((answer->Qdot - pair.V).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Connect, LooksForShorterGeodesicsWhenAsked) {
  int more = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    TwoPointProblem p = drawn(2, 5, spread_inertia(5, 100), 3.5, seed).problem;
    const auto direct = connect(p);
    p.restarts = 12;
    const auto searched = connect(p);
    ASSERT_TRUE(direct && searched);
    EXPECT_LE(searched->energy, direct->energy * (1 + 1e-12));
    more += searched->distinct > direct->distinct;
  }
  EXPECT_GE(more, 1);
}

TEST(Connect, RefusesAnInertiaOfManyValuesWhereMemoryEnds) {
  TwoPointProblem p = random_frames(4, 100'000, 10, 1);
  const auto answer = connect(p);
  ASSERT_FALSE(answer);
  const auto* refused = std::get_if<refusal::Invalid>(&answer.error());
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(refused->field, "Q_0");
  p.inertia.setOnes();
  EXPECT_TRUE(connect(p));
}

/// The metric ½‖Q̇‖² of the rotations is invariant on both sides, so the shortest geodesics are
/// Q_0 exp(tW) with angles of at most π, also beyond the injectivity radius √2·π.
TEST(Connect, IsTheLogarithmForRoundBodies) {
  TwoPointProblem p = random_frames(4, 4, 1, 1);
  p.inertia.setConstant(1);
  p.Q_0 = MatrixXd::Identity(4, 4);
  p.Q_T = MatrixXd::Identity(4, 4) * std::cos(3.0);
  p.Q_T(1, 0) = p.Q_T(3, 2) = std::sin(3.0);
  p.Q_T(0, 1) = p.Q_T(2, 3) = -std::sin(3.0);
  const auto answer = connect(p);
  ASSERT_TRUE(answer);
  EXPECT_NEAR(answer->energy, 18, 1e-13);
  EXPECT_EQ(answer->shortest, Shortest::yes);
}

/// Λ = λI next to the cut point at the distance π (√2·π for n = N) in directions of rank one, where
/// the length is known and the derivative of Q(T) is singular.
TEST(Connect, IsExactNextToTheCutPointsOfTheRoundMetric) {
  for (const auto& [n, N] :
       {std::pair(1, 2), {1, 3}, {1, 5}, {2, 3}, {2, 4}, {3, 4}, {3, 3}, {4, 4}})
    for (const double gap : {0.0, 1e-13, 1e-10, 3e-8, 1e-6, 1e-5}) {
      SCOPED_TRACE(::testing::Message() << n << " " << N << " " << gap);
      TwoPointProblem p = random_frames(n, N, 1, 3);
      p.inertia.setConstant(1.7);
      const MatrixXd& Q = p.Q_0;
      MatrixXd V;
      if (n < N) {
        V = MatrixXd::Random(n, 1) * complement(Q).topRows(1);
      } else {
        MatrixXd W = MatrixXd::Zero(N, N);
        W(0, 1) = 1;
        W(1, 0) = -1;
        V = Q * W;
      }
      const double length = (n == N ? std::numbers::sqrt2 * pi : pi) - gap;
      V *= length / V.norm();
      p.Q_T = round_geodesic(Q, V, 1);
      const auto answer = connect(p);
      ASSERT_TRUE(answer);
      EXPECT_NEAR(answer->energy, 1.7 * length * length / 2, 1e-9);
      EXPECT_EQ(answer->shortest, Shortest::yes);
      EXPECT_LT(miss(p, *answer), 1e-11);
    }
}

TEST(Connect, ProvesNothingByASearchBeyondTheInjectivityBound) {
  for (const auto& [n, N] : {std::pair(1, 3), {2, 4}, {3, 3}})
    for (const double spread : {4.0, 40.0}) {
      const TwoPointProblem p = random_frames(n, N, spread, 2);
      const auto answer = connect(p);
      ASSERT_TRUE(answer);
      const bool near = std::sqrt(2 * answer->energy) <= injectivity_bound(p.inertia, n);
      EXPECT_EQ(answer->shortest, near ? Shortest::yes : Shortest::none_shorter_found);
      EXPECT_FALSE(near && spread > 4);
    }
}

TEST(Connect, GoesTheShortWayRoundACircleOfRotations) {
  TwoPointProblem p = random_frames(2, 2, 1, 1);
  p.inertia << 3, 1;
  p.Q_0.setIdentity();
  p.Q_T << std::cos(2), -std::sin(2), std::sin(2), std::cos(2);
  const auto body = connect(p);
  ASSERT_TRUE(body);
  EXPECT_NEAR(body->energy, (3 + 1) * 4 / 2.0, 1e-12);
  EXPECT_EQ(body->shortest, Shortest::yes);
}

TEST(Connect, StaysWhereItIs) {
  for (const auto& [n, N] : {std::pair(1, 2), {1, 4}, {2, 3}, {3, 3}}) {
    TwoPointProblem p = random_frames(n, N, 4, 3);
    p.Q_T = p.Q_0;
    const auto answer = connect(p);
    ASSERT_TRUE(answer);
    EXPECT_LT(answer->energy, 1e-28);
    EXPECT_EQ(answer->shortest, Shortest::yes);
  }
}

TEST(Connect, RepairsFramesAsAScene) {
  TwoPointProblem p = random_frames(2, 5, 4, 4);
  const auto exact = connect(p);
  p.Q_0 = p.Q_0.cast<float>().cast<double>();
  p.Q_T = p.Q_T.cast<float>().cast<double>();
  const auto answer = connect(p);
  ASSERT_TRUE(exact && answer);
  EXPECT_LT((answer->Q * answer->Q.transpose() - MatrixXd::Identity(2, 2)).norm(), 1e-15);
  EXPECT_NEAR(answer->energy, exact->energy, 1e-5 * exact->energy);

  SceneDescription d;
  d.system = "stiefel";
  d.inertia = {p.inertia.begin(), p.inertia.end()};
  d.initial["Q"] = p.Q_0;
  d.initial["S"] = MatrixXd::Zero(2, 5);
  d.method = {"variational", 2, 1, ""};
  d.step = 0.1;
  EXPECT_EQ(Scene::resolve(d).value().Q(), answer->Q);
  EXPECT_EQ(joining_scene(p, 0, 0).value().scene->Q(), answer->Q);
}

TEST(Connect, DividesByNoInertiaOfABody) {
  TwoPointProblem p = random_frames(3, 3, 4, 5);
  p.inertia << 2, 1, -0.3;
  const auto answer = connect(p);
  ASSERT_TRUE(answer);
  EXPECT_LT(miss(p, *answer), 1e-11);
}

TEST(Connect, IsTheSameForTheSameSeedAndScalesWithTimeAndInertia) {
  TwoPointProblem p = random_frames(2, 5, 100, 9);
  const auto once = connect(p), again = connect(p);
  ASSERT_TRUE(once && again);
  EXPECT_TRUE(once->Qdot == again->Qdot);
  p.time = 3;
  p.inertia *= 5e4;
  const auto scaled = connect(p);
  ASSERT_TRUE(scaled);
  EXPECT_LT((3 * scaled->Qdot - once->Qdot).norm(), 1e-11 * once->Qdot.norm());
  EXPECT_NEAR(scaled->energy * 9 / 5e4, once->energy, 1e-11 * once->energy);
}

}  // namespace
}  // namespace stiefel
