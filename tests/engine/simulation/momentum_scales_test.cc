#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/accuracy/reference.h"
#include "engine/body/psi.h"
#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel {
namespace {

using testing::RandomBody;
using testing::resolved;

constexpr double unit_roundoff = 0x1p-53;

/// M·momentum and Λ·inertia; the step goes with Λ/M, so that h‖Ω‖ stays.
struct Scale {
  double momentum, inertia;
  double step() const { return inertia / momentum; }
};

/// Λ is scaled too where the step alone would leave 1e-153 … 1e153.
const Scale by_tens[] = {{1e-300, 1e-150}, {1e-200, 1e-60}, {1e-100, 1}, {1e-30, 1},
                         {1e-17, 1},       {1e-14, 1},      {1e-8, 1},   {0.3, 1},
                         {1, 1},           {1e8, 1},        {1e100, 1},  {1e150, 1}};
const Scale by_twos[] = {{0x1p-996, 0x1p-498}, {0x1p-664, 0x1p-199}, {0x1p-332, 1},
                         {0x1p-47, 1},         {0x1p-27, 1},         {0x1p-2, 1},
                         {0x1p5, 1},           {0x1p332, 1},         {0x1p498, 1}};

/// A body of 4 dimensions with h‖Ω‖ = 0.1.
SceneDescription body(const Scale& scale, const std::string& method, unsigned seed = 1) {
  SceneDescription d = testing::description(RandomBody(4, seed), 0.1, method);
  for (double& lambda : d.inertia) lambda *= scale.inertia;
  d.initial.at("M").values *= scale.momentum;
  *d.step *= scale.step();
  return d;
}

Conversion converted(const Scene& scene, const ConversionTarget& target) {
  auto made = convert(scene, target);
  EXPECT_TRUE(made) << target.name;
  return std::move(made).value();
}

double margin(const Conversion& conversion, std::string_view domain) {
  for (const auto& m : conversion.margins)
    if (m.domain == domain) return m.margin;
  return -1;
}

double relative(const Eigen::MatrixXd& found, const Eigen::MatrixXd& wanted) {
  return (found - wanted).cwiseAbs().maxCoeff() / wanted.cwiseAbs().maxCoeff();
}

/// A system with a P for εM, or with (Q, B), moved by a method.
struct Way {
  std::string system, method;
  friend void PrintTo(const Way& way, std::ostream* out) {
    *out << way.system << " " << way.method;
  }
};

bool has_epsilon(const SystemInfo& system) {
  return std::ranges::find(system.fields, "epsilon", &FieldInfo::name) != system.fields.end();
}

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const auto& system : catalogue().systems)
    if (has_epsilon(system) || system.name == "mclachlan_scovel")
      for (const auto& on : system.methods)
        if (on.where != "N = 3") all.push_back({std::string(system.name), std::string(on.method)});
  return all;
}

std::vector<std::string> systems_with_epsilon() {
  std::vector<std::string> all;
  for (const auto& system : catalogue().systems)
    if (has_epsilon(system)) all.emplace_back(system.name);
  return all;
}

/// μ in the units of the scale: μΛ² goes with M, for the map with hM.
ConversionTarget target(const std::string& system, const Scale& scale, double mu) {
  ConversionTarget to{system};
  if (system == "parametric_rigid_body")
    to.parameter = mu * (scale.momentum / scale.inertia) / scale.inertia;
  if (system == "parametric_moser_veselov") to.parameter = 0.1 * mu / scale.inertia;
  return to;
}

class MomentumScales : public ::testing::TestWithParam<Way> {
 protected:
  /// The body, with a method that takes every scale; with two values of Λ if the system is moved by
  /// `exact`.
  Scene rigid(const Scale& scale) const {
    SceneDescription d = body(scale, "variational");
    if (GetParam().method == "exact")
      for (std::size_t i = 2; i < d.inertia.size(); ++i) d.inertia[i] = d.inertia[i % 2];
    return resolved(d);
  }
  Scene scene(const Scale& scale) const {
    const Scene there = *converted(rigid(scale), target(GetParam().system, scale, 0.002)).scene;
    if (GetParam().method.empty()) return there;
    return there.with(MethodDescription{GetParam().method, {}, {}, ""}).value();
  }
};
std::string name_of(const ::testing::TestParamInfo<Way>& which) {
  const std::string& method = which.param.method;
  return which.param.system + (method.empty() ? "" : "_" + method);
}
INSTANTIATE_TEST_SUITE_P(Catalogue, MomentumScales, ::testing::ValuesIn(ways()), name_of);

/// Where the rates of change of a system are no longer numbers: Ṁ = [M, Ω] of a view, and the
/// squares of stages that solvers form of any rate.
bool rates_underflow(const Way& way, const Scale& scale) {
  const bool of_M = system_entry(way.system)->view != nullptr &&
                    (way.method == "rk4" || way.method == "adaptive");
  return scale.momentum < (of_M ? 1e-150 : way.method == "gauss4" ? 1e-250 : 0);
}

