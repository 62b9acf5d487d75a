#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/simulation/summary/byte_stream.h"
#include "engine/simulation/summary/long_sum.h"
#include "stiefel/summary.h"

namespace stiefel {

/// The one NaN of all results: 0x7ff8000000000000.
double canonical(double x);

/// What the statistics of one quantity need of the samples that have gone by, element by element.
/// `last` is not among them: it is read where the motion ends.
class Accumulators {
 public:
  /// `size`: elements. `keep`: values to make room for, where quantiles are asked for.
  Accumulators(const Quantity& quantity, std::size_t size, std::size_t keep);

  /// The next sample. `drifts` may be empty unless that statistic is asked for.
  void take(std::span<const double> values, std::span<const double> drifts);
  /// Whether the largest drift of one number is all that is asked for, but for last.
  bool drift_alone() const { return drift_alone_ && drift_.size() == 1; }
  /// The next samples of such a quantity, with the largest of their drifts; nothing where it is not
  /// above those before.
  void take_drift(std::size_t samples, std::optional<double> largest);
  /// Adds the samples of another member, as if they came after this one's.
  void merge(const Accumulators& other);

  /// The results, an element after another; of quantiles and histograms all numbers of an element
  /// together.
  std::vector<double> result(Statistic statistic) const;  ///< but for last and sign_changes
  std::vector<std::int64_t> sign_changes() const { return changes_; }
  std::vector<double> quantiles() const;
  std::vector<std::int64_t> histogram() const { return bins_; }
  std::int64_t samples() const { return samples_; }

  void save(ByteWriter& out) const;
  void restore(ByteReader& in);

 private:
  void count_changes(std::span<const double> values);
  void count_bins(std::span<const double> values);

  const Quantity* quantity_;
  std::size_t size_, room_;
  std::int64_t samples_ = 0;
  // Empty where they are not asked for.
  std::vector<double> least_, largest_, drift_;
  std::vector<LongSum> sum_, squares_;
  std::vector<std::int64_t> changes_;
  std::vector<std::int8_t> sign_;  ///< of the last value that was not 0
  std::vector<double> kept_;       ///< sample after sample
  std::vector<std::int64_t> bins_;
  bool drift_alone_;  ///< nothing else is asked for but last
};

/// Quantiles of values by linear interpolation between neighbours in order, at q·(count − 1): NaN
/// where a value is NaN or there is none. Orders `values`.
void write_quantiles(std::vector<double>& values, std::span<const double> fractions, double* out);

}  // namespace stiefel
