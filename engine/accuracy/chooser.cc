#include "engine/accuracy/chooser.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/catalogue/methods/step_weight.h"
#include "engine/numbers/to_text.h"

namespace stiefel {
namespace {

/// Shares of the budget for the reference: three fifths, but three quarters where its first state
/// alone takes more, or where a single method is measured.
constexpr double reference_share = 3.0 / 5, largest_reference_share = 3.0 / 4;
/// Share of what the reference leaves of the budget that the estimates of all candidates may take,
/// and share of a candidate's part of it for one run.
constexpr double estimate_share = 1.0 / 3, run_share = 1.0 / 4;
/// Most runs of a candidate for its estimate.
constexpr int most_runs = 14;
constexpr int most_substeps = 1 << 20;
/// Factor by which an extrapolated error is increased.
constexpr double safety_factor = 2;
/// A candidate that costs more than this multiple of the cheapest estimate is not estimated.
constexpr double most_over_cheapest = 4;

/// Factor by which the largest error between the compared steps is taken to exceed that at them.
double between_samples(std::size_t compared, std::int64_t steps) {
  if (static_cast<std::int64_t>(compared) == steps) return 1;
  return compared >= 128 ? 1.25 : 1.75;
}

/// Whether every state comes from the first one, so that between two samples only its rounding
/// changes: a closed form is verified at samples.
bool is_closed_form(const Candidate& candidate) {
  return candidate.order == 0 && !candidate.own_steps;
}

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

Chooser::Trial Chooser::attempt(const Candidate& candidate, const MethodDescription& method,
                                std::int64_t to) {
  const double step_work = candidate.weight * method.substeps.value_or(1);
  const Scene scene = motions_.front().with(method).value();
  const bool whole = to == steps_, closed_form = is_closed_form(candidate);
  const auto& compared = whole ? samples().steps : coarse_;
  const auto states = static_cast<double>(closed_form ? std::ssize(compared) : to);
  Trial trial{*scene.description().method};
  trial.cost = step_work * static_cast<double>(steps_);
  trial.too_expensive =
      states * step_work + static_cast<double>(compared.size()) * comparison_work() > left_;
  if (trial.too_expensive) return trial;
  const Run result = motions_.run(method, candidate.weight, compared, to, Watch::errors, {}, left_);
  left_ -= result.spent;
  allowance_ -= result.spent;
  trial.too_expensive = result.status.outcome == Outcome::cancelled;
  trial.verified = whole && !trial.too_expensive;
  trial.steps = result.steps;
  if (!result.status.reached() || result.errors.empty()) return trial;
  double error = 0;
  for (std::size_t i = 0; i < result.errors.size(); ++i) {
    const auto sample = std::ranges::lower_bound(samples().steps, compared[i]);
    const auto& answer =
        samples().answers[static_cast<std::size_t>(sample - samples().steps.begin())];
    error = std::max(error, result.errors[i].largest() + answer.error);
  }
  error *= whole ? between_samples(compared.size(), steps_)
                 : safety_factor * growth_.beyond(candidate, result, compared, steps_);
  trial.error = std::isfinite(error) ? error / tolerance_ : infinity;
  if (trial.good() && !every_step() && !closed_form) trial.verified = false;
  trial.cost = result.work * static_cast<double>(steps_) / static_cast<double>(result.steps);
  // An estimate within the tolerance does not count: a whole run decides.
  if ((trial.verified || !trial.good()) && trial.error < nearest_.error) nearest_ = trial;
  return trial;
}

Chooser::Trial Chooser::attempt_part(const Candidate& candidate, const MethodDescription& method) {
  const double step_work = candidate.weight * method.substeps.value_or(1);
  const double allowed = std::min(run_share * allowance_ + candidate.weight, left_);
  return attempt(candidate, method, affordable_steps(coarse_, step_work, allowed));
}

/// Finds the number of substeps from the order p by m ← m (error)^{1/p}: goes up until the error is
/// small enough, then down again, as long as the result can still be the cheapest.
std::optional<Chooser::Trial> Chooser::fewest_substeps(const Candidate& candidate) {
  const double p = candidate.order;
  std::optional<Trial> found;
  double failed = 0, m = 1, last_error = infinity;
  int useless_in_a_row = 0;
  for (int k = 0; k < most_runs && allowance_ > 0 && m <= most_substeps; ++k) {
    if (whole_cost(candidate, m) >= bound_) break;
    Trial trial = attempt_part(candidate, candidate.with_substeps(static_cast<int>(m)));
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
  const Trial at_once = attempt_part(candidate, candidate.with_tolerance(coarsest));
  if (at_once.good()) return at_once;
  std::optional<Trial> found;
  double epsilon = std::clamp(tolerance_, finest, coarsest), last_error = infinity;
  double last_cost = at_once.cost;
  for (int k = 0; k < most_runs && allowance_ > 0; ++k) {
    Trial trial = attempt_part(candidate, candidate.with_tolerance(epsilon));
    if (trial.too_expensive) break;
    double next = std::clamp(0.5 * epsilon / trial.error, finest, coarsest);
    if (trial.good()) {
      if (!found || trial.cost < found->cost) found = trial;
      if (next <= 2 * epsilon || trial.cost > bound_) break;
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

bool Chooser::solve_references(double share) {
  const double time = std::abs(motions_.front().time(steps_));
  for (;;) {
    motions_.solve_references(steps_, Density::dense, {time, share * budget_, false}, {});
    if (!samples().steps.empty() || samples().work > 0 || share == largest_reference_share) break;
    share = largest_reference_share;
  }
  left_ -= samples().work;
  for (const std::int64_t step : coarse_steps(steps_))
    if (std::ranges::binary_search(samples().steps, step)) coarse_.push_back(step);
  return !coarse_.empty();
}

std::optional<Chooser::Trial> Chooser::measure(const MethodDescription& method) {
  if (!solve_references(largest_reference_share) || !reaches_horizon()) return std::nullopt;
  if (!every_step() && !is_closed_form(all_.front())) return std::nullopt;
  Trial trial = attempt(all_.front(), method, steps_);
  return trial.verified ? std::optional(std::move(trial)) : std::nullopt;
}

void Chooser::estimate() {
  // Closed forms first, then the high orders: what they cost bounds what the others need to try.
  const auto rank = [](const Candidate& c) { return is_closed_form(c) ? 100 : c.order; };
  std::ranges::stable_sort(all_, [&](const Candidate& a, const Candidate& b) {
    if (rank(a) != rank(b)) return rank(a) > rank(b);
    return a.weight < b.weight;
  });
  const double before = left_, most = estimate_share * left_;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const Candidate& candidate = all_[i];
    // A sibling is the same method in cheaper arithmetic that has an estimate.
    const bool sibling = std::ranges::any_of(plans_, [&](const Plan& other) {
      return other.candidate->method.name == candidate.method.name &&
             other.candidate->order == candidate.order &&
             other.candidate->weight <= candidate.weight;
    });
    if (sibling) continue;
    growth_ = {};
    allowance_ = (most - (before - left_)) / static_cast<double>(all_.size() - i);
    const auto trial = is_closed_form(candidate) && reaches_horizon()
                           ? std::optional(attempt(candidate, candidate.method, steps_))
                       : candidate.own_steps ? loosest_tolerance(candidate)
                                             : fewest_substeps(candidate);
    if (!trial || !trial->good()) continue;
    bound_ = std::min(bound_, (trial->steps == steps_ ? 1 : most_over_cheapest) * trial->cost);
    plans_.push_back({&candidate, *trial});
  }
}

void Chooser::refine(const Plan& run) {
  const Candidate& candidate = *run.candidate;
  const Trial& trial = run.trial;
  const auto add = [&](const Candidate& of, const MethodDescription& method, double cost) {
    // An error as large as the quantity itself does not yet fall with the step.
    const bool helped =
        trial.error <= 0.8 * run.last_error || trial.error * tolerance_ > saturated_error;
    const int useless = helped ? 0 : run.useless + 1;
    if (useless < 2) plans_.push_back({&of, {method, trial.error, cost}, trial.error, useless});
  };
  if (candidate.own_steps) {
    constexpr double finest = 1e-15;
    const double epsilon = *trial.method.tolerance;
    if (trial.good() || epsilon <= finest) return;
    // A large error is not in proportion to the tolerance. The cost is at least that of this run.
    const double next = std::max(finest, epsilon * std::clamp(0.5 / trial.error, 1e-4, 0.1));
    return add(candidate, candidate.with_tolerance(next), trial.cost);
  }
  if (candidate.order == 0) return;
  const double m = trial.method.substeps.value_or(1);
  const double saturated = trial.error * tolerance_ > saturated_error ? 2 : 1;
  const double factor = std::pow(1.05 * trial.error, 1.0 / candidate.order);
  if (trial.good()) {
    const double fewer = std::ceil(m * factor);
    // Not below a number that failed.
    if (fewer < 0.9 * m && std::isinf(run.last_error))
      plans_.push_back(
          {&candidate,
           {candidate.with_substeps(static_cast<int>(fewer)), 1, whole_cost(candidate, fewer)},
           trial.error});
    return;
  }
  const double more = std::ceil(std::clamp(m * factor, std::max(m + 1, saturated * m), 16 * m));
  if (more <= most_substeps)
    add(candidate, candidate.with_substeps(static_cast<int>(more)), whole_cost(candidate, more));
  if (!std::isinf(run.last_error)) return;
  // Rounding may be what fails.
  for (const Candidate& other : all_)
    if (other.method.name == candidate.method.name && other.order == candidate.order &&
        other.weight > candidate.weight)
      plans_.push_back(
          {&other, {other.with_substeps(static_cast<int>(m)), 1, whole_cost(other, m)}});
}

std::optional<Chooser::Trial> Chooser::cheapest_verified() {
  while (!plans_.empty()) {
    stop_point();
    const auto cheapest =
        std::ranges::min_element(plans_, {}, [](const Plan& plan) { return plan.trial.cost; });
    Plan plan = std::move(*cheapest);
    plans_.erase(cheapest);
    // A run over the whole horizon that is good is verified, or compared at all there is.
    if (plan.trial.steps == steps_) return plan.trial;
    if (!tried_.insert(to_text(plan.trial.method)).second) continue;
    const Trial estimate =
        std::exchange(plan.trial, attempt(*plan.candidate, plan.trial.method, steps_));
    if (plan.trial.too_expensive) {
      too_dear_.push_back(estimate);
      continue;
    }
    refine(plan);
    if (plan.trial.good()) plans_.push_back(std::move(plan));
  }
  return std::nullopt;
}

std::optional<Chooser::Trial> Chooser::cheapest_estimate() const {
  std::vector<Trial> found = too_dear_;
  for (const Plan& plan : plans_) found.push_back(plan.trial);
  std::erase_if(found, [](const Trial& trial) { return !trial.good(); });
  const auto cheapest = std::ranges::min_element(found, {}, &Trial::cost);
  return cheapest == found.end() ? std::nullopt : std::optional(*cheapest);
}

std::expected<Chooser::Trial, Violations> Chooser::choose() {
  if (!solve_references(reference_share)) return std::unexpected(refusal());
  if (reaches_horizon() && !every_step() && !accepts_estimate())
    std::erase_if(all_, std::not_fn(is_closed_form));
  estimate();
  if (reaches_horizon())
    if (auto verified = cheapest_verified()) return *std::move(verified);
  if (accepts_estimate())
    if (auto estimate = cheapest_estimate()) return *std::move(estimate);
  return std::unexpected(refusal());
}

std::string Chooser::why_not() const {
  const std::string to = " up to t = " + to_text(*description_.horizon), name = "give a method";
  const std::string may_take = "a choice may take " + short_text(budget_) + " instructions";
  const std::string or_accept =
      "; give a method, or \"verification\": \"optional\" for the cheapest estimate";
  if (samples().reference.empty())
    return "cannot be checked: " + motions_.front().system() + " has no reference; " + name;
  if (samples().steps.empty())
    return "cannot be checked: the first state of its reference, " + samples().reference +
           ", takes " + short_text(samples().first_price) + " instructions, and " + may_take +
           "; " + name;
  if (samples().answers.back().error > tolerance_)
    return "cannot be met" + to + ": the reference, " + samples().reference + ", has an error of " +
           short_text(samples().answers.back().error) +
           ", and a method in double precision has a larger one; the motion may be chaotic";
  if (!reaches_horizon()) {
    const double part = static_cast<double>(samples().last()) / static_cast<double>(steps_);
    return "cannot be verified" + to + ": the reference, " + samples().reference +
           ", takes about " + to_text(samples().work / part, 3) + " instructions, and may take " +
           to_text(reference_share * budget_, 3) + or_accept;
  }
  if (!every_step() && !accepts_estimate() && std::isinf(nearest_.error)) {
    const auto in_MiB = [](double bytes) { return to_text(std::ceil(bytes / (1 << 20))) + " MiB"; };
    return "cannot be verified" + to + ": the reference, " + samples().reference + ", at each of " +
           std::to_string(steps_) + " steps takes about " + to_text(samples().all_work, 3) +
           " instructions and " + in_MiB(bytes_of_samples()) + ", and may take " +
           to_text(reference_share * budget_, 3) + " and " + in_MiB(Choice::most_sample_bytes) +
           or_accept;
  }
  if (const auto estimate = cheapest_estimate())
    return "cannot be verified" + to + ": the whole run of " + to_text(estimate->method) +
           ", compared at every step, takes about " + to_text(work_of_whole_run(*estimate), 3) +
           " instructions, and " + to_text(std::max(left_, 0.0), 3) + " are left of the " +
           short_text(budget_) + " that a choice may take" + or_accept;
  if (std::isfinite(nearest_.error))
    return "cannot be met" + to + ": the smallest error found is " +
           short_text(nearest_.error * tolerance_) + ", of " + to_text(nearest_.method);
  return "cannot be checked: " + may_take + ", too few to measure any method on this scene; " +
         name;
}

Violations Chooser::refusal() const {
  Violation violation = place_.violation("tolerance", to_text(tolerance_), why_not());
  violation.reason = "TOLERANCE_NOT_MET";
  violation.metadata = {{"tolerance", to_text(tolerance_)}, {"most_work", to_text(budget_)}};
  if (samples().first_price > 0)
    violation.metadata["reference_work"] = to_text(samples().first_price);
  if (std::isfinite(nearest_.error)) {
    violation.metadata["best_error"] = to_text(nearest_.error * tolerance_);
    violation.metadata["best_method"] = to_text(nearest_.method);
  }
  const auto estimate = cheapest_estimate();
  if (estimate || (reaches_horizon() && !every_step()))
    violation.metadata["verification_work"] =
        to_text(estimate ? work_of_whole_run(*estimate) : samples().all_work);
  return {violation};
}

std::string Chooser::reason(const Trial& trial) const {
  const double measured = static_cast<double>(trial.steps) * std::abs(*description_.step);
  std::string text =
      to_text(trial.method) + ": error " + short_text(trial.error * tolerance_) +
      " up to t = " + to_text(*description_.horizon) + " at " + short_text(trial.cost) +
      " instructions: " +
      (all_.size() == 1 ? "the only candidate"
                        : "the cheapest of " + std::to_string(all_.size()) + " candidates") +
      " within " + to_text(tolerance_) + "; compared with " + samples().reference + " (error " +
      short_text(samples().answers.back().error) + ")";
  if (!is_weighed(motions_.front().with(trial.method).value()))
    text += "; the work of its steps is estimated, not counted";
  if (!trial.verified && trial.steps < steps_)
    text += "; not verified: measured to t = " + to_text(measured) + " and extrapolated";
  else if (!every_step())
    text += (trial.verified ? "; compared at " : "; not verified: compared at ") +
            std::to_string(samples().steps.size()) + " of " + std::to_string(steps_) + " steps" +
            (trial.verified ? ", between which the error of a closed form is rounding" : "");
  return text;
}

}  // namespace stiefel
