#include "stiefel/tradeoff.h"

#include <algorithm>
#include <cmath>

#include "engine/accuracy/search.h"
#include "engine/motion/step_weight.h"
#include "engine/numbers/to_text.h"
#include "stiefel/version.h"

namespace stiefel {
namespace {

/// Share of the budget that the references may take.
constexpr double share_of_reference = 0.5;
/// Part of the rest that the first points of all candidates may take. Where they would take more,
/// all runs are over the same part of the horizon.
constexpr double share_of_first_points = 0.25;
/// Factor above which the growth of an error while the time doubles is exponential: no power of
/// time that a method's error follows reaches it.
constexpr double most_by_a_power = 8;

/// Returns the factor by which the largest error of a run grows from its end to the horizon. It
/// grows with the power of time of the last doubling of the run: 0 to 1 where the energy is kept,
/// else up to 2. An error that grew more than eightfold in each of the last two doublings goes on
/// exponentially, up to the size of the quantity itself.
double growth_beyond(const Run& run, bool keeps_energy, const std::vector<std::int64_t>& steps,
                     std::int64_t horizon_steps) {
  const std::vector<double> course = run.course();
  const auto error_up_to = [&](std::int64_t step) {
    const auto after = std::ranges::upper_bound(steps, step) - steps.begin();
    return after > 0 ? course[static_cast<std::size_t>(after) - 1] : 0;
  };
  const auto growth = [&](std::int64_t to) {
    const double half = error_up_to(to / 2);
    return half > 0 ? error_up_to(to) / half : 0;
  };
  const double end = course.back(), last = growth(run.steps),
               rest = static_cast<double>(horizon_steps) / static_cast<double>(run.steps);
  if (std::min(last, growth(run.steps / 2)) > most_by_a_power) {
    const double exponent = 2 * std::log(last) * (rest - 1);
    return std::min(std::exp(std::min(exponent, 700.0)), std::max(1.0, end) / end);
  }
  const double most = keeps_energy ? 1 : 2;
  return std::pow(rest, last > 0 ? std::clamp(std::log2(last), 0.0, most) : most);
}

/// Returns the error, but at least `known`, below which the reference cannot measure.
MotionError at_least(double known, MotionError error) {
  if (error.attitude) error.attitude = std::max(known, *error.attitude);
  error.momentum = std::max(known, error.momentum);
  return error;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

class Survey final : public Tradeoff {
 public:
  Survey(TradeoffRequest request, PointSearch search)
      : request_(std::move(request)), search_(std::move(search)) {
    if (!request_.horizon) request_.horizon = request_.scene.horizon;
    steps_ = request_.horizon ? steps_to(*request_.horizon, *request_.scene.step)
                              : TradeoffRequest::default_steps;
  }

  std::expected<TradeoffSetup, Violations> solve_reference(const std::stop_token& stop) override {
    const Scene& scene = search_.motions().front();
    search_.solve_references(steps_, Density::coarse, share_of_reference, true, stop);
    if (samples().reference.empty() && !stop.stop_requested())
      return std::unexpected(Violations{
          {"scene.system", scene.system(), "has no reference to measure errors against"}});
    if (samples().steps.empty() && !stop.stop_requested())
      return std::unexpected(
          Violations{{"budget", to_text(request_.budget),
                      "must be larger: the first state of the reference, " + samples().reference +
                          ", takes " + short_text(samples().first_price) +
                          " instructions, and the reference may take half of the budget"}});
    TradeoffSetup setup{machine(), build_fingerprint(), samples().reference};
    setup.reference_error = reference_error();
    setup.horizon = std::abs(scene.time(steps_));
    setup.steps = steps_;
    setup.reference_steps = samples().last();
    setup.budget = request_.budget;
    setup.repeats = static_cast<int>(request_.repeats);
    const std::vector<Candidate> candidates = search_.candidates();
    setup.curves = candidates.size();
    double step_work = 0;
    for (const Candidate& candidate : candidates) {
      step_work += candidate.weight * repeats();
      const auto text = estimate_warning(scene.with(candidate.method).value());
      if (text && std::ranges::find(setup.warnings, *text) == setup.warnings.end())
        setup.warnings.push_back(*text);
    }
    const double share = share_of_first_points * std::max(search_.left(), 0.0);
    for (const std::int64_t step : samples().steps)
      if (measured_steps_ == 0 || static_cast<double>(step) * step_work <= share)
        measured_steps_ = step;
    if (samples().last() < steps_) search_.leave_out(&Candidate::in_float);
    return setup;
  }

  std::optional<TradeoffPoint> next(const std::stop_token& stop) override {
    const auto found =
        search_.next({measured_steps_, Watch::errors_and_invariants, stop}, repeats());
    if (!found) return std::nullopt;
    auto point = described(*found, stop);
    if (stop.stop_requested()) return std::nullopt;
    costs_and_errors_.push_back({point.work, point.error ? point.error->largest() : std::nan("")});
    return point;
  }

  std::vector<std::size_t> front() const override { return pareto_front(costs_and_errors_); }

 private:
  /// Returns a point as it is reported. Repeats its run for the times.
  TradeoffPoint described(const Point& found, const std::stop_token& stop) {
    const Run& run = found.run;
    TradeoffPoint point;
    point.method = found.method;
    point.status = run.status;
    point.measured_steps = run.steps;
    point.drift = run.drift;
    point.drift_of = run.drift_of;
    point.work = found.cost;
    if (run.steps == 0) return point;

    const double step = std::abs(*request_.scene.step),
                 time = step * static_cast<double>(run.steps);
    auto& seconds = point.cpu_seconds_per_second;
    seconds.push_back(run.cpu_seconds / time);
    while (std::ssize(seconds) < request_.repeats && run.status.reached() &&
           run.spent <= search_.left()) {
      const Run again = search_.again(found, stop);
      if (again.status.outcome == Outcome::cancelled) break;
      seconds.push_back(again.cpu_seconds / time);
    }
    const double of_one = median(seconds);
    point.steps_per_second = of_one > 0 ? 1 / (of_one * step) : infinity;
    if (!run.status.reached()) return point;

    const double known = reference_error();
    point.error = at_least(known, run.errors.back());
    point.below_reference = run.errors.back().largest() <= known;
    point.extrapolated = run.steps < steps_;
    if (point.extrapolated) {
      // The amplitude of an oscillating error does not grow, so its envelope is extrapolated.
      const bool keeps_energy = found.candidate.keeps_energy;
      const double envelope = std::max(known, run.largest_error());
      const double factor = growth_beyond(run, keeps_energy, samples().steps, steps_) *
                            std::min(envelope / point.error->largest(), 4.0);
      if (point.error->attitude) *point.error->attitude *= factor;
      point.error->momentum *= factor;
      if (!keeps_energy)
        point.drift *= static_cast<double>(steps_) / static_cast<double>(run.steps);
    }
    return point;
  }

  const Samples& samples() const { return search_.samples(); }
  double reference_error() const { return samples().errors.empty() ? 0 : samples().errors.back(); }
  double repeats() const { return static_cast<double>(request_.repeats); }

  TradeoffRequest request_;
  PointSearch search_;
  std::int64_t steps_;                          ///< to the horizon
  std::int64_t measured_steps_ = 0;             ///< of a run in double precision
  std::vector<CostAndError> costs_and_errors_;  ///< of the points so far
};

}  // namespace

std::expected<std::unique_ptr<Tradeoff>, Violations> Tradeoff::prepare(TradeoffRequest request) {
  Violations wrong;
  if (request.horizon && !(std::isfinite(*request.horizon) && *request.horizon > 0))
    wrong.push_back({"horizon", to_text(*request.horizon), "must be finite and > 0"});
  if (!(std::isfinite(request.budget) && request.budget > 0))
    wrong.push_back({"budget", to_text(request.budget), "must be finite and > 0"});
  if (request.repeats < 1 || request.repeats > 100)
    wrong.push_back({"repeats", std::to_string(request.repeats), "must be 1 to 100"});
  auto found = PointSearch::prepare(request.scene, request.budget);
  if (!found)
    for (Violation& of_scene : found.error()) {
      of_scene.field.insert(0, "scene.");
      wrong.push_back(std::move(of_scene));
    }
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  return std::make_unique<Survey>(std::move(request), *std::move(found));
}

}  // namespace stiefel
