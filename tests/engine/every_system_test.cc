#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/simulation/diagnosis.h"
#include "tests/support/any_scene.h"

namespace stiefel {
namespace {

struct Pair {
  std::string system, method;
  friend void PrintTo(const Pair& pair, std::ostream* out) {
    *out << pair.system << " " << pair.method;
  }
};

std::vector<Pair> every_pair() {
  std::vector<Pair> all;
  for (const auto& system : catalogue().systems)
    for (const auto& method : system.methods)
      all.push_back({std::string(system.name), std::string(method.method)});
  return all;
}

class EverySystem : public ::testing::TestWithParam<Pair> {
 protected:
  Scene scene(unsigned seed, double step) const {
    return resolved(testing::any_scene(GetParam().system, GetParam().method, seed, step));
  }
  static Scene resolved(SceneDescription description) {
    auto made = Scene::resolve(std::move(description));
    std::string why;
    if (!made)
      for (const auto& v : made.error()) why += v.field + ": " + v.value + ": " + v.rule + "; ";
    EXPECT_TRUE(made) << why;
    return std::move(made).value();
  }
};
INSTANTIATE_TEST_SUITE_P(Catalogue, EverySystem, ::testing::ValuesIn(every_pair()),
                         [](const auto& which) {
                           return which.param.system +
                                  (which.param.method.empty() ? "" : "_" + which.param.method);
                         });

std::vector<double> saved(const Simulation& s) {
  std::vector<double> out(s.saved_size());
  s.save(out);
  return out;
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

TEST_P(EverySystem, AResolvedSceneResolvesToItself) {
  const Scene once = scene(4, 0.05), twice = resolved(once.description());
  EXPECT_EQ(saved(*make_simulation(once)), saved(*make_simulation(twice)));
}

/// The worst drift of each family on the way, over seeded scenes.
std::map<std::string, double> drift_after(std::int64_t steps,
                                          const std::function<Scene(unsigned)>& scene) {
  std::map<std::string, double> worst;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Scene here = scene(seed);
    const auto simulation = make_simulation(here);
    for (int part = 0; part < 10; ++part) {
      EXPECT_TRUE(simulation->advance(steps / 10).reached()) << "seed " << seed;
      const Diagnosis diagnosis = diagnose(here, *simulation);
      for (const auto& invariant : diagnosis.invariants) {
        double& w = worst[invariant.name.substr(0, invariant.name.find('['))];
        w = std::max(w, invariant.drift());
      }
      if (diagnosis.orthogonality)
        worst["orthogonality"] = std::max(worst["orthogonality"], *diagnosis.orthogonality);
    }
  }
  return worst;
}

/// What the catalogue declares is what happens, from both sides.
TEST_P(EverySystem, KeepsWhatItDeclares) {
  const auto here = [this](unsigned seed) { return scene(seed, 0.1); };
  auto early = drift_after(100, here), late = drift_after(1000, here);
  const auto& info = *catalogue().system(GetParam().system);
  for (const auto& method : info.methods) {
    if (method.method != GetParam().method) continue;
    for (const auto& [invariant, kept] : method.preserves) {
      const std::string name(invariant);
      ASSERT_TRUE(late.contains(name)) << name;
      const auto where = ::testing::Message()
                         << name << ": " << early[name] << " -> " << late[name];
      // 100 κ u √steps, with the frames' difference over h in the pair's M.
      const double bound = GetParam().system == "moser_veselov_pair" ? 3.5e-12 : 1e-12;
      if (kept == Kept::exact) {
        EXPECT_LE(late[name], bound) << where;
      } else if (kept == Kept::drifts) {
        EXPECT_GE(late[name], 1.5 * early[name]) << where;
        EXPECT_GE(late[name], 1e-12) << where;
      } else {
        EXPECT_LE(late[name], 3 * early[name]) << where;
        EXPECT_GE(late[name], 1e-12) << where;
      }
    }
  }
}

TEST_P(EverySystem, IsReversibleAsDeclared) {
  const auto* method = catalogue().method(GetParam().method);
  if (method == nullptr) return;
  const Scene there = scene(9, 0.1);
  const auto out = make_simulation(there), start = make_simulation(there);
  ASSERT_TRUE(out->advance(100).reached());
  if (out->orthogonality().value_or(0) > 1e-12) return;  // it would be repaired on the way back
  SceneDescription back = there.description();
  back.step = -back.step;
  std::vector<std::string> names;
  for (const auto& [name, block] : back.initial)
    if (block.imaginary.size() > 0) return;
  for (const auto& [name, block] : back.initial) names.push_back(name);
  for (const auto& name : names) back.initial[name] = RowMatrix(out->get(name));
  const auto made = Scene::resolve(back);
  if (!made) {  // it has left the manifold
    EXPECT_FALSE(method->reversible);
    return;
  }
  const auto home = make_simulation(*made);
  ASSERT_TRUE(home->advance(100).reached());
  double error = 0;
  for (const auto& name : names)
    error = std::max(error, (home->get(name) - start->get(name)).norm());
  if (method->reversible)
    EXPECT_LT(error, 1e-11);
  else
    EXPECT_GT(error, 1e-12);
}

}  // namespace
}  // namespace stiefel
