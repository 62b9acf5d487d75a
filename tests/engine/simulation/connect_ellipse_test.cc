#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stiefel/connect.h"
#include "tests/support/scenes/two_frames.h"

namespace stiefel {
namespace {

using std::numbers::pi;
using testing::random_frames;

/// Both ways round the circle q = (cos φ, sin φ) from φ by `turn`: the squared length of the
/// shorter one, halved, from Gauss's rule with 40 000 nodes for the length ∫ w dφ.
double shorter_way(double l_1, double l_2, double phi, double turn) {
  const auto length = [&](double angle) {
    constexpr int panels = 10000;
    const double h = angle / panels;
    double sum = 0;
    for (int k = 0; k < panels; ++k)
      for (const auto& [x, weight] : {std::pair(0.8611363115940526, 0.3478548451374538),
                                      {0.3399810435848563, 0.6521451548625461},
                                      {-0.3399810435848563, 0.6521451548625461},
                                      {-0.8611363115940526, 0.3478548451374538}}) {
        const double at = phi + (k + (1 + x) / 2) * h;
        sum += weight / 2 * h *
               std::sqrt(l_1 * std::pow(std::sin(at), 2) + l_2 * std::pow(std::cos(at), 2));
      }
    return std::abs(sum);
  };
  return std::pow(std::min(length(turn), length(turn - std::copysign(2 * pi, turn))), 2) / 2;
}

TEST(Connect, ComparesBothWaysRoundAnEllipseWhateverTheSpread) {
  const auto joined = [](double l_1, double l_2, double from, double to) {
    TwoPointProblem p = random_frames(1, 2, 1, 1);
    p.inertia << l_1, l_2;
    p.Q_0 << std::cos(from), std::sin(from);
    p.Q_T << std::cos(to), std::sin(to);
    return connect(p);
  };
  const auto flat = joined(1, 1000, -1.941, 0.568);
  ASSERT_TRUE(flat);
  EXPECT_NEAR(flat->energy, 1295.5597, 1e-4);
  for (int k = 0; k < 100; ++k) {
    const double spread = std::pow(10, k % 6), from = 0.7 * k, turn = std::sin(1.3 * k + 1) * 3.14;
    SCOPED_TRACE(::testing::Message() << spread << " " << from << " " << turn);
    const double l_1 = k % 2 == 0 ? 1 : spread, l_2 = k % 2 == 0 ? spread : 1;
    const auto answer = joined(l_1, l_2, from, from + turn);
    ASSERT_TRUE(answer);
    const double right = shorter_way(l_1, l_2, from, turn);
    EXPECT_NEAR(answer->energy, right, 1e-9 * right);
    EXPECT_EQ(answer->shortest, Shortest::yes);
  }
}

TEST(Connect, JoinsPointsOfAnEllipsoidAtADistanceThatDoesNotDependOnTheirOrder) {
  TwoPointProblem p = random_frames(1, 3, 1, 1);
  p.inertia << 100, 9, 1;
  p.Q_0 << 0.78220425, 0.30511265, -0.54319683;
  p.Q_T << 0.43165904, -0.48679956, 0.75940547;
  p.Q_0.normalize();
  p.Q_T.normalize();
  const auto there = connect(p);
  p.Q_0.swap(p.Q_T);
  const auto back = connect(p);
  ASSERT_TRUE(there && back);
  EXPECT_NEAR(there->energy, back->energy, 1e-9 * there->energy);
}

}  // namespace
}  // namespace stiefel
