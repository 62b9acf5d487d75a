#include "engine/summary/accumulators.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace stiefel {
namespace {

bool asks(const Quantity& quantity, Statistic statistic) {
  return std::ranges::find(quantity.statistics, statistic) != quantity.statistics.end();
}

/// Set an extreme value to x if x lies beyond it or is NaN. A NaN stays.
void lower(double& least, double x) {
  if (x < least || std::isnan(x)) least = x;
}
void raise(double& largest, double x) {
  if (x > largest || std::isnan(x)) largest = x;
}

/// Compares for sorting, with −0 before 0, so that the bits of a quantile depend on the values
/// alone.
bool before(double a, double b) { return a < b || (a == b && std::signbit(a) && !std::signbit(b)); }

/// Computes quantiles by linear interpolation between neighbours in sorted order, at position
/// q·(count − 1). The result is NaN if a value is NaN or there is none. Sorts `values`.
void write_quantiles(std::vector<double>& values, std::span<const double> fractions, double* out) {
  if (values.empty() || std::ranges::any_of(values, [](double x) { return std::isnan(x); })) {
    std::fill_n(out, fractions.size(), canonical(std::nan("")));
    return;
  }
  std::ranges::sort(values, before);
  for (const double fraction : fractions) {
    const double position = fraction * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(position);
    const double a = values[below], b = values[std::min(below + 1, values.size() - 1)];
    const double t = position - static_cast<double>(below);
    // Interpolates from the nearer neighbour, so that both ends are exact.
    *out++ = canonical(t == 0 || a == b ? a : t < 0.5 ? a + (b - a) * t : b - (b - a) * (1 - t));
  }
}

}  // namespace

double canonical(double x) {
  return std::isnan(x) ? std::bit_cast<double>(std::uint64_t{0x7ff8000000000000}) : x;
}

Accumulators::Accumulators(const Quantity& quantity, std::size_t size, std::size_t keep)
    : quantity_(&quantity), size_(size), room_(keep) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (asks(quantity, Statistic::min)) least_.assign(size, infinity);
  if (asks(quantity, Statistic::max)) largest_.assign(size, -infinity);
  if (asks(quantity, Statistic::drift)) drift_.assign(size, 0);
  if (asks(quantity, Statistic::mean)) sum_.resize(size);
  if (asks(quantity, Statistic::rms)) squares_.resize(size);
  if (asks(quantity, Statistic::sign_changes)) {
    changes_.assign(size, 0);
    sign_.assign(size, 0);
  }
  if (!quantity.quantiles.empty()) kept_.reserve(keep);
  if (!quantity.edges.empty()) bins_.assign(size * (quantity.edges.size() - 1), 0);
}

void Accumulators::take(std::span<const double> values, std::span<const double> drifts) {
  ++samples_;
  for (std::size_t i = 0; i < drift_.size(); ++i) raise(drift_[i], drifts[i]);
  for (std::size_t i = 0; i < least_.size(); ++i) lower(least_[i], values[i]);
  for (std::size_t i = 0; i < largest_.size(); ++i) raise(largest_[i], values[i]);
  for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i].add(values[i]);
  for (std::size_t i = 0; i < squares_.size(); ++i)
    squares_[i].add(static_cast<long double>(values[i]) * values[i]);
  if (!changes_.empty()) count_changes(values);
  if (!quantity_->quantiles.empty()) kept_.insert(kept_.end(), values.begin(), values.end());
  if (!bins_.empty()) count_bins(values);
}

void Accumulators::count_changes(std::span<const double> values) {
  for (std::size_t i = 0; i < size_; ++i) {
    const auto sign = static_cast<std::int8_t>((values[i] > 0) - (values[i] < 0));
    if (sign == 0) continue;
    if (sign_[i] == -sign) ++changes_[i];
    sign_[i] = sign;
  }
}

void Accumulators::count_bins(std::span<const double> values) {
  const std::vector<double>& edges = quantity_->edges;
  const std::size_t bins = edges.size() - 1;
  for (std::size_t i = 0; i < size_; ++i) {
    if (!(values[i] >= edges.front() && values[i] <= edges.back())) continue;
    const auto above = std::ranges::upper_bound(edges, values[i]);
    const auto bin = static_cast<std::size_t>(above - edges.begin()) - 1;
    ++bins_[i * bins + std::min(bin, bins - 1)];
  }
}

void Accumulators::merge(const Accumulators& other) {
  samples_ += other.samples_;
  for (std::size_t i = 0; i < drift_.size(); ++i) raise(drift_[i], other.drift_[i]);
  for (std::size_t i = 0; i < least_.size(); ++i) lower(least_[i], other.least_[i]);
  for (std::size_t i = 0; i < largest_.size(); ++i) raise(largest_[i], other.largest_[i]);
  for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i].add(other.sum_[i]);
  for (std::size_t i = 0; i < squares_.size(); ++i) squares_[i].add(other.squares_[i]);
  for (std::size_t i = 0; i < changes_.size(); ++i) changes_[i] += other.changes_[i];
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
  kept_.insert(kept_.end(), other.kept_.begin(), other.kept_.end());
}

std::vector<double> Accumulators::result(Statistic statistic) const {
  std::vector<double> out(size_);
  const auto of = [&](const auto& value) {
    for (std::size_t i = 0; i < size_; ++i) out[i] = canonical(value(i));
    return out;
  };
  const auto mean = [&](const LongSum& sum) {
    return sum.value() / static_cast<long double>(samples_);
  };
  switch (statistic) {
    case Statistic::min:
      return of([&](std::size_t i) { return least_[i]; });
    case Statistic::max:
      return of([&](std::size_t i) { return largest_[i]; });
    case Statistic::drift:
      return of([&](std::size_t i) { return drift_[i]; });
    case Statistic::mean:
      return of([&](std::size_t i) { return static_cast<double>(mean(sum_[i])); });
    case Statistic::rms:
      return of([&](std::size_t i) { return static_cast<double>(std::sqrt(mean(squares_[i]))); });
    default:
      return {};
  }
}

std::vector<double> Accumulators::quantiles() const {
  const std::size_t count = quantity_->quantiles.size();
  std::vector<double> out(size_ * count), one;
  for (std::size_t i = 0; i < size_; ++i) {
    one.clear();
    for (std::size_t at = i; at < kept_.size(); at += size_) one.push_back(kept_[at]);
    write_quantiles(one, quantity_->quantiles, out.data() + i * count);
  }
  return out;
}

template <class Self, class Visit>
void Accumulators::each(Self& self, const Visit& visit) {
  visit(self.samples_), visit(self.least_), visit(self.largest_), visit(self.drift_);
  for (auto* sums : {&self.sum_, &self.squares_})
    for (auto& one : *sums) visit(one.sum), visit(one.carry);
  visit(self.changes_), visit(self.sign_), visit(self.bins_);
}

void Accumulators::save(ByteWriter& out) const {
  each(*this, [&](const auto& numbers) { out.put(numbers); });
  out.put(kept_);
}

void Accumulators::restore(ByteReader& in) {
  each(*this, [&](auto& numbers) { in.get(numbers); });
  in.get_up_to(room_, kept_);
}

}  // namespace stiefel
