#include "engine/simulation/summary/partial_step.h"

namespace stiefel {

const Simulation* PartialStep::at(std::int64_t k, double fraction, std::span<const double> saved) {
  SceneDescription description = scene_.description();
  if (direct_) {
    const long double steps = static_cast<long double>(k) + fraction;
    description.step = static_cast<double>(steps * scene_.step());
    description.method->substeps = 1;
  } else {
    description.step = fraction * scene_.step();
  }
  const auto shorter = Scene::resolve(std::move(description), Scene::drift_tolerance);
  if (!shorter) return nullptr;
  simulation_ = make_simulation(*shorter);
  if (!direct_) simulation_->restore(0, saved);
  return simulation_->advance(1).reached() ? simulation_.get() : nullptr;
}

}  // namespace stiefel
