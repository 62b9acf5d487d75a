#include <gtest/gtest.h>

#include <cmath>

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
