#include "engine/accuracy/error_growth.h"

#include <algorithm>
#include <cmath>

namespace stiefel {
namespace {

bool is_compensated(const Candidate& candidate) {
  return candidate.method.arithmetic == "compensated";
}

/// Factor above which the growth of an error while the time doubles is exponential: no power of
/// time that a method's error follows reaches it.
constexpr double most_by_a_power = 8;

/// Returns the largest number of samples up to a step.
std::size_t samples_up_to(const ErrorGrowth::Steps& steps, std::int64_t step) {
  return static_cast<std::size_t>(std::ranges::upper_bound(steps, step) - steps.begin());
}

/// Returns the factor by which the errors grew while the time doubled to that of the last of so
/// many samples; 0 if that is not known.
double doubling(const std::vector<double>& course, const ErrorGrowth::Steps& steps,
                std::size_t samples) {
  if (samples == 0) return 0;
  const std::size_t half = samples_up_to(steps, steps[samples - 1] / 2);
  return half > 0 && course[half - 1] > 0 ? course[samples - 1] / course[half - 1] : 0;
}

/// Returns the power of time by which the rounding errors of a run grow. It is 1; in compensated
/// arithmetic, where only the rounding of the state that is read may be left, it is between 0 and 1
/// and taken from the last three quarters of the run.
double power_of_rounding(const Candidate& candidate, const std::vector<double>& course,
                         const ErrorGrowth::Steps& steps) {
  const std::int64_t end = steps[course.size() - 1];
  const std::size_t quarter = samples_up_to(steps, end / 4);
  if (!is_compensated(candidate) || quarter == 0 || !(course[quarter - 1] > 0)) return 1;
  const double time = static_cast<double>(end) / static_cast<double>(steps[quarter - 1]);
  return std::clamp(std::log(course.back() / course[quarter - 1]) / std::log(time), 0.0, 1.0);
}

/// Factor by which an error may exceed the declared one.
constexpr double error_margin = 1.25;

}  // namespace

double ErrorGrowth::rounding_part(const Candidate& candidate, const Run& run) const {
  const std::size_t n = run.errors.size();
  if (n > course_.size() || candidate.own_steps || candidate.order == 0) return 0;
  const double end = run.largest_error(n), map_steps = run.work / candidate.weight;
  const double of_method = error_margin * course_[n - 1] * std::pow(2, -candidate.order);
  return std::clamp(end - of_method, 0.0, std::min(end, map_steps * 0x1p-53));
}

double ErrorGrowth::beyond(const Candidate& candidate, const Run& run,
                           const ErrorGrowth::Steps& steps, std::int64_t horizon_steps) {
  const std::size_t n = run.errors.size();
  std::vector<double> course;
  for (std::size_t i = 1; i <= n; ++i) course.push_back(run.largest_error(i));
  const double end = course.back();
  const double rounding = rounding_part(candidate, run);
  const double rounding_power = power_of_rounding(candidate, course, steps);
  const auto time_to = [&](std::int64_t step, std::size_t sample) {
    return static_cast<double>(step) / static_cast<double>(steps[sample]);
  };
  if (n < course_.size() && course_[n - 1] > 0)
    for (std::size_t i = n; i < course_.size(); ++i)
      course.push_back((end - rounding) * (course_[i] / course_[n - 1]) +
                       rounding * std::pow(time_to(steps[i], n - 1), rounding_power));
  const double rest = time_to(horizon_steps, course.size() - 1);
  // The power of time by which the errors grew in the last half, and the factors of the last two
  // doublings.
  const double last = doubling(course, steps, course.size()),
               grew = last > 0 ? std::clamp(std::log2(last), 1.0, 2.0) : 2,
               power = candidate.keeps_energy ? 1 : grew,
               before = doubling(course, steps, samples_up_to(steps, steps[course.size() - 1] / 2));
  const double rounding_there =
      rounding * std::pow(time_to(steps[course.size() - 1], n - 1), rounding_power);
  const double at_horizon = (course.back() - rounding_there) * std::pow(rest, power) +
                            rounding_there * std::pow(rest, rounding_power);
  course_.assign(course.begin(), std::ranges::lower_bound(course, saturated_error));
  if (std::min(last, before) > most_by_a_power) {
    const double exponent = 2 * std::log(last) * (rest - 1);
    const double grown = course.back() * std::exp(std::min(exponent, 700.0));
    return std::min(grown, std::max(1.0, end)) / end;
  }
  return end > 0 ? at_horizon / end : std::pow(rest, power);
}

}  // namespace stiefel
