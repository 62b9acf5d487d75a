#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stiefel::bench {

/// Returns the seconds that `work` takes.
template <class Work>
double seconds(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Returns the seconds of processor time that `work` takes on all threads of this program. Other
/// programs do not count.
template <class Work>
double processor_seconds(Work&& work) {
  const auto now = [] {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A figure and its rival's, one pair per repeat. The bound applies to the median of the ratios.
struct Comparison {
  std::string name, unit, rival;
  std::optional<double> bound = {};
  std::vector<double> ours = {}, theirs = {};

  void add(double our, double their) {
    ours.push_back(our);
    theirs.push_back(their);
  }
};

/// A figure without a rival. The bound applies to the worst repeat.
struct Figure {
  std::string name, unit;
  std::optional<double> bound = {};
  std::vector<double> values = {};
};

inline nlohmann::json bound_of(const std::optional<double>& bound) {
  return bound ? nlohmann::json(*bound) : nlohmann::json();
}

/// Writes one line of JSON to stdout, which run.py reads.
inline void report(const Comparison& c) {
  std::cout << nlohmann::json{{"name", c.name}, {"unit", c.unit},     {"rival", c.rival},
                              {"ours", c.ours}, {"theirs", c.theirs}, {"bound", bound_of(c.bound)}}
            << std::endl;
}
inline void report(const Figure& f) {
  std::cout << nlohmann::json{{"name", f.name},
                              {"unit", f.unit},
                              {"values", f.values},
                              {"bound", bound_of(f.bound)}}
            << std::endl;
}

}  // namespace stiefel::bench
