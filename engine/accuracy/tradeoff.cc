#include "stiefel/tradeoff.h"

#include <algorithm>
#include <cmath>

#include "engine/accuracy/error_growth.h"
#include "engine/accuracy/measured_motions.h"
#include "engine/accuracy/pareto_front.h"
#include "engine/motion/step_weight.h"
#include "engine/numbers/to_text.h"
#include "stiefel/version.h"

namespace stiefel {
namespace {

/// Share of the budget that the reference may take.
constexpr double share_of_references = 0.5;
/// Expected number of points of a candidate, by which the rest of the budget is shared among the
/// points to come.
constexpr int expected_points = 12;
/// Smallest part of the horizon that a run must cover.
constexpr double least_part = 1.0 / 64;

/// Returns the error, but at least `known`, below which the reference cannot measure.
MotionError at_least(double known, MotionError error) {
  if (error.attitude) error.attitude = std::max(known, *error.attitude);
  error.momentum = std::max(known, error.momentum);
  return error;
}

/// Returns a warning for each method whose work is estimated.
std::vector<std::string> estimated_work(const Scene& scene,
                                        const std::vector<Candidate>& candidates) {
  std::vector<std::string> found;
  for (const Candidate& candidate : candidates) {
    const auto text = estimate_warning(scene.with(candidate.method).value());
    if (text && std::ranges::find(found, *text) == found.end()) found.push_back(*text);
  }
  return found;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

class Survey final : public Tradeoff {
 public:
  Survey(TradeoffRequest request, MeasuredScene measured)
      : request_(std::move(request)),
        motions_(std::move(measured.motions)),
        candidates_(std::move(measured.candidates)),
        left_(request_.budget) {
    if (!request_.horizon) request_.horizon = request_.scene.horizon;
    steps_ = request_.horizon ? steps_to(*request_.horizon, *request_.scene.step)
                              : TradeoffRequest::default_steps;
  }

  std::expected<TradeoffSetup, Violations> solve_reference(const std::stop_token& stop) override {
    const double time = std::abs(motions_.front().time(steps_));
    motions_.solve_references(steps_, Density::coarse,
                              {time, share_of_references * request_.budget}, stop);
    left_ -= samples().work;
    if (samples().reference.empty() && !stop.stop_requested())
      return std::unexpected(Violations{{"scene.system", motions_.front().system(),
                                         "has no reference to measure errors against"}});
    if (samples().steps.empty() && !stop.stop_requested())
      return std::unexpected(
          Violations{{"budget", to_text(request_.budget),
                      "must be larger: the first state of the reference, " + samples().reference +
                          ", takes " + short_text(samples().first_price) +
                          " instructions, and the reference may take half of the budget"}});
    TradeoffSetup setup{machine(), build_fingerprint(), samples().reference};
    setup.reference_error = reference_error();
    setup.horizon = time;
    setup.steps = steps_;
    setup.reference_steps = samples().last();
    setup.budget = request_.budget;
    setup.repeats = static_cast<int>(request_.repeats);
    setup.curves = candidates_.size();
    setup.warnings = estimated_work(motions_.front(), candidates_);
    return setup;
  }

  std::optional<TradeoffPoint> next(const std::stop_token& stop) override {
    while (candidate_ < candidates_.size() && !stop.stop_requested()) {
      const Candidate& candidate = candidates_[candidate_];
      const auto next = candidate.refined(refinement_);
      if (!next) {
        next_candidate();
        continue;
      }
      const MethodDescription& method = *next;
      const double step_work = candidate.weight * method.substeps.value_or(1);
      const Scene scene = motions_.front().with(method).value();
      // Rounding in single precision is a random walk, of which a part of a run does not tell.
      const bool whole = scene.in_float();
      const std::int64_t to =
          whole ? steps_ : affordable_steps(samples().steps, step_work, share());
      const double takes = static_cast<double>(to) * step_work;
      const bool too_short =
          whole ? samples().last() < steps_ || takes > expected_points * share()
                : refinement_ > 0 &&
                      (static_cast<double>(to) < least_part * static_cast<double>(steps_) ||
                       takes > share());
      if (too_short || takes * static_cast<double>(request_.repeats) > left_) {
        next_candidate();
        continue;
      }
      const Run first = motions_.run(
          *scene.description().method, candidate.weight,
          {samples().steps, to, Watch::errors_and_invariants, stop, std::max(left_, 0.0)});
      left_ -= first.spent;
      auto point = measure(candidate, scene, first, stop);
      if (stop.stop_requested()) return std::nullopt;
      if (point.status.outcome == Outcome::cancelled) {  // it took more work than was left
        next_candidate();
        continue;
      }
      const bool another = refine(point);
      if (!another) continue;
      costs_and_errors_.push_back(
          {point.work, point.error ? point.error->largest() : std::nan("")});
      return point;
    }
    return std::nullopt;
  }

  std::vector<std::size_t> front() const override { return pareto_front(costs_and_errors_); }

 private:
  TradeoffPoint measure(const Candidate& candidate, const Scene& scene, const Run& first,
                        const std::stop_token& stop) {
    TradeoffPoint point;
    point.method = *scene.description().method;
    point.status = first.status;
    point.measured_steps = first.steps;
    point.drift = first.drift;
    point.drift_of = first.drift_of;
    if (first.steps == 0 || point.status.outcome == Outcome::cancelled) return point;

    const double time = std::abs(scene.time(first.steps));
    point.cpu_seconds_per_second.push_back(first.cpu_seconds / time);
    for (int k = 1; k < request_.repeats && first.status.reached() && first.spent <= left_; ++k) {
      left_ -= first.spent;
      const Run again = motions_.run(*scene.description().method, candidate.weight,
                                     {samples().steps, first.steps, Watch::time, stop});
      if (again.status.outcome == Outcome::cancelled) {
        point.status = again.status;
        return point;
      }
      point.cpu_seconds_per_second.push_back(again.cpu_seconds / time);
    }
    const double seconds = median(point.cpu_seconds_per_second);
    point.steps_per_second = seconds > 0 ? 1 / (seconds * std::abs(scene.step())) : infinity;
    const double rest = static_cast<double>(steps_) / static_cast<double>(first.steps);
    point.work = first.work * rest;
    if (!first.status.reached()) return point;

    const double known = reference_error();
    point.error = at_least(known, first.errors.back());
    point.below_reference = first.errors.back().largest() <= known;
    point.extrapolated = first.steps < steps_;
    const double growth = growth_.beyond(candidate, first, samples().steps, steps_);
    if (point.extrapolated) {
      // The amplitude of an oscillating error does not grow, so its envelope is extrapolated.
      const double envelope = std::max(known, first.largest_error(first.errors.size()));
      const double factor = growth * std::min(envelope / point.error->largest(), 4.0);
      if (point.error->attitude) *point.error->attitude *= factor;
      point.error->momentum *= factor;
      if (!candidate.keeps_energy) point.drift *= rest;
    }
    return point;
  }

  const Samples& samples() const { return motions_.samples(); }
  double reference_error() const {
    return samples().answers.empty() ? 0 : samples().answers.back().error;
  }
  /// Moves on to the next substeps or tolerance. Returns true if the point differs from the last
  /// one.
  bool refine(const TradeoffPoint& point) {
    const double error = point.error ? point.error->largest() : infinity;
    // The point counts only if it differs: a tighter tolerance may not change the steps yet.
    const bool another = point.work != last_work_ || error != last_error_;
    last_work_ = point.work;
    last_error_ = error;
    // A point whose step is too long for the method does not count against shorter steps.
    const bool useful = error <= useful_ratio * best_ || error > saturated_error;
    if (another) useless_in_a_row_ = useful ? 0 : useless_in_a_row_ + 1;
    best_ = std::min(best_, error);
    ++refinement_;
    if (useless_in_a_row_ >= patience) next_candidate();
    return another;
  }

  void next_candidate() {
    ++candidate_;
    refinement_ = useless_in_a_row_ = 0;
    best_ = infinity;
    growth_ = {};
    last_work_ = last_error_ = 0;
  }

  /// Returns the share of what is left for one run.
  double share() const {
    const auto to_come = static_cast<double>(candidates_.size() - candidate_) * expected_points;
    return std::max(0.0, left_) / (to_come * static_cast<double>(request_.repeats));
  }

  TradeoffRequest request_;
  MeasuredMotions motions_;
  std::vector<Candidate> candidates_;  ///< candidates that all motions take
  std::int64_t steps_;
  double left_;                ///< what is left of the budget
  std::size_t candidate_ = 0;  ///< index of the current candidate
  int refinement_ = 0;         ///< r: substeps are 2^r, or the tolerance is 10^{−3−r}
  int useless_in_a_row_ = 0;   ///< number of points up to the last one that were not useful
  double best_ = infinity;     ///< least error of the current candidate
  ErrorGrowth growth_;         ///< for the current candidate
  double last_work_ = 0, last_error_ = 0;
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
  auto found = what_is_measured(request.scene);
  if (!found)
    for (Violation& of_scene : found.error()) {
      of_scene.field.insert(0, "scene.");
      wrong.push_back(std::move(of_scene));
    }
  if (!wrong.empty()) return std::unexpected(std::move(wrong));
  return std::make_unique<Survey>(std::move(request), *std::move(found));
}

}  // namespace stiefel
