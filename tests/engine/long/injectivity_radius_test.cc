#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "engine/frames/geodesics/geodesic_series.h"
#include "stiefel/conjugate_points.h"
#include "stiefel/connect.h"
#include "tests/support/scenes/two_frames.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Whether Connect, with restarts, finds no other way to the end of the geodesic from (Q, V) of
/// unit speed at the time t that is as short.
bool is_the_shortest(const VectorXd& lambda, const MatrixXd& Q, const MatrixXd& V, double t) {
  TwoPointProblem problem{.inertia = lambda, .Q_0 = Q, .Q_T = *geodesic_end(lambda, Q, t * V)};
  problem.restarts = 12;
  const auto found = connect(problem);
  if (!found) return false;
  const double length = std::sqrt(2 * found->energy), apart = (found->Qdot - t * V).norm() / t;
  return length >= t * (1 - 1e-13) - 1e-13 && apart < 1e-4;
}

/// A wide Λ for which no start of the search leads to a minimum, so that it proves nothing itself.
TEST(InjectivityRadius, AGeodesicPastAConjugatePointIsNotTheShortest) {
  const TwoPointProblem problem = testing::random_frames(2, 4, 1e4, 5);
  const auto found = connect(problem);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->shortest, Shortest::no);
  EXPECT_LE(found->residual, TwoPointProblem::joined);
  const auto passed = conjugate_points({problem.inertia, found->Q, found->Qdot, problem.time});
  ASSERT_TRUE(passed && !passed->points.empty());
  EXPECT_LT(passed->points.front().time, problem.time);
}

/// Λ in equal steps from 1 to `ratio`.
struct Row {
  Index n, N;
  double ratio, radius;
};

/// The table of docs/conjugate_points.md.
class InjectivityRadiusTable : public ::testing::TestWithParam<Row> {};

TEST_P(InjectivityRadiusTable, AgreesWithConnect) {
  const Row& row = GetParam();
  const VectorXd lambda = VectorXd::LinSpaced(row.N, 1, row.ratio);
  const auto found = injectivity_radius({lambda, row.n, 1, 6});
  ASSERT_TRUE(found && found->status.reached());
  EXPECT_NEAR(found->upper, row.radius, 1e-8);
  EXPECT_TRUE(is_the_shortest(lambda, found->Q, found->Qdot, found->upper * (1 - 1e-6)));
  EXPECT_FALSE(is_the_shortest(lambda, found->Q, found->Qdot, found->upper * (1 + 1e-6)));
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const TwoPointProblem frames =
        testing::random_frames(static_cast<int>(row.n), static_cast<int>(row.N), 1, seed);
    const MatrixXd half = frames.Q_T * frames.Q_0.transpose();
    MatrixXd V = frames.Q_T - (half + half.transpose()) / 2 * frames.Q_0;
    V /= std::sqrt((V.cwiseAbs2() * lambda).sum());
    EXPECT_TRUE(is_the_shortest(lambda, frames.Q_0, V, 0.999 * found->upper)) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(, InjectivityRadiusTable,
                         ::testing::Values(Row{1, 3, 2, 2.8439795676}, Row{1, 3, 4, 2.5912470834},
                                           Row{1, 3, 10, 2.3880632248}, Row{2, 4, 2, 2.7361678228},
                                           Row{2, 4, 4, 2.3776138349}, Row{2, 4, 10, 2.0759368008},
                                           Row{3, 5, 2, 2.6802731398}, Row{3, 5, 4, 2.2625085694},
                                           Row{3, 5, 10, 1.9001898497}),
                         [](const auto& tested) {
                           const Row& row = tested.param;
                           return "V" + std::to_string(row.n) + std::to_string(row.N) + "Ratio" +
                                  std::to_string(static_cast<int>(row.ratio));
                         });

}  // namespace
}  // namespace stiefel
