// Error against cost, measured.
#include "stiefel/tradeoff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/accuracy/search.h"
#include "stiefel/catalogue.h"
#include "stiefel/price.h"
#include "tests/support/exact_motion.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/surveys/measured_tradeoff.h"

namespace stiefel {
namespace {

using testing::measured_tradeoff;
using testing::RandomBody;

bool same_entry(const TradeoffPoint& a, const TradeoffPoint& b) {
  return a.method.name == b.method.name && a.method.order == b.method.order &&
         a.method.substeps == b.method.substeps && a.method.tolerance == b.method.tolerance &&
         a.method.arithmetic == b.method.arithmetic && a.method.scalar == b.method.scalar;
}

double rounding(const TradeoffPoint& p) { return p.method.scalar == "float" ? 0x1p-24 : 0x1p-53; }

/// Against Boost.odeint in extended precision, which shares no code with the reference.
TEST(Tradeoff, MeasuresTheErrorsOfAttitudeAndMomentum) {
  for (const int N : {3, 5}) {
    const RandomBody body(N, 7);
    const SceneDescription scene = testing::description(body, 0.25, "variational");
    const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, 5);
    const auto table = measured_tradeoff(scene, 5);
    EXPECT_EQ(table.setup.steps, 20);
    ASSERT_GT(table.points.size(), 60u);
    for (const auto& point : table.points) {
      if (!point.error || point.extrapolated) continue;
      const auto now = make_simulation(Scene::resolve(scene).value().with(point.method).value());
      ASSERT_TRUE(now->advance(20).reached());
      const double attitude = (now->get("Q") - exact.Q).cwiseAbs().maxCoeff();
      const double momentum =
          (now->get("M") - exact.M).cwiseAbs().maxCoeff() / exact.M.cwiseAbs().maxCoeff();
      EXPECT_NEAR(*point.error->attitude, attitude, 1e-3 * attitude + 5e-16);
      EXPECT_NEAR(point.error->momentum, momentum, 1e-3 * momentum + 5e-16);
      EXPECT_EQ(point.measured_steps, 20);
      EXPECT_EQ(point.cpu_seconds_per_second.size(), 1u);
    }
  }
}

TEST(Tradeoff, KnowsEveryMethodInEachOrderAndArithmetic) {
  const auto table = measured_tradeoff(testing::description(RandomBody(4, 1), 0.25, "rk4"), 2.5);
  for (const auto& on : catalogue().system("rigid_body")->methods)
    for (const int order : catalogue().method(on.method)->orders)
      for (const char* arithmetic : {"plain", "compensated"}) {
        int smaller = 0, count = 0;
        double last = 1;
        for (const auto& p : table.points)
          if (p.method.name == on.method && p.method.order == order &&
              p.method.arithmetic == arithmetic && p.error) {
            ++count;
            smaller += p.error->largest() < last;
            last = p.error->largest();
          }
        if (count == 0 && !catalogue().method(on.method)->default_tolerance)
          continue;  // a method for other N
        EXPECT_GE(count, 3) << on.method;
        EXPECT_GE(smaller, 2) << on.method;
      }
}

TEST(Tradeoff, CountsWorkAndNotTime) {
  const auto scene = testing::description(RandomBody(3, 2), 0.25, "rk4");
  const auto once = measured_tradeoff(scene, 10), again = measured_tradeoff(scene, 10);
  ASSERT_EQ(once.points.size(), again.points.size());
  for (std::size_t i = 0; i < once.points.size(); ++i) {
    const auto &a = once.points[i], &b = again.points[i];
    ASSERT_TRUE(same_entry(a, b));
    EXPECT_EQ(a.work, b.work);
    EXPECT_EQ(a.measured_steps, b.measured_steps);
    ASSERT_EQ(a.error.has_value(), b.error.has_value());
    if (!a.error) continue;
    EXPECT_EQ(a.error->largest(), b.error->largest());
    if (a.method.tolerance || a.extrapolated) continue;
    EXPECT_DOUBLE_EQ(a.work, 40 * *a.method.substeps *
                                 step_weight(Scene::resolve(scene).value().with(a.method).value()));
  }
  EXPECT_EQ(once.front, again.front);
}

TEST(Tradeoff, MarksWhatNoOtherPointBeats) {
  const auto table = measured_tradeoff(testing::description(RandomBody(4, 4), 0.25, "rk4"), 10);
  const auto error = [&](const TradeoffPoint& p) {
    return std::max(p.error->largest(), table.setup.reference_error);
  };
  ASSERT_GT(table.front.size(), 3u);
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const auto& p = table.points[i];
    if (!p.error) continue;
    // Of points equal in both only the first is on the front.
    const bool beaten = std::ranges::any_of(table.points, [&](const TradeoffPoint& q) {
      return q.error && q.work <= p.work && error(q) <= error(p) &&
             (q.work < p.work || error(q) < error(p) || &q < &p);
    });
    const bool marked = std::ranges::find(table.front, i) != table.front.end();
    EXPECT_EQ(marked, !beaten) << to_text(p.method);
  }
}

