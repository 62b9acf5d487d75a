#include "tests/support/surveys/choice_survey.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "engine/accuracy/measurement.h"
#include "stiefel/price.h"
#include "stiefel/tradeoff.h"
#include "tests/support/exact_motion.h"
#include "tests/support/motion_in_quadruple.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::testing {
namespace {

SceneDescription random_description(unsigned seed) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * std::generate_canonical<double, 53>(generator);
  };
  SceneDescription d;
  const double step = 0.05 * std::pow(20, uniform(0, 1));  // h‖Ω‖ = 0.05 … 1
  if (uniform(0, 1) < 0.75) {
    d = description(RandomBody(static_cast<int>(uniform(3, 7)), seed), step, "rk4");
  } else {
    const int n = static_cast<int>(uniform(1, 4));
    const RandomFrame<double> frame(n, n + 1 + static_cast<int>(uniform(0, 4)), seed);
    d.system = "stiefel";
    d.inertia = {frame.lambda.begin(), frame.lambda.end()};
    d.initial["Q"] = frame.Q;
    d.initial["S"] = frame.S;
    d.step = step;
  }
  d.method.reset();
  d.tolerance = std::pow(10, uniform(-10, -3));
  d.horizon = step * std::round(uniform(10, 200));
  return d;
}

/// Returns the exact state: for a body by Boost.odeint; on V(n, N) in quadruple precision.
MotionState exact(const Scene& scene, double t) {
  if (scene.system() != "rigid_body") return motion_in_quadruple(scene)(t);
  const Motion motion = exact_motion(scene.inertia(), scene.Q(), scene.M(), t);
  return {motion.Q.cast<long double>(), motion.M.cast<long double>()};
}

/// Returns the least work of an entry of the trade-off whose measured error is within the
/// tolerance.
double best_of_table(const SceneDescription& description) {
  SceneDescription scene = description;
  scene.tolerance.reset();
  auto tradeoff = Tradeoff::prepare({scene, {}, 3e10, 1}).value();
  if (!tradeoff->solve_reference({})) return 0;
  double best = 0;
  while (const auto point = tradeoff->next({}))
    if (point->error && point->error->largest() <= *description.tolerance &&
        (best == 0 || point->work < best))
      best = point->work;
  return best;
}

}  // namespace

ChoiceOutcome survey_choice(unsigned seed) {
  const SceneDescription d = random_description(seed);
  std::ostringstream what;
  what << "seed " << seed << ": " << d.system << " N=" << d.inertia.size() << " step " << *d.step
       << " horizon " << *d.horizon << " tolerance " << *d.tolerance;
  ChoiceOutcome out{what.str(), {}};
  const auto found = resolve_choosing(d);
  if (!found) {
    out.chosen = found.error().front().rule;
    return out;
  }
  const Scene& scene = found->scene;
  out.made = true;
  out.chosen = found->choice->reason;
  const auto now = make_simulation(scene);
  const std::int64_t steps = steps_to(*d.horizon, *d.step);
  if (!now->advance(steps).reached()) return out;
  out.error =
      error_of(read_motion(scene, *now), exact(scene, scene.time(steps))).largest() / *d.tolerance;
  const double best = best_of_table(d);
  const auto fresh = make_simulation(scene);
  if (best > 0 && fresh->advance(steps).reached())
    out.cost = step_weight(scene) * static_cast<double>(fresh->map_steps()) / best;
  return out;
}

}  // namespace stiefel::testing