/// Units of momentum and time that differ by a power of two change no bit of Q, nor of M but its
/// exponent.
TEST_P(MomentumScales, PowersOfTwoChangeNoBit) {
  const auto at = [&](const Scale& scale) {
    const auto simulation = make_simulation(scene(scale));
    EXPECT_TRUE(simulation->advance(20).reached());
    return std::pair(simulation->get("Q"), simulation->get("M"));
  };
  const auto [Q, M] = at({1, 1});
  int compared = 0;
  for (const Scale& scale : by_twos) {
    if (rates_underflow(GetParam(), scale)) continue;
    ++compared;
    const auto [scaled_Q, scaled_M] = at(scale);
    const RowMatrix skew = scaled_M - scaled_M.transpose();
    const RowMatrix wanted = scale.momentum * (M - M.transpose());
    EXPECT_EQ(scaled_Q, Q) << scale.momentum;
    EXPECT_EQ(skew, wanted) << scale.momentum;
  }
  EXPECT_GE(compared, 6);
}

/// After a conversion there and back M has all its digits, ½ < ε‖M‖ ≤ 1 for μ = 0, and the
/// converted scene is accepted.
TEST(MomentumScalesConversion, KeepsTheDigitsOfM) {
  for (const auto& system : systems_with_epsilon())
    for (const Scale& scale : by_tens)
      for (unsigned seed = 1; seed <= 10; ++seed)
        for (const double mu : {0.0, 0.01, -0.01}) {
          const Scene given = resolved(body(scale, "variational", seed));
          const Conversion there = converted(given, target(system, scale, mu));
          const auto where = ::testing::Message() << system << " " << scale.momentum << " " << mu;
          for (const auto& m : there.margins) EXPECT_GT(m.margin, 0) << where << m.domain;
          const Scene again = resolved(there.scene->description());
          EXPECT_EQ(again.block("P"), there.scene->block("P")) << where;
          const double size = again.epsilon() * skew_norm(given.M());
          EXPECT_LE(size, 1) << where;
          if (mu == 0) {
            EXPECT_GT(size, 0.5) << where;
          }
          EXPECT_GT(margin(there, "1/condition of M"), 0.1) << where;
          // The method goes along, and `adaptive` refuses a body whose rate of M underflows.
          if (again.method() == "adaptive" && scale.momentum < 1e-150) continue;
          const Conversion home = converted(again, {"rigid_body"});
          EXPECT_LE(relative(home.scene->M(), given.M()), 32 * unit_roundoff) << where;
          EXPECT_LE(relative(home.scene->Q(), given.Q()), 8 * unit_roundoff) << where;
        }
}

/// With ε = 1 P represents a small M with few digits; the margin says how few.
TEST(MomentumScalesConversion, TheMarginSaysWhatAGivenEpsilonCosts) {
  for (const auto& system : systems_with_epsilon())
    for (const double momentum : {1e-3, 1e-8, 1e-12, 1e-16, 1e-20}) {
      SceneDescription d = body({momentum, 1}, "variational");
      d.step = 0.1;
      const Scene given = resolved(d);
      for (const double epsilon : {1.0, 0.1, -1.0}) {
        ConversionTarget to{system, epsilon};
        const Conversion there = converted(given, to);
        const double told = margin(there, "1/condition of M");
        EXPECT_NEAR(told, std::abs(epsilon) * skew_norm(given.M()) / 2, 0.2 * told);
        const Scene again = resolved(there.scene->description());
        const Conversion home = converted(again, {"rigid_body"});
        const auto where = ::testing::Message() << system << " " << momentum << " " << epsilon;
        EXPECT_LE(relative(home.scene->M(), given.M()), 16 * unit_roundoff / told) << where;
        if (momentum < 1e-12) continue;
        EXPECT_GE(relative(home.scene->M(), given.M()), unit_roundoff / told / 16) << where;
        EXPECT_NEAR(margin(home, "1/condition of M"), told, 1e-2 * told) << where;
      }
    }
}

/// μΛ² beside M costs as much: M is what is left of M + μΛ².
TEST(MomentumScalesConversion, TheMarginSaysWhatAParameterCosts) {
  const Scene given = resolved(body({1, 1}, "variational"));
  for (const char* system : {"parametric_rigid_body", "parametric_moser_veselov"})
    for (const double mu : {1.0, 1e4, 1e8}) {
      const Conversion there = converted(given, {system, {}, mu});
      const double told = margin(there, "1/condition of M");
      const Conversion home = converted(resolved(there.scene->description()), {"rigid_body"});
      EXPECT_LE(relative(home.scene->M(), given.M()), 32 * unit_roundoff / told)
          << system << " " << mu;
      EXPECT_LT(told, 10 / mu) << system << " " << mu;
    }
}

