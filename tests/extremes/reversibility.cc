#include <gtest/gtest.h>

#include "engine/accuracy/reference.h"
#include "stiefel/catalogue.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"

namespace stiefel::extremes {
namespace {

bool reversible(const std::string& method) { return catalogue().method(method)->reversible; }

/// Runs forward by `step`, then back by −step in a new scene, which has neither the solver's
/// history nor the carries of compensated sums.
void forth_and_back(const std::string& name, const SceneDescription& scene, const char* momentum,
                    std::int64_t steps) {
  for (const SceneDescription& way : every_way(scene)) {
    if (!reversible(way.method->name)) continue;
    const bool costly = way.method->name == "gauss4" || way.method->name == "implicit_midpoint";
    const std::int64_t count = costly && scene.inertia.size() > 3 ? steps / 100 : steps;
    Trial forth = run(way, count);
    Record r =
        record_of("reversibility", name + ", " + std::to_string(count) + " steps", way, forth);
    r.measure = "distance from the start";
    r.value = 1;
    if (forth.reached()) {
      SceneDescription back = way;
      back.step = -*way.step;
      for (const char* block : {"Q", momentum})
        back.initial[block] = RowMatrix(forth.simulation->get(block));
      const Trial there = run(back, count);
      r.seconds += there.seconds;
      r.outcome = there.outcome();
      if (there.reached())
        r.value = error_of(read_motion(*there.scene, *there.simulation),
                           read_motion(*forth.scene, *make_simulation(*forth.scene)))
                      .largest();
    }
    const bool plain = way.method->arithmetic == "plain";
    r.bound = plain ? 1e-7 : 1e-10;
    r.why = "the map is symmetric; what is left is rounding times the time";
    if (long_form() && !plain && costly && scene.inertia.size() == 3)
      r.limit = "implicit methods add an increment of working precision: 2e-8 after 10^6 steps";
    if (long_form() && !plain && scene.inertia.size() == 4)
      r.limit = "on V(n, N) increments are of working precision: some 1e-9 after 10^6 steps";
    report(r);
  }
}

TEST(Reversibility, ForthAndBack) {
  const std::int64_t steps = long_form() ? 1'000'000 : 2'000;
  forth_and_back("N = 3", top({1, 1.7, 2.4}, {0.8, -0.5, 0.4}, 0.1), "M", steps);
  forth_and_back("N = 5", tumbling(spread_inertia(5, 4), 0.1), "M", steps / 10);
  forth_and_back("V(1,4)", geodesic(1, spread_inertia(4, 4), 0.1), "S", steps);
}

}  // namespace
}  // namespace stiefel::extremes
