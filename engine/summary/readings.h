#pragma once

#include <memory>
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

  /// Returns the number of values; two for each element of a complex field.
  std::size_t size() const { return size_; }
  /// Returns the shape: (rows, cols) for a field, () for a single invariant, (number of invariants)
  /// for a family.
  const std::vector<std::size_t>& shape() const { return shape_; }

  /// Writes the values at the state of `now` and, unless `drifts` is empty, their drifts as
  /// Statistic::drift defines them. A stop request may leave them incomplete.
  virtual void read(const Simulation& now, std::span<double> values, std::span<double> drifts,
                    const std::stop_token& stop) = 0;

 protected:
  std::size_t size_ = 0;
  std::vector<std::size_t> shape_;
};

/// Returns the reading of the field or the invariants of that name; null if there are none. `start`
/// is the simulation of the scene at step 0.
std::unique_ptr<Reading> make_reading(const Scene& scene, const Simulation& start,
                                      const std::string& name);

}  // namespace stiefel
