#include <gtest/gtest.h>

#include <cmath>

#include "stiefel/summary.h"

namespace stiefel {
namespace {

/// The zeros of m_2 of the top with I = (1, 2, 3) and m = (0.5, 0, 1.5) are the multiples of 2K/p,
/// with p = 1/2, k² = 1/3 and K by the arithmetic-geometric mean. 10⁴ are found, none twice.
TEST(EventsForLong, AreWhereTheClosedFormHasThem) {
  constexpr int count = 10'000;
  long double a = 1, b = std::sqrt(2 / 3.0L);
  for (int i = 0; i < 10; ++i) {
    const long double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  const long double half_period = 2 * std::acos(-1.0L) / a;

  SceneDescription top;
  top.system = "rigid_body";
  top.step = 0.05;
  top.method.emplace().name = "preprocessed_variational";
  top.method->order = 10;
  top.inertia = {2, 1, 0};
  top.initial["Q"] = RowMatrix(RowMatrix::Identity(3, 3));
  RowMatrix M(3, 3);
  M << 0, -1.5, 0, 1.5, 0, -0.5, 0, 0.5, 0;
  top.initial["M"] = M;
  const Scene scene = Scene::resolve(top).value();

  SummaryDescription what{.to = static_cast<std::int64_t>((count + 0.5L) * half_period / 0.05)};
  what.events = {{"M", {0, 0, 1, 0, 0, 0, 0, 0, 0}}};
  auto summary = Summary::prepare(scene, what).value();
  int found = 0;
  double worst = 0;
  while (!summary.done()) {
    summary.advance(10'000, what.to);
    for (const Event& event : summary.take_events()) {
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
