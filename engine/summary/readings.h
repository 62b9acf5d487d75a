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

/// States of one scene at successive samples, as Simulation::save gives them.
struct SavedStates {
  std::span<const double> numbers;  ///< starts with the first state
  std::size_t stride;               ///< numbers from one state to the next
  std::size_t count;

  std::span<const double> operator[](std::size_t k) const { return numbers.subspan(k * stride); }
};

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

  /// Whether `largest_drift` may be called: the quantity is one number that can be computed from
  /// what Simulation::save gives.
  virtual bool reads_saved() const { return false; }
  /// Returns the largest drift at saved states, NaN if it is NaN at any of them; nullopt if it does
  /// not exceed the largest of earlier calls.
  virtual std::optional<double> largest_drift(const SavedStates&) { return std::nullopt; }

 protected:
  std::size_t size_ = 0;
  std::vector<std::size_t> shape_;
};

/// Returns the reading of the field or the invariants of that name; null if there are none. `start`
/// is the simulation of the scene at step 0.
std::unique_ptr<Reading> make_reading(const Scene& scene, const Simulation& start,
                                      const std::string& name);

}  // namespace stiefel
