#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "stiefel/diagnosis.h"
#include "tests/support/sanitizer.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

constexpr std::size_t decades = 4;

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

constexpr int scene_count = testing::sanitized ? 4 : 16;

/// A dimension, and the number of steps of the first decade, from which three others follow.
struct Length {
  int N;
  std::int64_t first;
};

/// Of the largest drifts up to each decade of steps, over seeded scenes with h‖Ω‖ = 0.1 and Λ over
/// 1 : 4.
struct Drifts {
  std::array<Worst, 4> worst;       ///< of all scenes
  std::array<double, 4> mean = {};  ///< over the scenes
};

Drifts drifts(const Length& length, const char* arithmetic) {
  Drifts all;
  for (unsigned seed = 1; seed <= scene_count; ++seed) {
    const Scene scene = testing::random_scene(length.N, seed, 0.1, "variational", arithmetic);
    const auto simulation = make_simulation(scene);
    Worst own;
    std::int64_t to = length.first;
    for (std::size_t k = 0; k < decades; ++k, to *= 10) {
      EXPECT_TRUE(simulation->advance(to - simulation->step()).reached());
      const Diagnosis diagnosis = diagnose(scene, *simulation);
      own.include(diagnosis);
      all.worst[k].include(diagnosis);
      all.mean[k] += own.largest() / scene_count;
    }
  }
  return all;
}

class LongRun : public ::testing::TestWithParam<Length> {};

/// 10⁶ steps of bodies in three dimensions, 10⁵ in eight. The bound of compensated arithmetic is
/// absolute, and its drift grows no faster than a random walk, by 10^½ a decade. Plain arithmetic
/// must drift at least ten times as much, else compensation has no effect.
TEST_P(LongRun, CompensatedDriftStaysAtRounding) {
  const auto compensated = drifts(GetParam(), "compensated");
  const auto plain = drifts(GetParam(), "plain");
  for (const auto& at : compensated.worst) {
    EXPECT_LE(at.largest(), 1e-12);
    EXPECT_LE(at.orthogonality, 1e-13);
  }
  for (std::size_t k = 1; k < decades; ++k)
    EXPECT_LE(compensated.mean[k], std::sqrt(10) * compensated.mean[k - 1]) << k;
  EXPECT_GE(plain.mean.back(), 10 * compensated.mean.back());
}
// The sanitizers check the code of a step; they do not need so many.
INSTANTIATE_TEST_SUITE_P(Dimensions, LongRun,
                         ::testing::Values(Length{3, testing::sanitized ? 100 : 1000},
                                           Length{8, testing::sanitized ? 10 : 100}));

}  // namespace
}  // namespace stiefel
