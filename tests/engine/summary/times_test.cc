// States at given times, between two steps too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/engine/summary/finished_summary.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using namespace testing;

/// At a state its bits; between two states what a shorter step makes, whose error is the method's.
TEST(Times, AreOfTheMethodItself) {
  const auto error_at = [](double step) {
    const Scene scene = random_scene(3, 5, step, "rk4");
    SummaryDescription what{.to = 40};
    what.times = {0, scene.time(7), scene.time(7) + 0.3 * step, scene.time(40)};
    what.fields = {"M"};
    const Done done = run(scene, what);
    EXPECT_EQ(done.states.size(), 4);
    const auto simulation = make_simulation(scene);
    simulation->advance(7);
    const RowMatrix M = simulation->get("M");
    EXPECT_TRUE(std::ranges::equal(done.states[1].fields, std::span(M.data(), 9)));
    EXPECT_EQ(done.states[1].step, 7);
    EXPECT_EQ(done.states[2].step, 7);
    const Scene exact = random_scene(3, 5, what.times[2], "exact");
    const auto there = make_simulation(exact);
    there->advance(1);
    const RowMatrix truth = there->get("M");
    double error = 0;
    for (std::size_t i = 0; i < 9; ++i)
      error = std::max(error, std::abs(done.states[2].fields[i] - truth.data()[i]));
    return error;
  };
  const double coarse = error_at(0.2), fine = error_at(0.1);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_GT(coarse / fine, 8);
  EXPECT_GT(fine, 0);
}

TEST(Times, OfADiscreteSystemAreItsSteps) {
  const Scene scene = random_scene(3, 5, 0.1, "");
  SummaryDescription what{.to = 10};
  what.times = {0, 0.3, 0.7000000000000001, 1};
  what.fields = {"M"};
  const Done done = run(scene, what);
  ASSERT_EQ(done.states.size(), 4);
  const auto simulation = make_simulation(scene);
  for (const StateAtTime& state : done.states) {
    simulation->advance(state.step - simulation->step());
    const RowMatrix M = simulation->get("M");
    EXPECT_TRUE(std::ranges::equal(state.fields, std::span(M.data(), 9))) << state.step;
  }
  EXPECT_EQ(done.states[2].step, 7);
}

TEST(Times, OfAClosedFormAreItsStates) {
  const Scene scene = random_scene(3, 5, 0.25, "exact");
  SummaryDescription what{.to = std::int64_t{1} << 40, .every = std::int64_t{1} << 40};
  what.times = {0.1, 1e6 + 0.1, scene.time(what.to)};
  const Done done = run(scene, what);
  ASSERT_EQ(done.states.size(), 3);
  for (const StateAtTime& state : done.states) {
    const auto there = make_simulation(random_scene(3, 5, state.time, "exact"));
    there->advance(1);
    std::vector<double> truth(18);
    there->write(0, std::span(truth).first(9));
    there->write(1, std::span(truth).last(9));
    EXPECT_EQ(state.fields, truth) << state.time;
  }
}

/// Returns a number written with a few decimals, as callers write times: k times the step in
/// decimals, which is not always k · step in doubles.
double decimal(std::int64_t k, std::int64_t step_in_thousandths) {
  const std::int64_t thousandths = k * step_in_thousandths;
  const std::string digits = std::to_string(1000 + std::abs(thousandths) % 1000).substr(1);
  const std::string sign = thousandths < 0 ? "-" : "";
  return std::stod(sign + std::to_string(std::abs(thousandths) / 1000) + "." + digits);
}

