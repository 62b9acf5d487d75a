// Events: zeros of a field, against the closed form of a top and on the states of every method.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/engine/summary/finished_summary.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/circling_top.h"

namespace stiefel {
namespace {

using namespace testing;

/// The zeros of m_2 up to `count`, both ways, rising and falling.
Done zeros_of_the_top(const Scene& scene, int count) {
  SummaryDescription what{
      .to = static_cast<std::int64_t>((count + 0.5L) * circling_half_period() / scene.step())};
  what.events = {crossing(), crossing(Direction::rising), crossing(Direction::falling)};
  what.fields = {"M"};
  return run(scene, what);
}

void expect_the_closed_form(const Done& done, int count) {
  int found = 0, up = 0, down = 0;
  for (std::size_t i = 0; i + 1 < done.events.size(); i += 2) {
    const Event &both = done.events[i], &one_way = done.events[i + 1];
    const auto exact = static_cast<double>(++found * circling_half_period());
    EXPECT_LT(std::abs(both.time - exact), 1e-12 * exact) << found;
    EXPECT_LT(std::abs(both.fields[2]), 1e-13);
    EXPECT_EQ(both.event, 0);
    EXPECT_EQ(one_way.time, both.time);
    EXPECT_EQ(one_way.event, found % 2 == 1 ? done.events[1].event : 3 - done.events[1].event);
    (one_way.event == 1 ? up : down)++;
  }
  EXPECT_EQ(found, count);
  EXPECT_EQ(done.events.size(), 2 * static_cast<std::size_t>(count));
  EXPECT_LE(std::abs(up - down), 1);
}

TEST(Events, OfATopAreWhereTheClosedFormHasThem) {
  expect_the_closed_form(
      zeros_of_the_top(resolved(circling_top(0.05, "preprocessed_variational", 10)), 50), 50);
  expect_the_closed_form(zeros_of_the_top(resolved(circling_top(0.3, "exact")), 50), 50);
}

TEST(Events, RiseWhereTheValueGoesFromNegativeToPositive) {
  const Scene scene = resolved(circling_top(0.1, "rk4"));
  const Done done = zeros_of_the_top(scene, 5);
  for (const Event& event : done.events) {
    if (event.event == 0) continue;
    const auto simulation = make_simulation(scene);
    simulation->advance(event.step);
    const double before = simulation->get("M")(0, 2);
    simulation->advance(1);
    const double after = simulation->get("M")(0, 2);
    EXPECT_EQ(before < 0 && after >= 0, event.event == 1);
    EXPECT_EQ(before > 0 && after <= 0, event.event == 2);
    EXPECT_LE(scene.time(event.step), event.time);
    EXPECT_LE(event.time, scene.time(event.step + 1));
  }
}

/// On states of any method, any system with a real field: the function is 0 to rounding there.
TEST(Events, AreFoundOnTheStatesOfEveryMethod) {
  for (const auto& system : catalogue().systems)
    for (const auto& method : system.methods) {
      const int N = method.takes && !method.takes(Eigen::VectorXd::Ones(4)) ? 3 : 4;
      const auto given =
          testing::any_scene(std::string(system.name), std::string(method.method), 3, 0.05, N);
      const Scene scene = resolved(given);
      const Field field = make_simulation(scene)->fields().front();
      if (field.complex) continue;
      SummaryDescription what{.to = 100, .fields = {field.name}};
      const auto size = static_cast<std::size_t>(field.size());
      for (std::size_t k = 0; k < size; ++k) {
        EventDescription& event = what.events.emplace_back(field.name);
        event.coefficients.resize(size);
        event.coefficients[k] = 1;
      }
      const Done done = run(scene, what);
      EXPECT_GT(done.events.size(), 0) << system.name << " " << method.method;
      for (const Event& event : done.events) {
        if (system.discrete)
          EXPECT_EQ(event.fraction, 1);
        else
          // A method that chooses its own steps is continuous in them to its tolerance only.
          EXPECT_LT(std::abs(event.fields[event.event]), method.method == "adaptive" ? 1e-9 : 1e-13)
              << system.name << " " << method.method << " step " << event.step;
      }
    }
}

/// A great circle q = (cos t, sin t) has q_1 cos a + q̇_1 sin a = cos(t + a), with coefficients of
/// either field alone or of both.
TEST(Events, OfALinearFormOfSeveralFields) {
  SceneDescription d;
  d.system = "stiefel";
  d.method = MethodDescription{"variational", 8, {}, ""};
  d.inertia = {1, 1, 1};
  d.initial = {{"Q", Block((Eigen::MatrixXd(1, 3) << 1, 0, 0).finished())},
               {"S", Block((Eigen::MatrixXd(1, 3) << 0, 1, 0).finished())}};
  d.step = 0.02;
  const Scene scene = resolved(std::move(d));
  for (const double a : {0.0, 0.4, 1.0, std::numbers::pi / 2}) {
    SummaryDescription what{.to = 2500, .fields = {"S"}};
    what.events = {{.field = "Q", .coefficients = {std::cos(a), 0, 7}, .level = 0.5},
                   {.field = "S", .coefficients = {0, 0, 0}}};
    what.events[0].plus = {{"S", {std::sin(a), 0, 0}}};
    what.events[1].level = 0.5;
    what.events[1].plus = {
        {"S", {std::sin(a) / 2, 0, 3}}, {"Q", {std::cos(a), 0, 0}}, {"S", {std::sin(a) / 2, 0, 0}}};
    const Done done = run(scene, what);
    std::vector<double> exact;
    for (int k = 0; k <= 8; ++k)
      for (const double at : {-1.0, 1.0})
        if (const double t = 2 * std::numbers::pi * k + at * std::numbers::pi / 3 - a;
            t > 0 && t <= 50)
          exact.push_back(t);
    ASSERT_EQ(done.events.size(), 2 * exact.size()) << a;
    for (std::size_t i = 0; i < done.events.size(); ++i) {
      EXPECT_NE(done.events[i].event, done.events[i ^ 1].event);
      EXPECT_NEAR(done.events[i].time, exact[i / 2], 1e-11) << a;
    }
  }
}

/// A zero 1e-301 or 1e-17 of a step after a state is in that state, not in the next one.
TEST(Events, NextToAStateAreInThatState) {
  for (const char* method : {"rk4", "preprocessed_variational", "variational", "exact"})
    for (const double omega_2 : {-1e-300, -1e-160, -1e-18}) {
      SceneDescription d;
      d.system = "rigid_body";
      d.method = MethodDescription{method, {}, {}, ""};
      d.body = BodyDescription{{}, {1, 2, 3}, {}, {1, omega_2, 2}};  // ω₂′ = ω₁ω₃ = 2
      d.step = 0.1;
      SummaryDescription what{.to = 5};
      what.events = {{"angular_velocity", {0, 1, 0}}};
      what.fields = {"angular_velocity"};
      const Done done = run(resolved(d), what);
      ASSERT_GE(done.events.size(), 1) << method << " " << omega_2;
      const Event& event = done.events.front();
      EXPECT_EQ(event.step, 0);
      EXPECT_LT(event.time, 1e-15);
      EXPECT_NEAR(event.fields[0], 1, 1e-14) << method << " " << omega_2;
      EXPECT_NEAR(event.fields[1], 0, 1e-14);
      EXPECT_NEAR(event.fields[2], 2, 1e-14);
    }
}

TEST(Events, EndAtTheirLimitAndEndTheMotion) {
  const Scene scene = resolved(circling_top(0.1, "preprocessed_variational"));
  SummaryDescription what{.to = 2000};
  what.events = {crossing()};
  what.quantities = {{"energy", {Statistic::mean}, {}, {}}, {"M", {Statistic::last}, {}, {}}};
  const Done all = run(scene, what);
  ASSERT_GT(all.events.size(), 5);
  what.events[0].limit = 3;
  const Done three = run(scene, what);
  EXPECT_EQ(three.events.size(), 3);
  EXPECT_EQ(three["last_step"].counts.front(), 2000);
  what.events[0].terminal = true;
  const Done ended = run(scene, what);
  ASSERT_EQ(ended.events.size(), 3);
  EXPECT_EQ(ended.events[2].time, all.events[2].time);
  EXPECT_EQ(ended["last_step"].counts.front(), all.events[2].step);
  EXPECT_EQ(ended["ended_by"].counts.front(), 0);
  EXPECT_EQ(ended["samples"].counts.front(), all.events[2].step + 1);
  EXPECT_TRUE(ended.status.reached());
  const auto simulation = make_simulation(scene);
  simulation->advance(all.events[2].step);
  EXPECT_EQ(ended["M.last"].numbers[2], simulation->get("M")(0, 2));
}

}  // namespace
}  // namespace stiefel