TEST(ParetoFront, HasNoPointThatIsBeatenOrIsNoNumber) {
  EXPECT_EQ(pareto_front({{1, 5}, {2, 3}, {2, 4}, {3, 3}, {4, 1}, {0.5, std::nan("")}}),
            (std::vector<std::size_t>{0, 1, 4}));
  EXPECT_EQ(pareto_front({{1, 1}, {1, 1}}), std::vector<std::size_t>{0});
  EXPECT_TRUE(pareto_front({{1, std::nan("")}}).empty());
}

/// With a small budget all runs are over the same part of the horizon. Their extrapolation to the
/// horizon is close to the measurement there. Those in single precision are measured to the end or
/// left out.
TEST(Tradeoff, ExtrapolatesWhatTheBudgetDoesNotReach) {
  int extrapolated = 0, near = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const int N = 3 + seed % 3;
    const auto scene = testing::description(RandomBody(N, seed), 0.25, "rk4");
    const auto whole = measured_tradeoff(scene, 100, 5e10),
               part = measured_tradeoff(scene, 100,
                                        N == 3   ? 1e8
                                        : N == 4 ? 4e8
                                                 : 4e9);
    for (const auto& p : part.points) {
      EXPECT_EQ(p.extrapolated, p.measured_steps < 400 && p.error);
      if (!p.extrapolated) continue;
      EXPECT_EQ(p.method.scalar, "double");
      for (const auto& q : whole.points) {
        if (!same_entry(p, q) || q.extrapolated || !q.error) continue;
        EXPECT_NEAR(p.work / q.work, 1, 0.2);
        if (q.error->largest() > 0.1 || q.error->largest() < 1e4 * rounding(q))
          continue;  // saturated; rounding
        const double ratio = p.error->largest() / q.error->largest();
        ++extrapolated;
        near += ratio > 0.25 && ratio < 4;
        EXPECT_GT(ratio, 0.0625) << to_text(p.method) << " " << p.measured_steps;
        EXPECT_LT(ratio, 16) << to_text(p.method) << " " << p.measured_steps;
      }
    }
  }
  EXPECT_GT(extrapolated, 30);
  EXPECT_GT(near, 0.9 * extrapolated);
}

/// In three dimensions cheap methods reach the rounding errors, which grow in proportion to time,
/// or in compensated arithmetic hardly, while the error of the method grows up to quadratically.
/// The error at one time may be far below that at other times, where an error oscillates or is a
/// random walk.
TEST(Tradeoff, ExtrapolatesRoundingErrorsAsSuch) {
  int compensated = 0;
  for (const unsigned seed : {3, 9}) {
    const auto scene = testing::description(RandomBody(3, seed), 0.25, "rk4");
    const auto whole = measured_tradeoff(scene, 100, 2e10);
    for (const double budget : {1.4e8, 8e7})
      for (const auto& p : measured_tradeoff(scene, 100, budget).points) {
        if (!p.extrapolated) continue;
        for (const auto& q : whole.points) {
          if (!same_entry(p, q) || q.extrapolated || !q.error) continue;
          if (q.error->largest() > 0.1) continue;
          const double ratio = p.error->largest() / q.error->largest();
          EXPECT_LT(ratio, 10) << to_text(p.method) << " from " << p.measured_steps << " steps";
          if (p.method.arithmetic != "compensated") continue;
          ++compensated;
          EXPECT_GT(ratio, 1.0 / 8) << to_text(p.method) << " from " << p.measured_steps;
        }
      }
  }
  EXPECT_GT(compensated, 100);
}

/// For so small a budget the reference is in extended precision.
TEST(Tradeoff, HasNoErrorBelowThatOfTheReference) {
  const auto table = measured_tradeoff(testing::any_scene("double_bracket", "rk4", 1, 0.25), 40);
  EXPECT_GT(table.setup.reference_error, 1e-17);
  for (const auto& p : table.points) {
    if (!p.error) continue;
    EXPECT_GE(*p.error->attitude, table.setup.reference_error);
    EXPECT_GE(p.error->momentum, table.setup.reference_error);
    if (p.below_reference && !p.extrapolated) {
      EXPECT_EQ(p.error->largest(), table.setup.reference_error);
    }
  }
}

