#include "engine/simulation/accuracy/chooser.h"

#include <algorithm>
#include <cmath>

#include "engine/linalg/arithmetic/to_text.h"
#include "engine/simulation/catalogue/methods/step_weight.h"

namespace stiefel {
namespace {

/// Shares of the budget for the reference: a third, but three quarters where its first state alone
/// takes more than a third.
constexpr double reference_share = 1.0 / 3, largest_reference_share = 3.0 / 4;
/// Share of the budget that one run may take, and most runs of a candidate.
constexpr double run_share = 1.0 / 20;
constexpr int most_runs = 14;
constexpr int most_substeps = 1 << 20;
/// Factor by which an extrapolated error is increased.
constexpr double safety_factor = 2;
/// Smallest part of the horizon that a run must cover for its method to be accepted.
constexpr double least_part = 1.0 / 64;

}  // namespace

Chooser::Chooser(const SceneDescription& description, const Place& place, MeasuredMotions motions,
                 std::vector<Candidate> candidates, double budget)
    : description_(description),
      place_(place),
      motions_(std::move(motions)),
      tolerance_(*description.tolerance),
      steps_(steps_to(*description.horizon, *description.step)),
      all_(std::move(candidates)),
      budget_(budget),
      left_(budget) {}

Chooser::Trial Chooser::attempt(const Candidate& candidate, const MethodDescription& method) {
  return attempt(candidate, method, std::min(run_share * budget_, left_));
}

Chooser::Trial Chooser::attempt(const Candidate& candidate, const MethodDescription& method,
                                double allowed) {
  const double step_work = candidate.weight * method.substeps.value_or(1);
  const std::int64_t to = affordable_steps(samples(), step_work, allowed);
  const Scene scene = motions_.front().with(method).value();
  Trial trial{*scene.description().method};
  trial.too_expensive = static_cast<double>(to) * step_work > left_;
  // The growth of rounding errors in single precision cannot be extrapolated from a part.
  if (trial.too_expensive || (scene.in_float() && to < steps_)) return trial;
  const Run result = motions_.run(method, candidate.weight, to, Watch::errors, {}, left_);
  left_ -= result.spent;
  trial.too_expensive = result.status.outcome == Outcome::cancelled;
  trial.measured = !trial.too_expensive;
  trial.steps = result.steps;
  if (!result.status.reached() || result.errors.empty()) return trial;
  const std::size_t last = result.errors.size() - 1;
  double error = result.largest_error(last + 1) + samples().answers[last].error;
  const double growth = growth_.beyond(candidate, result, samples(), steps_);
  if (result.steps < steps_) error *= safety_factor * growth;
  trial.error = std::isfinite(error) ? error / tolerance_ : infinity;
  trial.cost = result.work * static_cast<double>(steps_) / static_cast<double>(result.steps);
  if (trial.error < nearest_.error) nearest_ = trial;
  return trial;
}

/// Finds the number of substeps from the order p by m ← m (error)^{1/p}: goes up until the error is
/// small enough, then down again, as long as the result can still be the cheapest.
std::optional<Chooser::Trial> Chooser::fewest_substeps(const Candidate& candidate) {
  const double p = candidate.order;
  std::optional<Trial> found;
  double failed = 0, m = 1, last_error = infinity;
  int useless_in_a_row = 0;
  for (int k = 0; k < most_runs && left_ > 0 && m <= most_substeps; ++k) {
    const double bound = best_ ? best_->cost : infinity;
    if (whole_cost(candidate, m) >= bound) break;
    Trial trial = attempt(candidate, candidate.with_substeps(static_cast<int>(m)));
    if (trial.too_expensive) break;
    const double predicted = m * std::pow(trial.error, 1 / p);
    if (trial.good()) {
      found = std::move(trial);
      const double fewer = std::ceil(std::max(predicted * 1.01, failed + 1));
      if (!(fewer < 0.95 * m)) break;
      m = fewer;
      continue;
    }
    failed = m;
    if (found) {  // tries a number between one that fails and one that succeeds
      const double between = std::ceil(std::sqrt(m * *found->method.substeps));
      if (!(between > m && between < 0.95 * *found->method.substeps)) break;
      m = between;
      continue;
    }
    if (std::isinf(trial.error)) {  // the step is too long for the method
      m *= 2;
      continue;
    }
    // The error is rounding: shorter steps do not help any more.
    useless_in_a_row = trial.error > 0.6 * last_error ? useless_in_a_row + 1 : 0;
    if (useless_in_a_row >= 2) break;
    last_error = trial.error;
    m = std::ceil(std::clamp(1.02 * predicted, m + 1, 16 * m));
  }
  return found;
}

/// Finds the tolerance of a method that chooses its own steps, per step of the scene. Tries the
/// loosest tolerance first, which makes one step at once: between it and the tightest one the error
/// does not always fall.
std::optional<Chooser::Trial> Chooser::loosest_tolerance(const Candidate& candidate) {
  constexpr double finest = 1e-15, coarsest = 1;
  const Trial at_once = attempt(candidate, candidate.with_tolerance(coarsest));
  if (at_once.good()) return at_once;
  std::optional<Trial> found;
  double epsilon = std::clamp(tolerance_, finest, coarsest), last_error = infinity;
  double last_cost = at_once.cost;
  for (int k = 0; k < most_runs && left_ > 0; ++k) {
    Trial trial = attempt(candidate, candidate.with_tolerance(epsilon));
    if (trial.too_expensive) break;
    double next = std::clamp(0.5 * epsilon / trial.error, finest, coarsest);
    if (trial.good()) {
      if (!found || trial.cost < found->cost) found = trial;
      if (next <= 2 * epsilon || (best_ && trial.cost > 4 * best_->cost)) break;
    } else {
      // An unchanged cost means that the tolerance did not change the steps.
      const bool same = trial.cost == last_cost;
      if (found || epsilon == finest || (!same && trial.error > 0.6 * last_error)) break;
      if (!same) last_error = trial.error;
      last_cost = trial.cost;
      next = std::max(finest, std::min(next, epsilon / 10));
    }
    epsilon = next;
  }
  return found;
}

bool Chooser::solve_references() {
  const double time = std::abs(motions_.front().time(steps_));
  for (const double share : {reference_share, largest_reference_share}) {
    motions_.solve_references(steps_, {time, share * budget_, false}, {});
    if (!samples().steps.empty() || samples().work > 0) break;
  }
  left_ -= samples().work;
  return !samples().steps.empty();
}

std::optional<Chooser::Trial> Chooser::measure(const MethodDescription& method) {
  if (!solve_references()) return std::nullopt;
  const double step_work = all_.front().weight * method.substeps.value_or(1);
  const std::int64_t to = affordable_steps(samples(), step_work, left_);
  if (static_cast<double>(to) < least_part * static_cast<double>(steps_)) return std::nullopt;
  Trial trial = attempt(all_.front(), method, left_);
  return trial.measured ? std::optional(std::move(trial)) : std::nullopt;
}

std::expected<Chooser::Trial, Violations> Chooser::choose() {
  if (!solve_references()) return std::unexpected(refusal());
  // Tries the high orders first: what they cost bounds what the other orders need to try.
  std::ranges::stable_sort(all_, [](const Candidate& a, const Candidate& b) {
    if (a.order != b.order) return a.order > b.order;
    return a.weight < b.weight;
  });
  std::vector<const Candidate*> met;
  for (const Candidate& candidate : all_) {
    // A sibling is the same method in cheaper arithmetic that has met the tolerance.
    const bool sibling = std::ranges::any_of(met, [&](const Candidate* other) {
      return other->method.name == candidate.method.name && other->order == candidate.order &&
             other->weight <= candidate.weight;
    });
    if (sibling) continue;
    growth_ = {};
    const auto trial =
        candidate.own_steps ? loosest_tolerance(candidate) : fewest_substeps(candidate);
    if (!trial) continue;
    met.push_back(&candidate);
    if (!best_ || trial->cost < best_->cost) best_ = trial;
  }
  if (!best_) return std::unexpected(refusal());
  return *best_;
}

Violations Chooser::refusal() const {
  const bool any = std::isfinite(nearest_.error);
  const double error = nearest_.error * tolerance_;
  Violation violation = place_.violation(
      "tolerance", to_text(tolerance_),
      any ? "cannot be met up to t = " + to_text(*description_.horizon) +
                ": the smallest error found is " + short_text(error) + ", of " +
                to_text(nearest_.method)
      : samples().reference.empty()
          ? "cannot be checked: " + motions_.front().system() + " has no reference; give a method"
      : samples().steps.empty()
          ? "cannot be checked: the first state of its reference, " + samples().reference +
                ", takes " + short_text(samples().first_price) +
                " instructions, and a choice may take " + short_text(budget_) + "; give a method"
          : "cannot be checked: a choice may take " + short_text(budget_) +
                " instructions, too few to measure any method on this scene; give a method");
  violation.reason = "TOLERANCE_NOT_MET";
  violation.metadata = {{"tolerance", to_text(tolerance_)}, {"most_work", to_text(budget_)}};
  if (samples().first_price > 0)
    violation.metadata["reference_work"] = to_text(samples().first_price);
  if (any) {
    violation.metadata["best_error"] = to_text(error);
    violation.metadata["best_method"] = to_text(nearest_.method);
  }
  return {violation};
}

std::string Chooser::reason(const Trial& trial) const {
  const double measured = static_cast<double>(trial.steps) * std::abs(*description_.step);
  std::string text = to_text(trial.method) + ": error " + short_text(trial.error * tolerance_) +
                     " up to t = " + to_text(*description_.horizon) + " at " +
                     short_text(trial.cost) + " instructions: the cheapest of " +
                     std::to_string(all_.size()) + " candidates within " + to_text(tolerance_) +
                     "; compared with " + samples().reference + " (error " +
                     short_text(samples().answers.back().error) + ")";
  if (!is_weighed(motions_.front().with(trial.method).value()))
    text += "; the work of its steps is estimated, not counted";
  if (trial.steps < steps_) text += ", measured to t = " + to_text(measured) + " and extrapolated";
  return text;
}

}  // namespace stiefel