/// The refusal's number is that of S_M: the largest |w| of the eigenvalues iw of εM_μ.
TEST(MomentumScalesConversion, OutsideTheDomainTheNumberIsTheOneThatDecides) {
  const Scene given = resolved(body({30, 1}, "variational"));
  const double norm = skew_norm(given.M());
  for (const auto& system : systems_with_epsilon()) {
    for (const double epsilon : {1.0, 2.001 / norm}) {
      const auto refused = convert(given, {system, epsilon, {}});
      ASSERT_FALSE(refused) << system;
      const auto& outside = std::get<OutsideDomain>(refused.error());
      EXPECT_EQ(outside.bound, 2);
      EXPECT_NEAR(outside.value, epsilon * norm, 1e-9 * epsilon * norm) << system;
    }
    EXPECT_TRUE(convert(given, {system, 1.999 / norm, {}})) << system;
    const auto refused = convert(given, {system, 1e300, {}});
    ASSERT_FALSE(refused) << system;
    EXPECT_GT(std::get<OutsideDomain>(refused.error()).value, 2) << system;
  }
}

TEST(MomentumScalesConversion, RestAndDenormalNumbers) {
  for (const auto& system : systems_with_epsilon())
    for (const double size : {0.0, 0x1p-1074, 3 * 0x1p-1070, 1e-310}) {
      SceneDescription d = body({1, 1}, "variational");
      RowMatrix& M = d.initial.at("M").values;
      M.setZero();
      M(0, 1) = size;
      M(1, 0) = -size;
      const Conversion there = converted(resolved(d), {system});
      if (size == 0) {
        EXPECT_EQ(there.scene->epsilon(), 1);
      }
      const Scene again = resolved(there.scene->description());
      EXPECT_TRUE(make_simulation(again)->advance(10).reached());
      const Eigen::MatrixXd home = converted(again, {"rigid_body"}).scene->M();
      EXPECT_LE((home - M).cwiseAbs().maxCoeff(), size == 0 ? 1e-15 : 2 * 0x1p-1074)
          << system << " " << size;
    }
}

/// Where its members have different ‖M‖ an ensemble has no ε in common: each has its own, as alone.
TEST(MomentumScalesEnsemble, EachMemberChoosesItsOwnEpsilon) {
  for (const char* system : {"symmetric_rigid_body", "right_symmetric_rigid_body",
                             "reduced_rigid_body", "symmetric_moser_veselov"}) {
    std::vector<SceneDescription> alone;
    for (const double momentum : {1.0, 1e-8, 1e4, 0.0}) {
      SceneDescription d = body({1, 1}, "munthe_kaas4");
      d.system = system;
      if (d.system == "symmetric_moser_veselov") d.method.reset();
      d.initial.at("M").values *= momentum;
      d.step = 1e-5;
      alone.push_back(d);
    }
    const Scene together = resolved(testing::ensemble_of(alone));
    EXPECT_FALSE(together.description().epsilon) << system;
    const auto ensemble = make_simulation(resolved(together.description()));
    ASSERT_TRUE(ensemble->advance(20).reached());
    const auto fork = scene_at(together, *ensemble);
    ASSERT_TRUE(fork) << system << fork.error().front().rule;
    for (std::size_t b = 0; b < alone.size(); ++b) {
      const Scene one = resolved(alone[b]);
      const auto simulation = make_simulation(one);
      ASSERT_TRUE(simulation->advance(20).reached());
      for (const char* field : {"Q", "P", "M", "epsilon"})
        EXPECT_EQ(ensemble->members()[b]->get(field), simulation->get(field)) << system << b;
      const Scene& forked = fork->members()[b];
      EXPECT_EQ(forked.epsilon(), one.epsilon()) << system << b;
      EXPECT_LE((forked.M() - simulation->get("M")).norm(), 1e-14 * one.M().norm()) << system;
    }
  }
}

/// P and S of a geodesic are linear in the momentum, so no scale loses a digit or changes a bit.
TEST(MomentumScalesOfFrames, PowersOfTwoChangeNoBit) {
  for (const char* system : {"stiefel", "stiefel_costate", "stiefel_momentum", "ellipsoid"})
    for (const auto& on : catalogue().system(system)->methods) {
      if (on.method == "exact") continue;  // Λ = I
      const auto at = [&](const Scale& scale) {
        SceneDescription d =
            testing::any_scene(std::string_view(system) == "ellipsoid" ? "ellipsoid" : "stiefel",
                               "variational", 1, 0.1);
        for (double& lambda : d.inertia) lambda *= scale.inertia;
        *d.step *= scale.step();
        if (d.system == "ellipsoid")
          d.initial.at("qdot").values /= scale.step();
        else
          d.initial.at("S").values *= scale.momentum;
        SceneDescription there = converted(resolved(d), {system}).scene->description();
        there.method = MethodDescription{std::string(on.method), {}, {}, ""};
        const Scene scene = resolved(there);
        const auto simulation = make_simulation(scene);
        EXPECT_TRUE(simulation->advance(20).reached());
        return simulation->get(d.system == "ellipsoid" ? "q" : "Q");
      };
      const RowMatrix Q = at({1, 1});
      for (const Scale& scale : by_twos) {
        if (scale.momentum < 1e-150) continue;  // Ṡ ~ ‖S‖‖Q̇‖ is no number
        EXPECT_EQ(at(scale), Q) << system << " " << on.method << " " << scale.momentum;
      }
    }
}

}  // namespace
}  // namespace stiefel