/// At rest every method agrees with the reference to the last bit; the error reported is that of
/// the reference.
TEST(Tradeoff, NeverSaysThatAnErrorIsZero) {
  SceneDescription rest = testing::description(RandomBody(4, 2), 0.25, "rk4");
  rest.initial["M"] = RowMatrix(RowMatrix::Zero(4, 4));
  const auto table = measured_tradeoff(rest, 5);
  ASSERT_GT(table.setup.reference_error, 0);
  ASSERT_GT(table.points.size(), 5u);
  int below = 0;
  for (const auto& p : table.points) {
    ASSERT_TRUE(p.error) << to_text(p.method);
    EXPECT_GE(*p.error->attitude, table.setup.reference_error) << to_text(p.method);
    EXPECT_GE(p.error->momentum, table.setup.reference_error) << to_text(p.method);
    below += p.below_reference;
  }
  EXPECT_GT(below, 0);
}

TEST(Tradeoff, LooksAtTheInvariantsOverTheRun) {
  const auto table = measured_tradeoff(testing::description(RandomBody(4, 3), 0.25, "rk4"), 25);
  for (const auto& p : table.points) {
    if (!p.error) continue;
    if (p.method.name == "variational") {
      EXPECT_LT(p.drift, 1e4 * rounding(p)) << to_text(p.method);
    } else if (p.method.name == "rk4" && *p.method.substeps == 1) {
      EXPECT_GT(p.drift, 1e-5);
    }
  }
}

TEST(Tradeoff, OfAStepTooLongSaysSoAndGoesOn) {
  const auto table = measured_tradeoff(testing::description(RandomBody(4, 3), 3, "rk4"), 30);
  const auto stopped = std::ranges::count_if(table.points, [](const TradeoffPoint& p) {
    return p.status.outcome == Outcome::left_domain && !p.error;
  });
  EXPECT_GT(stopped, 0);
  EXPECT_TRUE(std::ranges::any_of(table.points, [](const TradeoffPoint& p) {
    return p.method.name == "variational" && p.error && p.error->largest() < 1e-8;
  }));
}

/// A method without a price has an estimated one, and the scene has a warning.
TEST(StepWeight, IsCountedOrSaidToBeEstimated) {
  int counted = 0;
  for (const auto& [system, method, N] : testing::every_pair()) {
    const auto made = Scene::resolve(testing::any_scene(system, method, 1, 0.1, N));
    if (!made || method.empty()) continue;
    EXPECT_GT(step_weight(*made), 0);
    const auto said = warnings(*made);
    const bool estimated = std::ranges::any_of(
        said, [](const std::string& text) { return text.find("is estimated") != text.npos; });
    EXPECT_NE(is_weighed(*made), estimated) << system << " " << method;
    counted += is_weighed(*made);
  }
  EXPECT_GT(counted, 40);
}

/// Steps that callgrind counted at h‖Ω‖ = 0.1.
TEST(StepWeight, IsWithinAQuarterOfCountedSteps) {
  struct {
    const char *system, *method;
    int order;
    const char* arithmetic;
    int N;
    double instructions;
  } const counts[] = {{"rigid_body", "variational", 2, "plain", 3, 590},
                      {"rigid_body", "variational", 8, "plain", 3, 9132},
                      {"rigid_body", "variational", 2, "compensated", 4, 5107},
                      {"rigid_body", "variational", 2, "compensated", 8, 6.403e4},
                      {"rigid_body", "variational", 6, "compensated", 16, 1.894e6},
                      {"rigid_body", "variational", 2, "plain", 64, 2.38e6},
                      {"rigid_body", "preprocessed_variational", 10, "compensated", 3, 1979},
                      {"rigid_body", "exact", 0, "compensated", 3, 1869},
                      {"rigid_body", "rk4", 4, "compensated", 7, 3.508e4},
                      {"rigid_body", "adaptive", 8, "plain", 32, 2.674e6},
                      {"symmetric_rigid_body", "variational", 4, "plain", 12, 3.469e5}};
  for (const auto& count : counts) {
    SceneDescription d = testing::description(RandomBody(count.N, 1), 0.1, count.method);
    d.system = count.system;
    d.method->arithmetic = count.arithmetic;
    if (count.order > 0) d.method->order = count.order;
    const double weight = step_weight(Scene::resolve(d).value());
    EXPECT_NEAR(weight, count.instructions, count.instructions / 4)
        << count.system << " " << count.method << " " << count.N;
  }
}

}  // namespace
}  // namespace stiefel
