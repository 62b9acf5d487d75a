#include "engine/simulation/summary/partial_step.h"

namespace stiefel {

const Simulation* PartialStep::at(std::int64_t k, double fraction, std::span<const double> saved,
                                  const std::stop_token& stop) {
  if (direct_) {
    const long double steps = static_cast<long double>(k) + fraction;
    return at_time(static_cast<double>(steps * scene_.step()), stop);
  }
  SceneDescription shorter = scene_.description();
  shorter.step = fraction * scene_.step();
  return advanced(std::move(shorter), saved, stop);
}

const Simulation* PartialStep::at_time(double time, const std::stop_token& stop) {
  SceneDescription one_step = scene_.description();
  one_step.step = time;
  one_step.method->substeps = 1;
  return advanced(std::move(one_step), {}, stop);
}

const Simulation* PartialStep::advanced(SceneDescription shorter, std::span<const double> saved,
                                        const std::stop_token& stop) {
  if (stop.stop_requested()) return nullptr;
  const auto scene = Scene::resolve(std::move(shorter), Scene::drift_tolerance);
  if (!scene) return nullptr;
  simulation_ = make_simulation(*scene);
  if (!saved.empty()) simulation_->restore(0, saved);
  return simulation_->advance(1, stop).reached() ? simulation_.get() : nullptr;
}

}  // namespace stiefel
