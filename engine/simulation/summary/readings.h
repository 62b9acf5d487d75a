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

/// States of one scene as Simulation::save gives them, at samples that follow one another.
struct SavedStates {
  std::span<const double> numbers;  ///< of the first state on
  std::size_t stride;               ///< numbers from one state to the next
  std::size_t count;

  std::span<const double> operator[](std::size_t k) const { return numbers.subspan(k * stride); }
};

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

  /// Whether `largest_drift` may be called: the quantity is one number, which is read from what
  /// Simulation::save gives.
  virtual bool reads_saved() const { return false; }
  /// The largest drift at saved states, NaN if it is one at any of them; nothing where it is not
  /// above that of the calls before.
  virtual std::optional<double> largest_drift(const SavedStates&) { return std::nullopt; }

 protected:
  std::size_t size_ = 0;
  std::vector<std::size_t> shape_;
};

/// The reading of the field or the invariants of that name; null if there are none. `start`: the
/// scene at step 0.
std::unique_ptr<Reading> make_reading(const Scene& scene, const Simulation& start,
                                      const std::string& name);

}  // namespace stiefel
