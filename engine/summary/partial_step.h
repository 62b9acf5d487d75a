#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Computes states between the steps of one scene by the scene's own method: a shorter step from
/// the state before, or for a closed form the state at that time. It uses a simulation of its own.
class PartialStep {
 public:
  explicit PartialStep(const Scene& scene);

  /// Simulation::direct of the scene.
  bool direct() const { return direct_; }
  /// Returns a simulation in the state at step k + fraction, −1 < fraction < 2, valid until the
  /// next call; null where the shorter step has no solution, or on a stop request. `saved` is the
  /// state at step k; it is the result where the fraction is so small that no number would change.
  /// The step index of the returned simulation has no meaning.
  const Simulation* at(std::int64_t k, double fraction, std::span<const double> saved,
                       const std::stop_token& stop);
  /// Returns a simulation in the state at the first of several times, for a closed form only; valid
  /// until the next call. The next calls may ask for the other times.
  const Simulation* at_first_of(std::span<const double> times, const std::stop_token& stop);

 private:
  const Scene& scene_;
  std::unique_ptr<Simulation> simulation_;
  bool direct_;
};

}  // namespace stiefel
