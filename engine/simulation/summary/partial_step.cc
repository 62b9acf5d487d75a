#include "engine/simulation/summary/partial_step.h"

namespace stiefel {

const Simulation* PartialStep::at(std::int64_t k, double fraction, std::span<const double> saved) {
  if (direct_) {
    const long double steps = static_cast<long double>(k) + fraction;
    return at_time(static_cast<double>(steps * scene_.step()));
  }
  SceneDescription shorter = scene_.description();
  shorter.step = fraction * scene_.step();
  return advanced(std::move(shorter), saved);
}

const Simulation* PartialStep::at_time(double time) {
  SceneDescription one_step = scene_.description();
  one_step.step = time;
  one_step.method->substeps = 1;
  return advanced(std::move(one_step), {});
}

const Simulation* PartialStep::advanced(SceneDescription shorter, std::span<const double> saved) {
  const auto scene = Scene::resolve(std::move(shorter), Scene::drift_tolerance);
  if (!scene) return nullptr;
  simulation_ = make_simulation(*scene);
  if (!saved.empty()) simulation_->restore(0, saved);
  return simulation_->advance(1).reached() ? simulation_.get() : nullptr;
}

}  // namespace stiefel
