#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/summary.h"

namespace stiefel {

/// Reads the values of one quantity from states of one scene.
class Reading {
 public:
  virtual ~Reading() = default;

  /// Numbers; of a complex field two for each element.
  std::size_t size() const { return size_; }
  /// Of a field (rows, cols), of a single invariant (), of a family (its invariants).
  const std::vector<std::size_t>& shape() const { return shape_; }

  /// Writes the values at the state of `now`, and unless it is empty their drifts, as
  /// Statistic::drift defines them. Asked to stop it may leave them incomplete.
  virtual void read(const Simulation& now, std::span<double> values, std::span<double> drifts,
                    const std::stop_token& stop) = 0;

  /// Whether `drift_above` may be called: the quantity is one number, which is read from what
  /// Simulation::save gives.
  virtual bool reads_saved() const { return false; }
  /// The drift at a saved state; nothing where it is not above those of the calls before.
  virtual std::optional<double> drift_above(std::span<const double> /*saved*/) {
    return std::nullopt;
  }

 protected:
  std::size_t size_ = 0;
  std::vector<std::size_t> shape_;
};

/// The reading of the field or the invariants of that name; null if there are none. `start`: the
/// scene at step 0.
std::unique_ptr<Reading> make_reading(const Scene& scene, const Simulation& start,
                                      const std::string& name);

}  // namespace stiefel
