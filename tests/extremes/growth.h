#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

namespace stiefel::extremes {

/// Returns 10, 20, 50, 100, ... up to `last`.
inline std::vector<std::int64_t> thirds_of_decades(std::int64_t last) {
  std::vector<std::int64_t> steps;
  for (std::int64_t decade = 10; decade <= last; decade *= 10)
    for (const std::int64_t part : {1, 2, 5})
      if (decade * part <= last) steps.push_back(decade * part);
  return steps;
}

/// The growth of an error with the number of steps, as the root mean square over many scenes.
class Growth {
 public:
  void add(std::int64_t step, double error) {
    Sum& sum = at_[step];
    sum.squares += error * error;
    ++sum.count;
  }

  std::map<std::int64_t, double> rms() const {
    std::map<std::int64_t, double> all;
    for (const auto& [step, sum] : at_) all[step] = std::sqrt(sum.squares / sum.count);
    return all;
  }

  /// Returns the p of error ~ stepsᵖ over the last three decades, by least squares of the
  /// logarithms.
  double exponent() const {
    const auto all = rms();
    const double last = std::log10(static_cast<double>(all.rbegin()->first));
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [step, value] : all) {
      const double a = std::log10(static_cast<double>(step));
      if (a < last - 3.01 || !(value > 0)) continue;
      const double b = std::log10(value);
      n += 1;
      x += a;
      y += b;
      xx += a * a;
      xy += a * b;
    }
    return (n * xy - x * y) / (n * xx - x * x);
  }

 private:
  struct Sum {
    double squares = 0;
    int count = 0;
  };
  std::map<std::int64_t, Sum> at_;
};

}  // namespace stiefel::extremes
