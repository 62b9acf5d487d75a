#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::RandomBody;

SceneDescription described(double momentum, double step) {
  SceneDescription d = testing::description(RandomBody(3, 1), step, "variational");
  d.initial.at("M").values *= momentum;
  return d;
}

std::string refusal(const SceneDescription& d) {
  const auto scene = Scene::resolve(d);
  return scene ? "" : scene.error().front().field + ": " + scene.error().front().rule;
}

TEST(Units, DenormalMomentaKeepTheirDigits) {
  SceneDescription d = described(1, 0.1);
  RowMatrix& M = d.initial.at("M").values;
  M.setZero();
  M(0, 1) = 3 * 0x1p-1074;
  M(1, 0) = -M(0, 1);
  EXPECT_EQ(Scene::resolve(d).value().M()(0, 1), M(0, 1));
}

TEST(Units, InvariantsAreNumbersFrom1eMinus150To1e150) {
  for (const double momentum : {1e-150, 1e150}) {
    const Scene scene = Scene::resolve(described(momentum, 0.1 / momentum)).value();
    const auto simulation = make_simulation(scene);
    ASSERT_TRUE(simulation->advance(50).reached());
    const Diagnosis diagnosis = diagnose(scene, *simulation);
    ASSERT_FALSE(diagnosis.invariants.empty());
    for (const auto& invariant : diagnosis.invariants) {
      EXPECT_TRUE(std::isfinite(static_cast<double>(invariant.value))) << invariant.name;
      EXPECT_LT(invariant.drift(), 1e-14) << invariant.name;
    }
  }
}

/// Units of mass that differ by a power of two change no bit of a motion, even near the ends of the
/// range of doubles.
TEST(Units, OfMassChangeNoBitOfTheVariationalStep) {
  const auto Q_after = [](const SceneDescription& d) {
    const auto simulation = make_simulation(Scene::resolve(d).value());
    EXPECT_TRUE(simulation->advance(20).reached());
    return simulation->get("Q");
  };
  for (const char* system : {"rigid_body", "stiefel"})
    for (const char* arithmetic : {"compensated", "plain"})
      for (const double unit : {0x1p-460, 0x1p460}) {
        SceneDescription d = testing::any_scene(system, "variational", 1, 0.1);
        d.method->arithmetic = arithmetic;
        const Eigen::MatrixXd Q = Q_after(d);
        for (double& lambda : d.inertia) lambda *= unit;
        d.initial.at(d.system == "stiefel" ? "S" : "M").values *= unit;
        EXPECT_EQ(Q_after(d), Q) << system << " " << arithmetic << " " << unit;
      }
}

TEST(Units, WhatIsOutOfReachIsRefusedByRule) {
  EXPECT_NE(refusal(described(1, 1e-200)).find("step: |step| must be 1e-153"), std::string::npos);
  EXPECT_NE(refusal(described(1, 1e200)).find("other units"), std::string::npos);
  EXPECT_NE(refusal(described(1e200, 1)).find("initial.M: max |M|"), std::string::npos);
  SceneDescription d = described(1, 0.1);
  for (double& l : d.inertia) l *= 1e200;
  EXPECT_NE(refusal(d).find("inertia: must be 1e-153"), std::string::npos);
}

TEST(Units, DoubleBracketsOfLargeMatricesHaveARate) {
  SceneDescription d = testing::any_scene("double_bracket", "rk4", 1, 0.1);
  d.initial.at("P").values(0, 0) = 1e153;
  const auto simulation = make_simulation(Scene::resolve(d).value());
  EXPECT_TRUE(std::isfinite(simulation->rate()));
  EXPECT_GT(simulation->rate(), 1e150);
  d.initial.at("P").values(0, 0) = 1e154;
  EXPECT_NE(refusal(d).find("initial.P: max |P| must be 1e-153"), std::string::npos) << refusal(d);
}

/// A body in units of mass and time that are `mass` and 1/`rate` times those of a body with moments
/// of 1 to 3 and rates of about 1; its step turns it by `turn`.
SceneDescription in_units(double mass, double rate, double turn, const std::string& method) {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{method, {}, {}, ""};
  d.body = BodyDescription{{}, {mass, 2 * mass, 3 * mass}, {}, {0.3 * rate, rate, -0.5 * rate}};
  d.step = turn / rate;
  return d;
}

/// The motion does not depend on the units, so each pair of units is refused, or gives the attitude
/// that units of 1 give.
TEST(Units, AreRefusedOrGiveTheSameMotion) {
  const double ends[] = {1e-320, 1e-310, 1e-200, 1e-160, 1e-153, 1e-150, 1e-77, 1e-30,
                         1,      1e30,   1e77,   1e150,  1e153,  1e155,  1e200, 1e307};
  int accepted = 0, refused = 0;
  for (const char* method : {"exact", "rk4", "preprocessed_variational", "variational", "splitting",
                             "munthe_kaas4", "adaptive"})
    for (const double turn : {0.1, 1e-12}) {
      const auto unit = make_simulation(Scene::resolve(in_units(1, 1, turn, method)).value());
      ASSERT_TRUE(unit->advance(20).reached());
      const Eigen::MatrixXd Q = unit->get("Q");
      for (const double mass : ends)
        for (const double rate : ends) {
          const SceneDescription d = in_units(mass, rate, turn, method);
          const auto scene = Scene::resolve(d);
          ++(scene ? accepted : refused);
          if (!scene) {
            for (const Violation& v : scene.error())
              EXPECT_FALSE(v.rule.empty() || v.value.empty());
            continue;
          }
          const auto simulation = make_simulation(*scene);
          ASSERT_TRUE(simulation->advance(20).reached()) << method << mass << " " << rate;
          EXPECT_LT((simulation->get("Q") - Q).norm(),
                    1e-13 * (1 + 1e5 * turn * (method[0] == 'a')))
              << method << ", mass " << mass << ", rate " << rate << ", turn " << turn;
        }
    }
  EXPECT_GT(accepted, 500);
  EXPECT_GT(refused, 500);
}

