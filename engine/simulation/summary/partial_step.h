#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// States between the steps of one scene, by the scene's own method: what it makes of a state with
/// a shorter step, and of a closed form the state at that time. The simulation whose states these
/// are is not touched.
class PartialStep {
 public:
  /// `direct`: Simulation::direct of the scene's simulation.
  PartialStep(const Scene& scene, bool direct) : scene_(scene), direct_(direct) {}

  /// The simulation at step k + fraction, 0 < fraction < 1, valid until the next call; null where
  /// the shorter step has no solution, or when it is asked to stop. `saved`: the state at step k.
  /// Its step index is not a scene's.
  const Simulation* at(std::int64_t k, double fraction, std::span<const double> saved,
                       const std::stop_token& stop);
  /// Of a closed form: the simulation at that time.
  const Simulation* at_time(double time, const std::stop_token& stop);

 private:
  const Simulation* advanced(SceneDescription shorter, std::span<const double> saved,
                             const std::stop_token& stop);

  const Scene& scene_;
  bool direct_;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace stiefel
