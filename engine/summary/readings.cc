#include "engine/summary/readings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/motion/invariant_list.h"
#include "engine/motion/system_entry.h"
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

/// Reads the energy ½ Σ m_k²/I_k, I_1 = λ_2 + λ_3 and cyclic, of a body in three dimensions from
/// what Simulation::save gives: (q; m), or m alone, before everything else. It has the bits of
/// InvariantReading, because it makes the same sums in extended precision, and does not allocate.
class EnergyReading final : public Reading {
 public:
  /// Returns null where the scene is not such a body, or where this computation of the energy at
  /// step 0 differs in a bit from that among the invariants of `start`.
  static std::unique_ptr<Reading> make(const Scene& scene, const Simulation& start) {
    const std::size_t first = scene.has_frame() ? 4 : 0;
    if (!system_entry(scene.system())->packs || scene.dimension() != 3 || scene.in_float() ||
        start.saved_size() < first + 3)
      return nullptr;
    const std::vector<std::string> only{std::string(family::energy)};
    InvariantList list(only);
    start.invariants(list);
    if (list.entries().size() != 1) return nullptr;
    auto made = std::make_unique<EnergyReading>(scene, first, list.entries().front(), start);
    return made->energy(start) == made->initial_ ? std::move(made) : nullptr;
  }

  EnergyReading(const Scene& scene, std::size_t first, const InvariantList::Entry& start,
                const Simulation& at)
      : initial_(start.value), scale_(start.scale), first_(first), saved_(at.saved_size()) {
    size_ = 1;
    const Eigen::VectorXd& lambda = scene.inertia();
    for (const int k : {0, 1, 2})
      I_[k] = static_cast<long double>(lambda((k + 1) % 3)) + lambda((k + 2) % 3);
  }

  void read(const Simulation& now, std::span<double> values, std::span<double> drifts,
            const std::stop_token&) override {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const long double E = energy(now);
    values[0] = static_cast<double>(E);
    const bool is_number = std::isfinite(values[0]);
    if (!is_number) values[0] = nan;
    if (!drifts.empty()) drifts[0] = is_number ? drift_of(initial_, E, scale_) : nan;
  }

 private:
  long double energy(const Simulation& now) {
    now.save(saved_);
    const double* m = saved_.data() + first_;
    long double sum = 0;
    for (const int k : {2, 1, 0}) sum += static_cast<long double>(m[k]) * m[k] / I_[k];
    return sum / 2;
  }

  long double initial_, scale_;
  std::size_t first_;
  std::array<long double, 3> I_;
  std::vector<double> saved_;
};

}  // namespace

std::unique_ptr<Reading> make_reading(const Scene& scene, const Simulation& start,
                                      const std::string& name) {
  if (const auto field = find_field(start.fields(), name))
    return std::make_unique<FieldReading>(start, *field);
  if (!is_invariant(scene, name)) return nullptr;
  if (name == family::energy)
    if (auto fast = EnergyReading::make(scene, start)) return fast;
  auto reading = std::make_unique<InvariantReading>(start, name);
  if (reading->size() == 0) return nullptr;
  return reading;
}

}  // namespace stiefel
