#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "stiefel/connect.h"
#include "tests/support/scenes/two_frames.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;
using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// Returns e^A by a Taylor series in extended precision.
Wide wide_exponential(const Wide& A) {
  const Wide small = A / 1024;
  Wide term = Wide::Identity(A.rows(), A.cols()), sum = term;
  for (int k = 1; k < 16; ++k) sum += term = (term * small / k).eval();
  for (int k = 0; k < 10; ++k) sum = (sum * sum).eval();
  return sum;
}

/// A frame with a velocity, and its parts: Q̇ᵀ = UA + H, U = Qᵀ, A skew, UᵀH = 0.
struct Motion {
  MatrixXd U, A, H;

  MatrixXd velocity() const { return (U * A + H).transpose(); }
  double length(double beta) const { return std::sqrt(beta * A.squaredNorm() + H.squaredNorm()); }
  /// Returns Q(t) as the action of the group on frames (Hüper, Markina and Silva Leite 2021), with
  /// exponentials of N × N matrices: U(t) = e^{tX} U e^{(1 − 2β)tA}, X = 2βUAUᵀ + HUᵀ − UHᵀ.
  MatrixXd at(double t, double beta) const {
    const Wide u = U.cast<long double>(), a = t * A.cast<long double>(),
               h = t * H.cast<long double>();
    const Wide X = 2 * beta * u * a * u.transpose() + h * u.transpose() - u * h.transpose();
    const Wide end = wide_exponential(X) * u * wide_exponential((1 - 2 * beta) * a);
    return end.transpose().cast<double>();
  }
};

Motion motion(const MatrixXd& Q, const MatrixXd& V) {
  const MatrixXd A = Q * V.transpose();
  return {Q.transpose(), A, V.transpose() - Q.transpose() * A};
}

Motion drawn(int n, int N, double length, double beta, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  const MatrixXd Q = testing::random_frames(n, N, 1, seed).Q_0;
  MatrixXd Z(n, N);
  for (double& x : Z.reshaped()) x = normal(generator);
  const MatrixXd S = Z * Q.transpose();
  Motion out = motion(Q, Z - (S + S.transpose()) / 2 * Q);
  const double factor = length / out.length(beta);
  out.A *= factor;
  out.H *= factor;
  return out;
}

TwoPointProblem problem(const Motion& motion, double beta) {
  TwoPointProblem out;
  out.beta = beta;
  out.Q_0 = motion.U.transpose();
  out.Q_T = motion.at(1, beta);
  return out;
}

TEST(ConnectBeta, FindsTheDrawnGeodesicWithinTheRadius) {
  for (const double beta : {0.3, 0.5, 1.0, 1.7})
    for (const auto& [n, N] : {std::pair(2, 3), {2, 5}, {3, 8}, {5, 7}, {4, 40}})
      for (const double length : {1e-6, 0.5 * pi, 0.85 * pi}) {
        SCOPED_TRACE(::testing::Message()
                     << n << " x " << N << ", beta " << beta << ", " << length);
        const Motion given = drawn(n, N, length * std::min(1.0, std::sqrt(2 * beta)), beta, 3);
        const auto answer = connect(problem(given, beta));
        ASSERT_TRUE(answer);
        EXPECT_LT((answer->Qdot - given.velocity()).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_NEAR(answer->energy, std::pow(given.length(beta), 2) / 2, 1e-12);
        if (beta == 0.5 || beta == 1) {
          EXPECT_EQ(answer->shortest, Shortest::yes);
        }
        EXPECT_EQ(answer->S.size() > 0, beta == 1);
      }
}

TEST(ConnectBeta, BeyondTheRadiusEndsAtTheFrameAndIsNotCalledShortest) {
  for (const double beta : {0.3, 0.5, 2.0})
    for (const auto& [n, N] : {std::pair(2, 4), {3, 8}, {4, 6}})
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const Motion given = drawn(n, N, 1.3 * pi, beta, seed);
        TwoPointProblem p = problem(given, beta);
        p.time = 2;
        const auto answer = connect(p);
        ASSERT_TRUE(answer);
        const Motion found = motion(answer->Q, 2 * answer->Qdot);
        EXPECT_LT((found.at(1, beta) - p.Q_T).cwiseAbs().maxCoeff(), 1e-12);
        if (found.length(beta) > pi) {
          EXPECT_NE(answer->shortest, Shortest::yes);
        }
        p.restarts = 4;
        const auto more = connect(p);
        ASSERT_TRUE(more);
        EXPECT_LE(more->energy, answer->energy * (1 + 1e-12));
      }
}

/// Most of these frames are beyond the injectivity radius, where shooting often fails.
TEST(ConnectBeta, JoinsFramesAtADistanceThatDoesNotDependOnTheirOrder) {
  for (const auto& [n, N, beta] :
       {std::tuple(6, 12, 0.5), {8, 16, 0.5}, {4, 5, 2.0}, {3, 6, 0.1}, {6, 8, 0.5}})
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE(::testing::Message() << n << " x " << N << ", beta " << beta << ", " << seed);
      TwoPointProblem p = testing::random_frames(n, N, 1, seed);
      p.inertia.resize(0);
      p.beta = beta;
      const auto there = connect(p);
      ASSERT_TRUE(there);
      const Motion found = motion(there->Q, there->Qdot);
      EXPECT_LT((found.at(1, beta) - p.Q_T).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_NEAR(there->energy, std::pow(found.length(beta), 2) / 2, 1e-11 * there->energy);
      std::swap(p.Q_0, p.Q_T);
      const auto back = connect(p);
      ASSERT_TRUE(back);
      EXPECT_NEAR(back->energy, there->energy, 1e-10 * there->energy);
    }
}

TEST(ConnectBeta, IsTheMetricOfALambdaOnSpheresAndRotations) {
  for (const auto& [n, N] : {std::pair(1, 4), {4, 4}, {3, 5}}) {
    TwoPointProblem p = testing::random_frames(n, N, 1, 2), same = p;
    const double beta = n == N ? 0.7 : 1, lambda = n == N ? beta : 1;
    p.inertia.resize(0);
    p.beta = beta;
    same.inertia.setConstant(lambda);
    const auto answer = connect(p), expected = connect(same);
    ASSERT_TRUE(answer && expected);
    EXPECT_EQ(answer->Qdot, expected->Qdot);
    EXPECT_EQ(answer->energy, expected->energy);
    EXPECT_EQ(joining_scene(p, 0, 3)->trajectory, joining_scene(same, 0, 3)->trajectory);
  }
}

TEST(ConnectBeta, HasATrajectoryWithoutAScene) {
  const Motion given = drawn(2, 5, 2, 0.5, 7);
  const auto joined = joining_scene(problem(given, 0.5), 0, 4);
  ASSERT_TRUE(joined);
  EXPECT_FALSE(joined->scene);
  ASSERT_EQ(joined->trajectory.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_LT((joined->trajectory[k] - given.at(static_cast<double>(k) / 4, 0.5)).norm(), 1e-13);
}

TEST(ConnectBeta, ExtremeNumbersEndWithATypedAnswer) {
  const Motion given = drawn(3, 6, 1, 0.5, 9);
  for (const double beta : {1e-300, 1e-12, 1e3, 1e12, 1e300}) {
    TwoPointProblem p = problem(given, 0.5);
    p.beta = beta;
    p.most_work = 1e9;
    const auto answer = connect(p);
    if (answer)
      EXPECT_LE(answer->residual, TwoPointProblem::joined);
    else
      EXPECT_TRUE(std::holds_alternative<refusal::NotConverged>(answer.error()));
  }
}

}  // namespace
}  // namespace stiefel
