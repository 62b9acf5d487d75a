#include "engine/summary/readings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/stepping/invariant_list.h"
#include "engine/summary/energy_of_body.h"
#include "stiefel/diagnosis.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

/// Reads a field as it is sampled.
class FieldReading final : public Reading {
 public:
  FieldReading(const Simulation& start, std::size_t index)
      : index_(index), start_(field_size(start.fields(), index)) {
    size_ = start_.size();
    const Field field = field_at(start.fields(), index);
    shape_ = {static_cast<std::size_t>(field.rows), static_cast<std::size_t>(field.cols)};
    start.write(index, start_);
  }

  void read(const Simulation& now, std::span<double> values, std::span<double> drifts,
            const std::stop_token&) override {
    now.write(index_, values);
    for (std::size_t i = 0; i < drifts.size(); ++i) drifts[i] = std::abs(values[i] - start_[i]);
  }

 private:
  std::size_t index_;
  std::vector<double> start_;
};

/// Reads invariants through the list that Diagnose uses. An invariant that is not finite at a later
/// state is NaN.
class InvariantReading final : public Reading {
 public:
  InvariantReading(const Simulation& start, std::string name) : only_{std::move(name)} {
    InvariantList list(only_);
    start.invariants(list);
    for (const auto& entry : list.entries())
      start_.push_back({entry.name, entry.value, entry.scale});
    size_ = start_.size();
    if (size_ != 1 || start_.front().name != only_.front()) shape_ = {size_};
  }

  void read(const Simulation& now, std::span<double> values, std::span<double> drifts,
            const std::stop_token& stop) override {
    InvariantList list(only_, stop);
    now.invariants(list);
    std::size_t at = 0;
    for (std::size_t i = 0; i < start_.size(); ++i) {
      const bool there = at < list.entries().size() && list.entries()[at].name == start_[i].name;
      const long double value =
          there ? list.entries()[at++].value : std::numeric_limits<long double>::quiet_NaN();
      values[i] = static_cast<double>(value);
      if (!drifts.empty()) drifts[i] = drift_of(start_[i].value, value, start_[i].scale);
    }
  }

 private:
  struct AtStart {
    std::string name;
    long double value, scale;
  };

  const std::vector<std::string> only_;
  std::vector<AtStart> start_;
};

/// Reads the energy of a body in three dimensions, with the bits of InvariantReading and without
/// its allocations.
class EnergyReading final : public Reading {
 public:
  EnergyReading(const EnergyOfBody& energy, const InvariantList::Entry& start,
                std::size_t saved_size)
      : energy_(energy), initial_(start.value), scale_(start.scale), saved_(saved_size) {
    size_ = 1;
  }

  void read(const Simulation& now, std::span<double> values, std::span<double> drifts,
            const std::stop_token&) override {
    now.save(saved_);
    const long double E = energy_(saved_);
    values[0] = is_number(E) ? static_cast<double>(E) : nan;
    if (!drifts.empty()) drifts[0] = is_number(E) ? drift_of(initial_, E, scale_) : nan;
  }

  bool reads_saved() const override { return true; }

  /// Finds the largest change first and divides only that by the scale: the drift grows with the
  /// change.
  std::optional<double> largest_drift(const SavedStates& states) override {
    long double largest = largest_change_;
    for (std::size_t k = 0; k < states.count; ++k) {
      const long double E = energy_(states[k]), change = std::abs(E - initial_);
      if (!is_number(E)) return nan;
      if (change > largest) largest = change;
    }
    if (largest == largest_change_) return std::nullopt;
    largest_change_ = largest;
    return static_cast<double>(scale_ > 0 || scale_ < 0 ? largest / scale_ : largest);
  }

 private:
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  /// Whether E is finite as a double.
  static bool is_number(long double E) {
    return std::abs(E) <= std::numeric_limits<double>::max() ||
           std::isfinite(static_cast<double>(E));
  }

  EnergyOfBody energy_;
  long double initial_, scale_, largest_change_ = -1;
  std::vector<double> saved_;
};

std::unique_ptr<Reading> energy_reading(const Scene& scene, const Simulation& start) {
  const std::vector<std::string> only{std::string(family::energy)};
  InvariantList list(only);
  start.invariants(list);
  if (list.entries().size() != 1) return nullptr;
  if (const auto energy = EnergyOfBody::make(scene, start, list.entries().front().value))
    return std::make_unique<EnergyReading>(*energy, list.entries().front(), start.saved_size());
  return nullptr;
}

}  // namespace

std::unique_ptr<Reading> make_reading(const Scene& scene, const Simulation& start,
                                      const std::string& name) {
  if (const auto field = find_field(start.fields(), name))
    return std::make_unique<FieldReading>(start, *field);
  if (!is_invariant(scene, name)) return nullptr;
  if (name == family::energy)
    if (auto fast = energy_reading(scene, start)) return fast;
  auto reading = std::make_unique<InvariantReading>(start, name);
  if (reading->size() == 0) return nullptr;
  return reading;
}

}  // namespace stiefel