TEST(Units, OfABodyOutOfReachAreRefusedByField) {
  const auto field = [](double mass, double rate) {
    const auto scene = Scene::resolve(in_units(mass, rate, 0.1, "exact"));
    return scene ? std::string() : scene.error().front().field;
  };
  EXPECT_EQ(field(1e-310, 1), "body.moments");
  EXPECT_EQ(field(1e307, 1), "body.moments");
  EXPECT_EQ(field(1e100, 1e60), "body.angular_velocity");
  EXPECT_EQ(field(1e-100, 1e152), "");
  SceneDescription d = in_units(1, 1, 0.1, "exact");
  d.body->angular_velocity[2] = 1e155;
  EXPECT_NE(refusal(d).find("body.angular_velocity: max |ω| must be 1e-153"), std::string::npos);
  d = in_units(1, 1, 1e17, "exact");
  EXPECT_NE(refusal(d).find("step: |step| max |ω| must be at most"), std::string::npos);
  d = in_units(1e-150, 1e-150, 0.1, "rk4");
  EXPECT_NE(refusal(d).find("method.name: sums the rate"), std::string::npos) << refusal(d);
}

/// Whatever number of a scene is far away, alone or with another one, the scene is refused or every
/// state that is reached is finite.
TEST(Units, FarNumbersAreRefusedOrHaveFiniteStates) {
  const double far[] = {1e-310, 1e-160, 1e155, 1e307};
  for (const auto& system : catalogue().systems)
    for (const auto& on : system.methods) {
      const std::string method(on.method);
      const int N = on.takes && !on.takes(Eigen::VectorXd::Ones(4)) ? 3 : 4;
      const SceneDescription plain =
          Scene::resolve(testing::any_scene(std::string(system.name), method, 1, 0.1, N))
              .value()
              .description();
      std::vector<std::function<void(SceneDescription&, double)>> numbers = {
          [](SceneDescription& d, double x) { d.step = x; },
          [](SceneDescription& d, double x) {
            if (d.epsilon) d.epsilon = x;
          },
          [](SceneDescription& d, double x) {
            if (d.parameter) d.parameter = x;
          },
          [](SceneDescription& d, double x) {
            for (double& l : d.inertia) l *= x;
          },
          [](SceneDescription& d, double x) {
            if (!d.inertia.empty()) d.inertia[1] = x;
          },
          [](SceneDescription& d, double x) {
            for (double& l : d.inertia_u) l *= x;
          }};
      for (const auto& [name, block] : plain.initial)
        numbers.push_back(
            [name = name](SceneDescription& d, double x) { d.initial.at(name).values *= x; });
      for (std::size_t a = 0; a < numbers.size(); ++a)
        for (std::size_t b = a; b < numbers.size(); ++b)
          for (const double x : far)
            for (const double y : {1.0, 1e-310, 1e-160, 1e155, 1e307}) {
              SceneDescription d = plain;
              numbers[a](d, x);
              if (a != b) numbers[b](d, y);
              const auto scene = Scene::resolve(d);
              if (!scene) continue;
              const auto simulation = make_simulation(*scene);
              while (simulation->step() < 3 && simulation->advance(1).reached())
                for (const Field& field : simulation->fields())
                  ASSERT_TRUE(simulation->get(field.name).allFinite())
                      << system.name << " " << method << " " << field.name << ", numbers " << a
                      << " and " << b << ": " << x << ", " << y;
            }
    }
}

/// A refusal names what works.
TEST(Units, RefusalsNameWhatWorks) {
  SceneDescription d = testing::description(RandomBody(4, 1), 0.1, "exact");
  EXPECT_NE(refusal(d).find("variational takes every Lambda"), std::string::npos);

  d = testing::description(RandomBody(3, 1), 0.1, "variational");
  d.system = "symmetric_rigid_body";
  d.initial.at("M").values *= 5;
  d.epsilon = 1;
  EXPECT_NE(refusal(d).find("without epsilon the scene takes 0."), std::string::npos) << refusal(d);
  d.epsilon.reset();
  EXPECT_EQ(refusal(d), "");

  d = testing::description(RandomBody(3, 1), 3, "variational");
  const Scene long_step = Scene::resolve(d).value();
  const RunStatus status = make_simulation(long_step)->advance(1);
  ASSERT_EQ(status.outcome, Outcome::left_domain);
  EXPECT_NE(to_sentence(status, long_step).find("exact takes every step"), std::string::npos);
  d.method->name = "exact";
  EXPECT_TRUE(make_simulation(Scene::resolve(d).value())->advance(1).reached());
}

}  // namespace
}  // namespace stiefel
