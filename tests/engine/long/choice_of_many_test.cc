#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "tests/support/surveys/choice_survey.h"

namespace stiefel {
namespace {

/// 100 random scenes, tolerances 1e-3 … 1e-10: the error stays within them in 99, the cost within
/// twice that of the best entry of the exhaustive table in all that have one.
TEST(Choice, OfAHundredScenesIsRightAndCheap) {
  int right = 0, judged = 0, dear = 0;
  double worst_error = 0, worst_cost = 0;
  for (unsigned seed = 101; seed <= 200; ++seed) {
    const auto outcome = testing::survey_choice(seed);
    right += outcome.made && outcome.error <= 1;
    judged += outcome.cost > 0;
    dear += outcome.cost > 2;
    worst_error = std::max(worst_error, outcome.error);
    worst_cost = std::max(worst_cost, outcome.cost);
    if (!outcome.made || outcome.error > 1 || outcome.cost > 2)
      std::cout << outcome.scene << "\n  " << outcome.chosen << "\n  error/tolerance "
                << outcome.error << ", cost/best " << outcome.cost << std::endl;
  }
  std::cout << right << " of 100 within the tolerance (worst " << worst_error << "), cost at most "
            << worst_cost << " x the best of " << judged << std::endl;
  EXPECT_GE(right, 99);
  EXPECT_GE(judged, 90);
  EXPECT_EQ(dear, 0);
}

}  // namespace
}  // namespace stiefel
