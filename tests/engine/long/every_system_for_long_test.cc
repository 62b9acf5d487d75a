#include <gtest/gtest.h>

#include <algorithm>

#include "stiefel/diagnosis.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"

namespace stiefel {
namespace {

class EverySystemForLong : public ::testing::TestWithParam<testing::Pair> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, EverySystemForLong, ::testing::ValuesIn(testing::every_pair()),
                         testing::name_of);

/// Invariants declared exact drift by at most 1e-12 over 10⁵ steps. The parametric systems are left
/// out: their state and its condition grow like (1 + μλ)ᵏ.
TEST_P(EverySystemForLong, KeepsExactlyWhatItDeclares) {
  constexpr std::int64_t steps = 100'000;
  const auto& [system, method, N] = GetParam();
  const auto& methods = catalogue().system(system)->methods;
  const auto on = std::ranges::find(methods, method, &MethodOnSystem::method);
  const auto exact = [&](std::string_view invariant) {
    const auto found = std::ranges::find(on->preserves, invariant, &Preservation::invariant);
    return found != on->preserves.end() && found->conservation == Conservation::exact;
  };
  if (std::ranges::none_of(on->preserves, exact, &Preservation::invariant)) return;
  if (system.starts_with("parametric")) return;
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
    if (exact("orthogonality")) {
      EXPECT_LE(diagnosis.orthogonality.value(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace stiefel
