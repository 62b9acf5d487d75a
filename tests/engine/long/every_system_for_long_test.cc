#include <gtest/gtest.h>

#include <algorithm>

#include "stiefel/diagnosis.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"

namespace stiefel {
namespace {

using testing::Pair;

bool keeps_exactly(const Pair& pair, std::string_view invariant = "") {
  const auto& methods = catalogue().system(pair.system)->methods;
  const auto on = std::ranges::find(methods, pair.method, &MethodOnSystem::method);
  return std::ranges::any_of(on->preserves, [&](const Preservation& p) {
    return p.conservation == Conservation::exact && (invariant.empty() || p.invariant == invariant);
  });
}

/// The pairs that declare something exact. The parametric systems are left out: their state and its
/// condition grow like (1 + μλ)ᵏ.
std::vector<Pair> exact_pairs() {
  auto pairs = testing::every_pair();
  std::erase_if(pairs, [](const Pair& pair) {
    return pair.system.starts_with("parametric") || !keeps_exactly(pair);
  });
  return pairs;
}

class EverySystemForLong : public ::testing::TestWithParam<Pair> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, EverySystemForLong, ::testing::ValuesIn(exact_pairs()),
                         testing::name_of);

/// Invariants declared exact drift by at most 1e-12 over 10⁵ steps.
TEST_P(EverySystemForLong, KeepsExactlyWhatItDeclares) {
  constexpr std::int64_t steps = 100'000;
  const auto& [system, method, N] = GetParam();
  for (unsigned seed = 1; seed <= 2; ++seed) {
    auto description = testing::any_scene(system, method, seed, 0.1, N);
    if (testing::has_own_steps(method)) *description.step /= 10;
    const Scene scene = Scene::resolve(description).value();
    const auto simulation = make_simulation(scene);
    ASSERT_TRUE(simulation->advance(steps).reached());
    const Diagnosis diagnosis = diagnose(scene, *simulation);
    for (const auto& invariant : diagnosis.invariants) {
      if (invariant.conservation != Conservation::exact) continue;
      EXPECT_LE(invariant.drift(), 1e-12) << invariant.name;
    }
    if (keeps_exactly(GetParam(), "orthogonality")) {
      EXPECT_LE(diagnosis.orthogonality.value(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace stiefel