/// 1.7 is step 17 of 0.1, although 17 · 0.1 is 1.7000000000000002.
TEST(Times, ThatAreAMultipleToRoundingAreThatStep) {
  for (const std::int64_t thousandths : {100, 50, 10, 300, 7, -100, -30}) {
    const Scene scene = random_scene(3, 5, decimal(1, thousandths), "rk4");
    SummaryDescription what{.from = 1, .to = 3000};
    std::vector<std::int64_t> last = {1'000'000, 12'345'678, std::int64_t{1} << 40};
    for (std::int64_t k = 1; k <= 3000; ++k) {
      what.times.push_back(decimal(k, thousandths));
      last.push_back(k);
    }
    const Done done = run(scene, what);
    ASSERT_EQ(done.states.size(), 3000);
    const auto simulation = make_simulation(scene);
    for (std::int64_t k = 1; k <= 3000; ++k) {
      simulation->advance(1);
      const RowMatrix Q = simulation->get("Q");
      const StateAtTime& state = done.states[static_cast<std::size_t>(k - 1)];
      ASSERT_EQ(state.step, k);
      ASSERT_TRUE(std::equal(Q.data(), Q.data() + 9, state.fields.begin())) << k;
    }
    for (const std::int64_t k : last) {  // alone: first and last time of the range
      SummaryDescription alone{.from = k, .to = k};
      alone.times = {decimal(k, thousandths)};
      EXPECT_TRUE(Summary::prepare(scene, alone)) << k << " steps of " << thousandths << "e-3";
      alone.times.front() *= 1 + 1e-14;
      EXPECT_FALSE(Summary::prepare(scene, alone)) << k;
    }
  }
}

/// Expects at 0, at 1, and at times next to them, in steps, the state at 0 or at 1 but for what a
/// step changes, in proportion.
void expect_continuity(const Scene& scene) {
  SummaryDescription what{.to = 1};
  std::vector<double> fractions = {0};
  for (int k = -330; k <= -1; k += k < -100 ? 23 : 3) fractions.push_back(std::pow(10, k));
  for (int k = 3; k <= 54; k += 3) fractions.push_back(1 - std::ldexp(1, -k));
  fractions.push_back(1);
  for (const double fraction : fractions) what.times.push_back(fraction * scene.step());
  const Done done = run(scene, what);
  ASSERT_EQ(done.states.size(), fractions.size());
  const auto &first = done.states.front().fields, &last = done.states.back().fields;
  double size = 0, change = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    size = std::max(size, std::abs(first[i]));
    change = std::max(change, std::abs(last[i] - first[i]));
  }
  const double rounding = size * (scene.in_float() ? 0x1p-19 : 0x1p-48);
  for (std::size_t t = 0; t < fractions.size(); ++t) {
    const double before = fractions[t], after = 1 - fractions[t];
    const auto& near = before < after ? first : last;
    for (std::size_t i = 0; i < first.size(); ++i)
      EXPECT_LE(std::abs(done.states[t].fields[i] - near[i]),
                2 * std::min(before, after) * change + rounding)
          << "element " << i << " at " << fractions[t] << " steps";
  }
}

TEST(Times, NextToAStateHaveTheStateThere) {
  for (const auto& system : catalogue().systems)
    for (const auto& method : system.methods)
      for (const char* scalar : {"double", "float"}) {
        if (method.method.empty() || (scalar[0] == 'f' && !method.in_float)) continue;
        SCOPED_TRACE(std::string(system.name) + " " + std::string(method.method) + " " + scalar);
        const bool takes_4 = !method.takes || method.takes(Eigen::VectorXd::Ones(4));
        const int N = scalar[0] == 'f' || !takes_4 ? 3 : 4;
        SceneDescription d =
            any_scene(std::string(system.name), std::string(method.method), 3, 0.05, N);
        d.method->scalar = scalar;
        expect_continuity(resolved(d));
      }
}

TEST(Times, GoBackwardsWithTheStep) {
  const Scene scene = random_scene(3, 5, -0.25, "preprocessed_variational");
  SummaryDescription what{.to = 20};
  what.times = {0, -0.1, -2.6, -5};
  EXPECT_EQ(run(scene, what).states.size(), 4);
  what.times = {-2.6, -0.1};
  EXPECT_FALSE(Summary::prepare(scene, what));
}

}  // namespace
}  // namespace stiefel
