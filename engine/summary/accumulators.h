#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/numbers/byte_stream.h"
#include "stiefel/summary.h"

namespace stiefel {

/// Returns x, or for a NaN the only NaN that results contain, 0x7ff8000000000000.
double canonical(double x);

/// A sum in extended precision that carries the rounding errors of its additions (Neumaier 1974).
/// The relative error of a sum of n < 2³² numbers is about 2⁻⁶⁴. Squares of doubles neither
/// overflow nor underflow in it.
struct LongSum {
  long double sum = 0, carry = 0;

  void add(long double x) {
    const long double next = sum + x;
    carry += std::abs(sum) >= std::abs(x) ? (sum - next) + x : (x - next) + sum;
    sum = next;
  }
  void add(const LongSum& other) {
    add(other.sum);
    carry += other.carry;
  }
  /// Returns the sum; it is not finite if a summand was not.
  long double value() const { return std::isfinite(sum) ? sum + carry : sum; }
};

/// Accumulates what the statistics of one quantity need of the samples, element by element. `last`
/// is not among them: it is read where the motion ends.
class Accumulators {
 public:
  /// `size` is the number of elements, `keep` the number of values to reserve for quantiles.
  Accumulators(const Quantity& quantity, std::size_t size, std::size_t keep);

  /// Takes the next sample. `drifts` may be empty unless Statistic::drift is asked for.
  void take(std::span<const double> values, std::span<const double> drifts);
  /// Adds the samples of another member, as if they came after this one's.
  void merge(const Accumulators& other);

  // The results, element by element; all numbers of an element's quantiles or histogram stand
  // together.

  /// Returns a statistic other than `last` and `sign_changes`.
  std::vector<double> result(Statistic statistic) const;
  std::vector<std::int64_t> sign_changes() const { return changes_; }
  std::vector<double> quantiles() const;
  std::vector<std::int64_t> histogram() const { return bins_; }
  std::int64_t samples() const { return samples_; }

  void save(ByteWriter& out) const;
  void restore(ByteReader& in);

 private:
  void count_changes(std::span<const double> values);
  void count_bins(std::span<const double> values);
  /// Visits all numbers but the values kept for quantiles.
  template <class Self, class Visit>
  static void each(Self& self, const Visit& visit);

  const Quantity* quantity_;
  std::size_t size_, room_;
  std::int64_t samples_ = 0;
  // A vector is empty if no statistic needs it.
  std::vector<double> least_, largest_, drift_;
  std::vector<LongSum> sum_, squares_;
  std::vector<std::int64_t> changes_;
  std::vector<std::int8_t> sign_;  ///< sign of the last value that was not 0
  std::vector<double> kept_;       ///< values for quantiles, sample after sample
  std::vector<std::int64_t> bins_;
};

}  // namespace stiefel
