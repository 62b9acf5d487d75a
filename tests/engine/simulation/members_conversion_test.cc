// Convert of ensembles.
#include <gtest/gtest.h>

#include <algorithm>

#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using testing::ensemble_of;
using testing::RandomBody;

std::vector<SceneDescription> bodies(const std::vector<double>& momenta, double step = 0.05) {
  std::vector<SceneDescription> all;
  for (std::size_t b = 0; b < momenta.size(); ++b) {
    RandomBody body(3, static_cast<unsigned>(b + 5));
    body.M *= momenta[b] / body.M.norm();
    all.push_back(testing::description(body, step, "rk4"));
  }
  return all;
}

std::vector<SceneDescription> geodesics() {
  std::vector<SceneDescription> all;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const testing::RandomFrame<double> frame(2, 5, seed, 1);
    SceneDescription d;
    d.system = "stiefel";
    d.inertia = {frame.lambda.begin(), frame.lambda.end()};
    d.initial = {{"Q", Block(frame.Q)}, {"S", Block(frame.S)}};
    d.step = 0.05;
    all.push_back(d);
  }
  return all;
}

double smallest(const std::vector<Conversion>& each, const std::string& domain) {
  double least = std::numeric_limits<double>::infinity();
  for (const Conversion& one : each)
    for (const Margin& margin : one.margins)
      if (margin.domain == domain) least = std::min(least, margin.margin);
  return least;
}

/// To every target that the members reach: states, blocks and margins are the members' own.
void expect_the_members(const std::vector<SceneDescription>& scenes) {
  const Scene ensemble = resolve_recommending(ensemble_of(scenes)).value();
  std::vector<std::string> targets(std::begin(other_targets), std::end(other_targets));
  for (const SystemInfo& system : catalogue().systems) targets.emplace_back(system.name);
  int reached = 0;
  for (const std::string& name : targets) {
    ConversionTarget target{name};
    if (name.starts_with("parametric")) target.parameter = 0.1;
    const auto together = convert(ensemble, target);
    std::vector<Conversion> each;
    for (const Scene& member : ensemble.members())
      if (auto one = convert(member, target)) each.push_back(*std::move(one));
    ASSERT_EQ(together.has_value(), each.size() == scenes.size()) << name;
    if (!together) continue;
    ++reached;
    // An ensemble of a parametric system has one ε in common, and the margins of that.
    const bool other_epsilon = name.starts_with("parametric");
    for (const Margin& margin : together->margins)
      EXPECT_TRUE(other_epsilon || margin.margin == smallest(each, margin.domain))
          << name << " " << margin.domain;
    for (const auto& [block, all] : together->blocks)
      for (std::size_t b = 0; b < each.size(); ++b) {
        const Eigen::MatrixXd& one = each[b].blocks.at(block);
        EXPECT_EQ(all.middleRows(static_cast<Eigen::Index>(b) * one.rows(), one.rows()), one)
            << name << " " << block;
      }
    ASSERT_EQ(together->scene.has_value(), each.front().scene.has_value()) << name;
    if (!together->scene) continue;
    ASSERT_EQ(together->scene->members().size(), each.size()) << name;
    for (std::size_t b = 0; b < each.size(); ++b) {
      const Scene& member = together->scene->members()[b];
      const Scene& alone = *each[b].scene;
      EXPECT_EQ(member.inertia(), alone.inertia()) << name;
      if (alone.description().method && scenes.front().method) {
        EXPECT_EQ(member.method(), alone.method()) << name;
      }
      const bool own_epsilon = member.epsilon() == alone.epsilon();
      const auto a = make_simulation(member), c = make_simulation(alone);
      for (std::size_t k = 0; k < a->block_count() && own_epsilon; ++k) {
        const std::string& field = a->fields()[k].name;
        EXPECT_LE((a->get(field) - c->get(field)).norm(), 4e-15 * (1 + c->get(field).norm()))
            << name << " " << field << " of member " << b;
      }
    }
  }
  EXPECT_GT(reached, 4);
}

TEST(ConversionOfMembers, IsThatOfEachBody) { expect_the_members(bodies({1, 0.9, 0.8})); }
TEST(ConversionOfMembers, IsThatOfEachBodyWhateverItsSpeed) {
  expect_the_members(bodies({1, 1e-5, 300}, 1e-4));
}
TEST(ConversionOfMembers, IsThatOfEachGeodesic) { expect_the_members(geodesics()); }

/// Of three bodies as engineers give them, in one set of principal axes or each in its own.
TEST(ConversionOfMembers, TakesBodies) {
  SceneDescription d;
  d.system = "rigid_body";
  d.step = 0.1;
  d.members = 3;
  d.body = BodyDescription{{2, 2, 3, 0.5, 0, 0}, {}, {}, {0.1, 1, 0.2, 1, 0, 0.3, 0, 0.2, 1}};
  const auto common = convert(resolve_recommending(d).value(), {"rigid_body"});
  ASSERT_TRUE(common);
  EXPECT_EQ(common->scene->description().inertia.size(), 3u);
  d.body->inertia_tensor = {2, 2, 3, 0.5, 0, 0, 2, 2, 3, 0.4, 0, 0, 2, 2, 3, 0.3, 0, 0};
  const Scene given = resolve_recommending(d).value();
  const auto own = convert(given, {"rigid_body"});
  ASSERT_TRUE(own);
  EXPECT_EQ(own->scene->description().inertia.size(), 9u);
  for (std::size_t b = 0; b < 3; ++b)
    EXPECT_EQ(own->scene->members()[b].inertia(), given.members()[b].inertia());
}

/// Members with different ‖M‖ choose different ε: a symmetric system starts from Q and M then.
TEST(ConversionOfMembers, KeepsEachEpsilon) {
  const Scene ensemble = Scene::resolve(ensemble_of(bodies({1, 1e-6, 1e3}, 1e-4))).value();
  const auto converted = convert(ensemble, {"symmetric_rigid_body"});
  ASSERT_TRUE(converted);
  const SceneDescription& d = converted->scene->description();
  EXPECT_FALSE(d.epsilon);
  EXPECT_TRUE(d.initial.contains("M") && !d.initial.contains("P"));
  for (std::size_t b = 0; b < 3; ++b)
    EXPECT_EQ(converted->scene->members()[b].epsilon(),
              convert(ensemble.members()[b], {"symmetric_rigid_body"})->scene->epsilon());
  // Asked for, it is that of all.
  const auto asked = convert(ensemble, {"symmetric_rigid_body", 1e-4});
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->scene->description().epsilon, 1e-4);
  EXPECT_TRUE(asked->scene->description().initial.contains("P"));
}

TEST(ConversionOfMembers, NamesTheMemberThatIsRefused) {
  const Scene ensemble = Scene::resolve(ensemble_of(bodies({1, 1, 900}, 1e-4))).value();
  const auto outside = convert(ensemble, {"symmetric_rigid_body", 1e-2});
  ASSERT_FALSE(outside);
  ASSERT_TRUE(std::holds_alternative<OutsideDomain>(outside.error()));
  EXPECT_EQ(std::get<OutsideDomain>(outside.error()).member, 2);
  EXPECT_EQ(std::get<OutsideDomain>(outside.error()).field, "epsilon");
  const auto unreachable = convert(ensemble, {"double_bracket"});
  ASSERT_FALSE(unreachable);
  EXPECT_EQ(std::get<Violations>(unreachable.error()).front().field, "to");
}

}  // namespace
}  // namespace stiefel
