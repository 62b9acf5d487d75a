#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "stiefel/conversion.h"
#include "stiefel/diagnosis.h"
#include "tests/support/saved.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/every_pair.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel {
namespace {

using testing::Pair;
using testing::resolved;
using testing::saved;

class EverySystem : public ::testing::TestWithParam<Pair> {
 protected:
  Scene scene(unsigned seed, double step) const {
    return resolved(
        testing::any_scene(GetParam().system, GetParam().method, seed, step, GetParam().N));
  }
};
INSTANTIATE_TEST_SUITE_P(Catalogue, EverySystem, ::testing::ValuesIn(testing::every_pair()),
                         testing::name_of);

std::vector<Pair> with_methods() {
  auto pairs = testing::every_pair();
  std::erase_if(pairs, [](const Pair& pair) { return pair.method.empty(); });
  return pairs;
}

TEST_P(EverySystem, TheStateAtAStepHasOneSetOfBits) {
  const Scene here = scene(3, 0.05);
  const auto once = make_simulation(here), many = make_simulation(here),
             resumed = make_simulation(here);
  ASSERT_TRUE(once->advance(60).reached());
  for (int k = 0; k < 60; ++k) {
    ASSERT_TRUE(many->advance(1).reached());
    if (many->step() == 17) resumed->restore(17, saved(*many));
  }
  ASSERT_TRUE(resumed->advance(43).reached());
  EXPECT_EQ(saved(*once), saved(*many));
  EXPECT_EQ(saved(*once), saved(*resumed));
}

TEST_P(EverySystem, AMemberOfAnEnsembleHasTheBitsThatItHasAlone) {
  std::vector<SceneDescription> scenes;
  for (const unsigned seed : {3, 4, 5, 6, 7}) {
    SceneDescription one = scene(seed, 0.05).description();
    one.epsilon.reset();  // each member chooses its own
    scenes.push_back(one);
  }
  const Scene together = resolved(testing::ensemble_of(scenes));
  EXPECT_EQ(resolved(together.description()).description().members, 5);
  const auto ensemble = make_simulation(together);
  ASSERT_TRUE(ensemble->advance(13).reached());
  ASSERT_TRUE(ensemble->advance(1).reached());
  std::vector<double> alone;
  for (const SceneDescription& one : scenes) {
    const auto simulation = make_simulation(resolved(one));
    ASSERT_TRUE(simulation->advance(14).reached());
    const auto state = saved(*simulation);
    alone.insert(alone.end(), state.begin(), state.end());
  }
  EXPECT_EQ(saved(*ensemble), alone);
}

TEST_P(EverySystem, AResolvedSceneResolvesToItself) {
  const Scene once = scene(4, 0.05), twice = resolved(once.description());
  EXPECT_EQ(saved(*make_simulation(once)), saved(*make_simulation(twice)));
}

/// How far a family of invariants moves on the way, over seeded scenes: on the mean up to a quarter
/// of the steps and up to the last, and at worst.
struct Drift {
  double early = 0, late = 0, worst = 0;
};

std::map<std::string, double> drifts_at(const Scene& scene, const Simulation& simulation) {
  std::map<std::string, double> drifts;
  const Diagnosis diagnosis = diagnose(scene, simulation);
  for (const auto& invariant : diagnosis.invariants) {
    double& d = drifts[invariant.name.substr(0, invariant.name.find('['))];
    d = std::max(d, invariant.drift());
  }
  if (diagnosis.orthogonality) drifts["orthogonality"] = *diagnosis.orthogonality;
  return drifts;
}

std::map<std::string, Drift> drifts_over(std::int64_t steps, int scenes,
                                         const std::function<Scene(unsigned)>& scene) {
  constexpr int looks = 40;
  std::map<std::string, Drift> all;
  for (int seed = 1; seed <= scenes; ++seed) {
    const Scene here = scene(static_cast<unsigned>(seed));
    const auto simulation = make_simulation(here);
    std::map<std::string, double> largest;
    for (int look = 1; look <= looks; ++look) {
      EXPECT_TRUE(simulation->advance(steps / looks).reached()) << "seed " << seed;
      for (const auto& [name, drift] : drifts_at(here, *simulation)) {
        double& l = largest[name];
        l = std::max(l, drift);
        if (look == looks / 4) all[name].early += l / scenes;
      }
    }
    for (const auto& [name, l] : largest) {
      all[name].late += l / scenes;
      all[name].worst = std::max(all[name].worst, l);
    }
  }
  return all;
}

/// Every invariant behaves as the catalogue declares, neither worse nor better: an exact one drifts
/// by rounding alone; a bounded one by more, but no more up to step 1000 than up to 250; of one
/// that drifts, the drift grows.
TEST_P(EverySystem, KeepsWhatItDeclares) {
  const auto [system, method, N] = GetParam();
  const double h = testing::step_of(system, method);
  auto drifts = drifts_over(1000, 32, [&](unsigned seed) { return scene(seed, h); });
  for (const auto& on : catalogue().system(system)->methods) {
    if (on.method != method) continue;
    for (const auto& [invariant, conservation] : on.preserves) {
      const std::string name(invariant);
      ASSERT_TRUE(drifts.contains(name)) << name;
      const auto [early, late, worst] = drifts[name];
      const auto where = ::testing::Message()
                         << name << " is declared " << to_string(conservation)
                         << "; mean of the largest drifts up to step 250: " << early
                         << ", up to step 1000: " << late
                         << "; largest drift of all scenes: " << worst;
      if (conservation == Conservation::exact) {
        EXPECT_LE(worst, 1e-12) << where;
      } else if (conservation == Conservation::drifts) {
        EXPECT_GE(late, 1.5 * early) << where;
        EXPECT_GE(late, 1e-11) << where;
      } else {
        EXPECT_LE(late, 1.5 * early) << where;
        EXPECT_GE(late, 1e-11) << where;
      }
    }
  }
}

/// A step by −h undoes a step by h, where that is declared. A discrete system has no step to turn.
class Reversibility : public EverySystem {};
INSTANTIATE_TEST_SUITE_P(Catalogue, Reversibility, ::testing::ValuesIn(with_methods()),
                         testing::name_of);

TEST_P(Reversibility, IsAsDeclared) {
  const bool reversible = catalogue().method(GetParam().method)->reversible;
  const Scene there = scene(9, 0.1);
  const auto out = make_simulation(there), start = make_simulation(there);
  ASSERT_TRUE(out->advance(100).reached());
  if (const double off = out->orthogonality().value_or(0); off > 1e-12) {
    EXPECT_FALSE(reversible);
    GTEST_SKIP() << "off the manifold by " << off << ": the way back would begin at another state";
  }
  const auto turned = scene_at(there, *out);
  if (!turned) {
    EXPECT_FALSE(reversible) << turned.error().front().field << ": " << turned.error().front().rule;
    GTEST_SKIP() << "off the manifold: " << turned.error().front().rule;
  }
  SceneDescription back = turned->description();
  back.step = -*back.step;
  const auto home = make_simulation(resolved(back));
  ASSERT_TRUE(home->advance(100).reached());
  double error = 0;
  for (const auto& [name, block] : there.description().initial)
    error = std::max(error, (home->get(name) - start->get(name)).norm());
  if (reversible)
    EXPECT_LT(error, 1e-11);
  else
    EXPECT_GT(error, 1e-12);
}

}  // namespace
}  // namespace stiefel
