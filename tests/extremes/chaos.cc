#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "engine/accuracy/reference.h"
#include "stiefel/diagnosis.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {
namespace {

/// The steps at which a distance exceeds `low` and `high`, and its growth rate per step in between.
struct Divergence {
  double low = 1e-11, high = 1e-2;
  std::int64_t from = 0, to = 0;
  void see(std::int64_t step, double distance) {
    if (from == 0 && distance > low) from = step;
    if (to == 0 && distance > high) to = step;
  }
  double rate() const { return std::log(high / low) / static_cast<double>(to - from); }
};

/// Motions on V(2,5) with Λ over 1 : 16 are chaotic: results in double and quadruple precision
/// diverge at the same rate as two motions in quadruple precision that start 1e-14 apart.
/// Afterwards the state has no correct digit, but the map still keeps its invariants. (energy.cc
/// tests the energy, which the map does not keep.)
TEST(Chaos, TwoPrecisionsPart) {
  constexpr std::int64_t every = 20, most = 40'000;
  for (const unsigned seed : {1u, 2u, 3u}) {
    if (!long_form() && seed > 1) continue;
    SceneDescription d = geodesic(2, spread_inertia(5, 16), 0.1, seed);
    d.method = MethodDescription{"variational", {}, {}, "compensated"};
    Trial done = run(d, 0);
    const auto twin = make_twin(*done.scene), other = make_twin(*done.scene, 0x1p-46);
    Divergence of_precision, of_motions;
    std::int64_t step = 0;
    for (; step < most && (of_precision.to == 0 || of_motions.to == 0); step += every) {
      ASSERT_TRUE(done.simulation->advance(every).reached());
      twin->advance(every);
      other->advance(every);
      const MotionState exact = twin->state();
      of_motions.see(step, error_of(other->state(), exact).largest());
      of_precision.see(step, error_of(read_motion(*done.scene, *done.simulation), exact).largest());
    }
    Record r = record_of("chaos", "V(2,5), Λ over 1 : 16, seed " + std::to_string(seed), d, done);
    const auto say = [&](const auto&... what) { report(r.with(what...)); };
    std::ostringstream when;
    when.precision(3);
    when << "error e^{" << of_motions.rate() / 0.1 << " t} u; two precisions are 1e-2 apart from "
         << "here on: the state means nothing any more";
    say("steps until the state means nothing",
        static_cast<double>(of_precision.to == 0 ? most : of_precision.to),
        static_cast<double>(most), when.str());
    ASSERT_GT(of_motions.to, of_motions.from);
    ASSERT_GT(of_precision.to, of_precision.from);
    say("rate of two precisions over that of two motions",
        std::abs(std::log2(of_precision.rate() / of_motions.rate())), 1,
        "|log₂| ≤ 1: local rates vary along a motion");
    const std::int64_t beyond = long_form() ? 100'000 : 20'000;
    ASSERT_TRUE(done.simulation->advance(beyond - step > 0 ? beyond - step : 0).reached());
    const Diagnosis diagnosis = diagnose(*done.scene, *done.simulation);
    for (const auto& invariant : diagnosis.invariants)
      if (invariant.conservation == Conservation::exact)
        say(invariant.name + " long after", invariant.drift(),
            rounding_bound(*done.scene, done.simulation->step(), 1), "100 u √steps");
    say("orthogonality long after", *diagnosis.orthogonality,
        rounding_bound(*done.scene, done.simulation->step(), 1), "100 u √steps");
  }
}

}  // namespace
}  // namespace stiefel::extremes
