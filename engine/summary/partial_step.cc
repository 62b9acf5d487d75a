#include "engine/summary/partial_step.h"

#include <cmath>

#include "engine/motion/observed_simulation.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {
namespace {

/// A smaller part of a step changes no number of a state by more than its rounding: a step turns a
/// body by less than 2³² radians, and blocks move at most 2³² times as fast as frames turn. A step
/// this short would lose its own square to underflow.
constexpr double least_in_double = 0x1p-120, least_in_float = 0x1p-60;

/// Returns the scene with a step of any size.
Scene with_step(const Scene& scene, double step, int substeps) {
  SceneDraft draft(scene);
  draft.given().step = step;
  draft.given().method->substeps = substeps;
  return draft.take().value();
}

}  // namespace

PartialStep::PartialStep(const Scene& scene)
    : scene_(scene), simulation_(make_simulation(scene)), direct_(simulation_->direct()) {}

const Simulation* PartialStep::at(std::int64_t k, double fraction, std::span<const double> saved,
                                  const std::stop_token& stop) {
  if (direct_) {
    const long double steps = static_cast<long double>(k) + fraction;
    const auto time = static_cast<double>(steps * scene_.step());
    return at_first_of({&time, 1}, stop);
  }
  if (stop.stop_requested()) return nullptr;
  const bool moves = std::abs(fraction) >= (scene_.in_float() ? least_in_float : least_in_double);
  simulation_ = make_simulation(
      moves ? with_step(scene_, fraction * scene_.step(), scene_.substeps()) : scene_);
  simulation_->restore(0, saved);
  if (moves && !simulation_->advance(1, stop).reached()) return nullptr;
  return simulation_.get();
}

const Simulation* PartialStep::at_first_of(std::span<const double> times,
                                           const std::stop_token& stop) {
  if (stop.stop_requested()) return nullptr;
  auto& motion = dynamic_cast<ObservedSimulation&>(*simulation_);
  return motion.move_to(times, stop).reached() ? simulation_.get() : nullptr;
}

}  // namespace stiefel
