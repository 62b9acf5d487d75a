#include <algorithm>
#include <cmath>
#include <map>

#include "engine/accuracy/reference.h"
#include "stiefel/catalogue.h"
#include "stiefel/diagnosis.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {
namespace {

/// The reference for one map: the map's state without rounding, its condition, and the distance of
/// that state from the exact motion.
struct Unrounded {
  std::optional<MotionState> state;
  double condition = 1, truncation = 0;
};

Unrounded unrounded(const Scene& scene, std::int64_t steps,
                    const std::optional<Reference::Answer>& motion) {
  Unrounded made;
  const auto twin = make_twin(scene);
  if (!twin || !twin->advance(steps).reached()) return made;
  made.state = twin->state();
  made.condition = condition(scene, steps);
  if (motion) made.truncation = error_of(*made.state, motion->state).largest();
  return made;
}

std::optional<Reference::Answer> exact_motion(const Scene& scene, std::int64_t steps) {
  constexpr double budget = 2e10;  // instructions
  const double time = scene.time(steps);
  return make_reference(scene, {std::abs(time), budget})->at(time, {});
}

bool keeps_orthogonality(const Scene& scene) {
  for (const auto& on : catalogue().system(scene.system())->methods)
    if (on.method == scene.method())
      for (const auto& p : on.preserves)
        if (p.invariant == "orthogonality") return p.conservation == Conservation::exact;
  return false;
}

/// Returns the largest drift of the invariants that the method declares exact.
double largest_drift(const Diagnosis& diagnosis) {
  double drift = 0;
  for (const auto& invariant : diagnosis.invariants)
    if (invariant.conservation == Conservation::exact) drift = std::max(drift, invariant.drift());
  return drift;
}

}  // namespace

void measure(const Row& row) {
  std::map<std::string, Unrounded> twins;
  std::optional<std::optional<Reference::Answer>> motion;
  double flow_condition = 1;
  for (const SceneDescription& way : every_way(row.scene)) {
    const Trial done = run(way, row.steps);
    Record r = record_of(row.extreme, row.name, way, done);
    const auto limit = row.limit(way);
    Record worst = r;  // for a way with a known limit, of which only the worst record is reported
    worst.bound = 1;
    const auto say = [&](const auto&... what) {
      const Record said = r.with(what...);
      if (!limit)
        report(said);
      else if (!(said.value / said.bound <= worst.value / worst.bound))
        worst = said;
    };
    const auto last = [&] {
      if (!limit) return;
      worst.limit = limit;
      report(worst);
    };
    if (!done.reached()) {
      say("outcome", 1, 0, "must be REACHED: " + done.sentence());
      last();
      continue;
    }
    const Scene& scene = *done.scene;
    if (!motion) motion = exact_motion(scene, row.steps);
    const std::string key = r.method + std::to_string(r.order);
    if (!twins.contains(key)) twins.emplace(key, unrounded(scene, row.steps, *motion));
    const Unrounded& ideal = twins.at(key);
    flow_condition = std::max(flow_condition, ideal.condition);
    const double kappa = ideal.state ? ideal.condition : flow_condition;
    const double bound = row.scene_rounding * rounding_bound(scene, row.steps, kappa);
    const MotionState state = read_motion(scene, *done.simulation);
    if (ideal.state) {
      say("rounding", error_of(state, *ideal.state).largest(), bound,
          rounding_reason(scene, kappa) + "; against the same map in quadruple precision");
      if (*motion)
        say("truncation", ideal.truncation, no_bound,
            "no bound; the same map in quadruple precision against the exact motion");
    } else if (*motion && !r.method.empty()) {
      const double attempts = scene.method() == "adaptive" ? static_cast<double>(row.steps) : 0;
      say("error", error_of(state, (*motion)->state).largest(),
          10 * attempts * scene.tolerance() * kappa + bound + 10 * (*motion)->error,
          "10 κ steps tolerance, and rounding; against the exact motion");
    }
    const Diagnosis diagnosis = diagnose(scene, *done.simulation);
    say("drift", largest_drift(diagnosis),
        row.scene_rounding * rounding_bound(scene, row.steps, row.kappa),
        rounding_reason(scene, row.kappa) + "; of what the method declares exact");
    if (diagnosis.orthogonality && keeps_orthogonality(scene))
      say("orthogonality", *diagnosis.orthogonality, rounding_bound(scene, row.steps, 1),
          rounding_reason(scene, 1) + "; max |QQᵀ - I|");
    last();
  }
}

}  // namespace stiefel::extremes
