#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <sstream>

#include "engine/accuracy/reference.h"
#include "stiefel/diagnosis.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/growth.h"
#include "tests/extremes/twin/twin.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::extremes {
namespace {

/// A long run: its scenes, its steps, and which of its runs are compared with quadruple precision.
struct LongRun {
  std::string row;
  std::function<SceneDescription(unsigned seed)> scene;
  std::int64_t steps;
  unsigned seeds;
  std::int64_t phase_steps;
  unsigned phase_seeds;
};

SceneDescription body(int N, unsigned seed) {
  return testing::description(testing::RandomBody(N, seed), 0.1, "variational");
}

std::vector<LongRun> runs() {
  const auto three = [](unsigned seed) { return body(3, seed); };
  const auto eight = [](unsigned seed) { return body(8, seed); };
  const auto frames = [](unsigned seed) {
    return testing::any_scene("stiefel", "variational", seed, 0.1);
  };
  if (!long_form())
    return {{"N = 3", three, 100'000, 8, 3'000, 4}, {"N = 8", eight, 3'000, 4, 0, 0}};
  return {{"N = 3", three, 10'000'000, 32, 300'000, 12},
          {"N = 3, the longest", three, 100'000'000, 4, 0, 0},
          {"N = 8", eight, 1'000'000, 4, 20'000, 4},
          {"N = 8, many", eight, 100'000, 32, 0, 0},
          {"V(2,5)", frames, 100'000, 32, 0, 0}};
}

/// Measures energy, momentum and orthogonality at each third of a decade, as RMS over the scenes.
void run_for_long(const LongRun& what, const std::string& arithmetic) {
  Growth energy, momentum, orthogonality, phase;
  Record r;
  double seconds = 0;
  for (unsigned seed = 1; seed <= what.seeds; ++seed) {
    SceneDescription d = what.scene(seed);
    d.method->arithmetic = arithmetic;
    Trial done = run(d, 0);
    r = record_of("long_runs", what.row, d, done);
    for (const std::int64_t step : thirds_of_decades(what.steps)) {
      const double start = static_cast<double>(std::clock());
      ASSERT_TRUE(done.simulation->advance(step - done.simulation->step()).reached());
      seconds += (static_cast<double>(std::clock()) - start) / CLOCKS_PER_SEC;
      const std::vector<std::string> two = {"energy", "spatial_momentum"};
      double largest = 0;
      for (const auto& invariant : diagnose(*done.scene, *done.simulation, two).invariants)
        if (invariant.name == "energy")
          energy.add(step, invariant.drift());
        else
          largest = std::max(largest, invariant.drift());
      momentum.add(step, largest);
      orthogonality.add(step, *done.simulation->orthogonality());
    }
  }
  for (unsigned seed = 1; seed <= what.phase_seeds; ++seed) {
    SceneDescription d = what.scene(seed);
    d.method->arithmetic = arithmetic;
    Trial done = run(d, 0);
    const auto twin = make_twin(*done.scene);
    for (const std::int64_t step : thirds_of_decades(what.phase_steps)) {
      const std::int64_t more = step - done.simulation->step();
      done.simulation->advance(more);
      twin->advance(more);
      phase.add(step,
                error_of(read_motion(*done.scene, *done.simulation), twin->state()).largest());
    }
  }
  const bool plain = arithmetic == "plain", frames = r.system == "stiefel";
  r.seconds = seconds;
  const auto say = [&](const auto&... found) { report(r.with(found...)); };
  std::ostringstream scenes;
  scenes << ", RMS of " << what.seeds << " scenes";
  const auto curve = [&](const std::string& name, const Growth& growth, double kappa) {
    for (const auto& [step, value] : growth.rms())
      say(name + " at " + std::to_string(step), value,
          100 * kappa * unit *
              (plain ? static_cast<double>(step) : std::sqrt(static_cast<double>(step))),
          (plain ? "100 κ u steps" : "100 κ u √steps") + scenes.str());
  };
  if (frames) {
    // The energy oscillates by (h‖Q̇‖)², and must not grow.
    say("exponent of energy", energy.exponent(), 0.6, "no growth: oscillation only" + scenes.str());
  } else {
    curve("energy", energy, 1);
    if (!plain)
      say("exponent of energy", energy.exponent(), 0.6, "a random walk's ½, over three decades");
  }
  curve("momentum", momentum, 1);
  curve("orthogonality", orthogonality, 1);
  if (what.phase_seeds == 0) return;
  for (const auto& [step, value] : phase.rms())
    say("phase at " + std::to_string(step), value,
        100 * unit * std::pow(static_cast<double>(step), plain ? 2 : 1.5),
        "100 u steps^1.5, plain steps²: what a drifting energy does to the angle; against the same "
        "map in quadruple precision");
  if (!plain) say("exponent of phase", phase.exponent(), 1.6, "the integral of a random walk, 3/2");
}

TEST(LongRuns, Growth) {
  for (const LongRun& what : runs())
    for (const char* arithmetic : {"compensated", "plain"}) run_for_long(what, arithmetic);
}

}  // namespace
}  // namespace stiefel::extremes
