// A run that reaches a step has a state of finite numbers there, however far the steps drive it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engine/motion/method_entry.h"
#include "stiefel/simulation.h"
#include "tests/support/saved.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/every_pair.h"

namespace stiefel {
namespace {

using testing::Pair;
using testing::saved;

constexpr std::int64_t most_steps = 100;

/// Returns the name of a field with a number that is not finite; empty if there is none.
std::string not_finite(const Simulation& now) {
  for (std::size_t i = 0; i < now.fields().size(); ++i) {
    std::vector<double> numbers(static_cast<std::size_t>(now.fields()[i].size()));
    now.write(i, numbers);
    if (!std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }))
      return now.fields()[i].name;
  }
  return "";
}

/// The ways to compute a pair: its arithmetics and scalars.
std::vector<MethodDescription> ways(const Pair& pair) {
  if (pair.method.empty()) return {{}};
  std::vector<MethodDescription> all;
  for (const auto& on : catalogue().system(pair.system)->methods)
    for (const char* scalar : {"double", "float"})
      for (const char* arithmetic : {"compensated", "plain"})
        if (on.method == pair.method && (on.in_float || scalar == std::string("double")))
          all.push_back({pair.method, {}, {}, arithmetic, {}, scalar});
  return all;
}

/// Steps singly to the end of the run, looking at every state, and compares with one long advance:
/// both end at the same step, with the same bits and the same outcome.
Outcome end_of(const Scene& scene) {
  const auto singly = make_simulation(scene), at_once = make_simulation(scene);
  RunStatus status;
  while (singly->step() < most_steps) {
    const std::int64_t before = singly->step();
    const std::vector<double> state = saved(*singly);
    status = singly->advance(1);
    EXPECT_EQ(not_finite(*singly), "") << "step " << singly->step();
    if (status.reached()) continue;
    EXPECT_EQ(singly->step(), before);
    EXPECT_EQ(saved(*singly), state) << "step " << before;
    break;
  }
  EXPECT_EQ(at_once->advance(most_steps).outcome, status.outcome);
  EXPECT_EQ(at_once->step(), singly->step());
  EXPECT_EQ(saved(*at_once), saved(*singly));
  return status.outcome;
}

class FiniteStates : public ::testing::TestWithParam<Pair> {
 protected:
  /// Steps h‖Ω‖. Longer ones have no frames in a discrete system, and take minutes where a step
  /// iterates or chooses substeps.
  static std::vector<double> turns() {
    const MethodEntry* method = method_entry(GetParam().method);
    if (method == nullptr) return {0.05, 0.2};
    if (method->traits.iterates || method->traits.default_tolerance > 0) return {0.5, 2};
    return {2, 10, 1e3};
  }
  SceneDescription description(unsigned seed, double step, bool in_float = false) const {
    return testing::any_scene(GetParam().system, GetParam().method, seed, step,
                              in_float ? 3 : GetParam().N);
  }
};
INSTANTIATE_TEST_SUITE_P(Catalogue, FiniteStates, ::testing::ValuesIn(testing::every_pair()),
                         testing::name_of);

TEST_P(FiniteStates, AreAllThatIsReached) {
  std::map<Outcome, int> ends;
  for (const MethodDescription& way : ways(GetParam()))
    for (const double step : turns())
      for (const unsigned seed : {1, 2}) {
        SceneDescription d = description(seed, step, way.scalar == "float");
        if (d.method) d.method = way;
        SCOPED_TRACE(way.arithmetic + " " + way.scalar + ", step " + std::to_string(step));
        ++ends[end_of(Scene::resolve(d).value())];
      }
  if (GetParam().method == "rk4") {
    EXPECT_GT(ends[Outcome::not_finite], 0);
  }
}

TEST_P(FiniteStates, AreAllThatAnEnsembleReaches) {
  std::vector<SceneDescription> scenes;
  std::int64_t least = most_steps;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const double turn = turns()[1];
    SceneDescription one = Scene::resolve(description(seed, turn)).value().description();
    one.epsilon.reset();  // each member chooses its own
    one.step = description(1, turn).step;
    const auto alone = make_simulation(Scene::resolve(one).value());
    alone->advance(most_steps);
    least = std::min(least, alone->step());
    scenes.push_back(one);
  }
  const auto ensemble = make_simulation(Scene::resolve(testing::ensemble_of(scenes)).value());
  while (ensemble->step() < most_steps && ensemble->advance(1).reached())
    EXPECT_EQ(not_finite(*ensemble), "") << "step " << ensemble->step();
  EXPECT_EQ(ensemble->step(), least);
  EXPECT_EQ(not_finite(*ensemble), "");
}

/// A sphere turns steadily, and rk4 multiplies its quaternion by R(iy), y = hω/2, in each step,
/// R(z) = 1 + z + z²/2 + z³/6 + z⁴/24. With y = 4 |q|² grows 521/9-fold, and no entry of Q may
/// exceed it.
TEST(FiniteState, EndsWhereTheSquareOfTheQuaternionDoes) {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"rk4", {}, {}, ""};
  d.body = BodyDescription{{}, {1, 1, 1}, {}, {0, 0.6, 0.8}};
  d.step = 8;
  const Scene scene = Scene::resolve(d).value();
  const auto last =
      static_cast<std::int64_t>(std::log(std::numeric_limits<double>::max()) / std::log(521.0 / 9));
  const auto wild = make_simulation(scene), good = make_simulation(scene);
  for (int time = 0; time < 3; ++time) {
    EXPECT_EQ(wild->advance(1000).outcome, Outcome::not_finite);
    EXPECT_EQ(wild->step(), last);
  }
  ASSERT_TRUE(good->advance(last).reached());
  EXPECT_EQ(saved(*wild), saved(*good));
  EXPECT_EQ(not_finite(*wild), "");
  EXPECT_GT(wild->get("Q").norm(), 1e300);
}

}  // namespace
}  // namespace stiefel
