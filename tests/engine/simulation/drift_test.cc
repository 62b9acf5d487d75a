#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "stiefel/diagnosis.h"
#include "tests/support/sanitizer.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

// The sanitizers check the code of a step; they do not need 10⁶ steps.
constexpr std::int64_t first_decade = testing::sanitized ? 100 : 1000;
constexpr std::array decades = {first_decade, 10 * first_decade, 100 * first_decade,
                                1000 * first_decade};

struct Worst {
  double energy = 0, momentum = 0, manakov = 0, orthogonality = 0;
  void include(const Diagnosis& diagnosis) {
    for (const auto& invariant : diagnosis.invariants) {
      double& w = invariant.name == "energy"              ? energy
                  : invariant.name.starts_with("spatial") ? momentum
                  : invariant.name.starts_with("manakov") ? manakov
                                                          : momentum;
      w = std::max(w, invariant.drift());
    }
    orthogonality = std::max(orthogonality, *diagnosis.orthogonality);
  }
  double largest() const { return std::max({energy, momentum, manakov}); }
};

/// Drift at each decade of steps, the worst of three seeds for N = 3, of one above: h‖Ω‖ = 0.1, Λ
/// over 1 : 4.
std::array<Worst, 4> drifts(int N, const char* arithmetic) {
  std::array<Worst, 4> worst;
  const unsigned seeds = N == 3 ? 3 : 1;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const Scene scene = testing::random_scene(N, seed, 0.1, "variational", arithmetic);
    const auto simulation = make_simulation(scene);
    for (std::size_t k = 0; k < decades.size(); ++k) {
      EXPECT_TRUE(simulation->advance(decades[k] - simulation->step()).reached());
      worst[k].include(diagnose(scene, *simulation));
    }
  }
  for (std::size_t k = 0; k < decades.size(); ++k)
    std::printf(
        "N = %d %-11s %8lld steps: energy %.1e  momentum %.1e  Manakov %.1e  |QtQ - I| %.1e\n", N,
        arithmetic, static_cast<long long>(decades[k]), worst[k].energy, worst[k].momentum,
        worst[k].manakov, worst[k].orthogonality);
  return worst;
}

class LongRun : public ::testing::TestWithParam<int> {};

/// 10⁶ steps. The bound of compensated arithmetic is absolute. Plain arithmetic must drift at least
/// ten times as much, else compensation has no effect.
TEST_P(LongRun, CompensatedDriftStaysAtRounding) {
  const auto compensated = drifts(GetParam(), "compensated");
  const auto plain = drifts(GetParam(), "plain");
  for (const auto& at : compensated) {
    EXPECT_LE(at.largest(), 1e-12);
    EXPECT_LE(at.orthogonality, 1e-13);
  }
  EXPECT_GE(plain.back().largest(), 10 * compensated.back().largest());
}
INSTANTIATE_TEST_SUITE_P(Dimensions, LongRun, ::testing::Values(3, 8));

}  // namespace
}  // namespace stiefel
