#include <algorithm>
#include <cmath>
#include <map>

#include "engine/simulation/diagnosis.h"
#include "engine/simulation/reference.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/twin.h"

namespace stiefel::extremes {
namespace {

/// Of one map: where it goes without rounding, and its condition.
struct Unrounded {
  std::unique_ptr<Twin> twin;
  double condition = 1;
};

Unrounded unrounded(const Scene& scene, std::int64_t steps) {
  Unrounded made{make_twin(scene)};
  if (!made.twin) return made;
  made.twin->advance(steps);
  made.condition = condition(scene, steps);
  return made;
}

/// The exact motion.
std::optional<Reference::Answer> exact(const Scene& scene, std::int64_t steps) {
  constexpr double budget = 1e11;  // instructions
  const double time = scene.time(steps);
  return make_reference(scene, {std::abs(time), budget})->at(time, {});
}

bool is_exact(const Diagnosis& diagnosis, std::string_view family) {
  for (const auto& invariant : diagnosis.invariants)
    if (invariant.name.starts_with(family) && invariant.kept != Kept::exact) return false;
  return true;
}

}  // namespace

void measure(const Row& row) {
  std::map<std::string, Unrounded> twins;
  std::optional<Reference::Answer> motion;
  for (const SceneDescription& way : every_way(row.scene)) {
    const Run done = run(way, row.steps);
    Record r = record_of(row.extreme, row.name, way, done);
    r.limit = row.limit(way);
    const auto say = [&](const char* measure, double value, double bound, std::string why) {
      r.measure = measure;
      r.value = value;
      r.bound = bound;
      r.why = std::move(why);
      report(r);
    };
    if (!done.reached()) {
      say("outcome", 1, 0, "must be REACHED: " + done.sentence());
      continue;
    }
    const Scene& scene = *done.scene;
    const std::string key = r.method + std::to_string(r.order);
    if (!twins.contains(key)) twins.emplace(key, unrounded(scene, row.steps));
    const Unrounded& ideal = twins.at(key);
    const double bound = rounding_bound(scene, row.steps, ideal.condition);
    const MotionState state = read_motion(scene, *done.simulation);
    if (ideal.twin)
      say("rounding", error_of(state, ideal.twin->state()).largest(), bound,
          rounding_reason(scene, ideal.condition) + "; against the same map in quadruple precision");
    if (!motion) motion = exact(scene, row.steps);
    if (motion && !r.method.empty()) {
      const double h_omega = row.h_omega, p = r.order;
      const double truncation = scene.method() == "exact"      ? 0
                                : scene.method() == "adaptive" ? 100 * scene.tolerance()
                                                               : 10 * std::pow(h_omega, p);
      say("error", error_of(state, motion->state).largest(),
          truncation * ideal.condition * (1 + h_omega * static_cast<double>(row.steps)) + bound +
              10 * motion->error,
          "κ t (h‖Ω‖)^order, and rounding; against the exact motion");
    }
    r.limit.reset();
    const Diagnosis diagnosis = diagnose(scene, *done.simulation);
    double drift = 0;
    for (const auto& invariant : diagnosis.invariants)
      if (invariant.kept == Kept::exact) drift = std::max(drift, invariant.drift());
    say("drift", drift, rounding_bound(scene, row.steps, 1),
        rounding_reason(scene, 1) + "; of what the method declares exact");
    if (diagnosis.orthogonality && is_exact(diagnosis, "orthogonality"))
      say("orthogonality", *diagnosis.orthogonality, rounding_bound(scene, row.steps, 1),
          rounding_reason(scene, 1) + "; max |QQᵀ - I|");
  }
}

}  // namespace stiefel::extremes
