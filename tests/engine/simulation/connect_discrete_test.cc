#include <gtest/gtest.h>

#include <cmath>

#include "engine/body/moser_veselov.h"
#include "stiefel/connect.h"
#include "tests/support/scenes/two_frames.h"

namespace stiefel {
namespace {

using Eigen::MatrixXd;
using testing::random_frames;

TEST(ConnectDiscrete, IsATrajectoryOfTheMoserVeselovMap) {
  for (const int N : {3, 5}) {
    const int K = 20;
    TwoPointProblem p = random_frames(N, N, 4, 6);
    p.time = 2;
    const auto answer = connect(p, K);
    ASSERT_TRUE(answer);
    MoserVeselov<SoN<double>> map(p.inertia, p.time / K);
    MatrixXd start(2 * N, N);
    start << answer->Q[0], answer->M;
    auto state = map.start(start);
    for (int k = 1; k <= K; ++k) {
      ASSERT_TRUE(map.step(state).reached());
      EXPECT_LT((state.x.value.topRows(N) - answer->Q[k]).cwiseAbs().maxCoeff(), 1e-11);
    }
  }
}

/// [ST] (54) with differences: (Q_{k+1} − 2Q_k + Q_{k−1})Λ = BQ_k with symmetric B, its momentum
/// Q_kΛQ_{k+1}ᵀ − Q_{k+1}ΛQ_kᵀ is the same at every k, and S is the momentum at Q_0.
TEST(ConnectDiscrete, SatisfiesTheDiscreteEulerLagrangeEquations) {
  for (const auto& [n, N] : {std::pair(1, 3), {2, 5}, {3, 5}, {2, 100}, {6, 40}}) {
    const int K = 24;
    TwoPointProblem p = random_frames(n, N, 4, 8);
    p.time = 1.5;
    const auto answer = connect(p, K);
    ASSERT_TRUE(answer);
    const auto& Q = answer->Q;
    EXPECT_EQ(Q.size(), K + 1u);
    EXPECT_LT((Q[0] - p.Q_0).norm() + (Q[K] - p.Q_T).norm(), 1e-14);
    const auto L = p.inertia.asDiagonal();
    const double h = p.time / K;
    const MatrixXd m = (answer->S * Q[0].transpose() - Q[0] * answer->S.transpose()) * h;
    for (int k = 1; k < K; ++k) {
      const MatrixXd force = (Q[k + 1] - 2 * Q[k] + Q[k - 1]) * L, B = force * Q[k].transpose();
      EXPECT_LT((force - B * Q[k]).norm(), 1e-12);
      EXPECT_LT((B - B.transpose()).norm(), 1e-12);
      EXPECT_LT((Q[k + 1] * L * Q[k].transpose() - Q[k] * L * Q[k + 1].transpose() - m).norm(),
                1e-11);
    }
    const MatrixXd Qdot = answer->S * p.inertia.cwiseInverse().asDiagonal();
    EXPECT_LT((Qdot * Q[0].transpose() + Q[0] * Qdot.transpose()).norm(), 1e-12);
  }
}

TEST(ConnectDiscrete, ApproachesTheGeodesicByOrderTwo) {
  const TwoPointProblem p = random_frames(2, 5, 4, 8);
  const auto exact = connect(p);
  const auto coarse = connect(p, 32), fine = connect(p, 64);
  ASSERT_TRUE(exact && coarse && fine);
  const double order = std::log2((coarse->S - exact->S).norm() / (fine->S - exact->S).norm());
  EXPECT_GT(order, 1.9);
  EXPECT_LT(order, 2.1);
}

}  // namespace
}  // namespace stiefel
