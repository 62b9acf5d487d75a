// States at given times, between two steps too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "stiefel/simulation.h"
#include "tests/engine/summary/summaries.h"
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
