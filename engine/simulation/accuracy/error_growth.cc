#include "engine/simulation/accuracy/error_growth.h"

#include <algorithm>
#include <cmath>

namespace stiefel {
namespace {

/// Returns the power of time by which the errors grew in the last half of their course, between 1
/// and 2.
double power_of(const std::vector<double>& course, const Samples& samples) {
  const std::int64_t end = samples.steps[course.size() - 1];
  const auto half = std::ranges::upper_bound(samples.steps, end / 2) - samples.steps.begin();
  const double then = half > 0 ? course[static_cast<std::size_t>(half - 1)] : 0;
  return then > 0 ? std::clamp(std::log2(course.back() / then), 1.0, 2.0) : 2;
}

/// Factor by which an error may exceed the declared one.
constexpr double error_margin = 1.25;
/// The part of a run's time before which its errors are not checked.
constexpr double early = 1.0 / 8;

}  // namespace

double ErrorGrowth::beyond(const Candidate& candidate, const Run& run, const Samples& samples,
                           std::int64_t horizon_steps) {
  const std::size_t n = run.errors.size();
  std::vector<double> course;
  for (std::size_t i = 1; i <= n; ++i) course.push_back(run.largest_error(i));
  const double end = course.back();
  if (n < course_.size() && course_[n - 1] > 0)
    for (std::size_t i = n; i < course_.size(); ++i)
      course.push_back(end * (course_[i] / course_[n - 1]));
  const double rest =
      static_cast<double>(horizon_steps) / static_cast<double>(samples.steps[course.size() - 1]);
  const double power = candidate.keeps_energy ? 1 : power_of(course, samples);
  const double at_horizon = course.back() * std::pow(rest, power);
  course_.assign(course.begin(), std::ranges::lower_bound(course, saturated_error));
  return end > 0 ? at_horizon / end : std::pow(rest, power);
}

bool ErrorGrowth::falls_as_declared(const Candidate& candidate, double shorter, const Run& run,
                                    const Samples& samples) const {
  const std::size_t n = run.errors.size();
  if (n == 0 || n > course_.size() || candidate.own_steps) return false;
  const double from = early * static_cast<double>(samples.steps[n - 1]);
  for (std::size_t i = 0; i < n; ++i)
    if (static_cast<double>(samples.steps[i]) >= from &&
        !(run.largest_error(i + 1) <=
          error_margin * course_[i] * std::pow(shorter, -candidate.order)))
      return false;
  return true;
}

}  // namespace stiefel
