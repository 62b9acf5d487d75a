#include <gtest/gtest.h>

#include <cmath>

#include "stiefel/summary.h"
#include "tests/support/scenes/circling_top.h"

namespace stiefel {
namespace {

/// 10⁴ zeros of m_2 are found, none twice.
TEST(EventsForLong, AreWhereTheClosedFormHasThem) {
  constexpr int count = 10'000;
  const long double half_period = testing::circling_half_period();
  const Scene scene =
      Scene::resolve(testing::circling_top(0.05, "preprocessed_variational", 10)).value();
  SummaryDescription what{.to = static_cast<std::int64_t>((count + 0.5L) * half_period / 0.05)};
  what.events = {{"M", {0, 0, 1, 0, 0, 0, 0, 0, 0}}};
  auto summary = Summary::prepare(scene, what).value();
  int found = 0;
  double worst = 0;
  while (!summary->done()) {
    summary->advance(10'000, what.to);
    for (const Event& event : summary->take_events()) {
      const auto exact = static_cast<double>(++found * half_period);
      worst = std::max(worst, std::abs(event.time - exact) / exact);
    }
  }
  EXPECT_EQ(found, count);
  EXPECT_LT(worst, 1e-12);
  RecordProperty("worst", std::to_string(worst));
}

}  // namespace
}  // namespace stiefel
