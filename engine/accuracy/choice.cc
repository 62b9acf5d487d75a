// The choice of a method for a tolerance (tradeoff.h).
#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/accuracy/measured_motions.h"
#include "engine/motion/resolve.h"
#include "engine/motion/step_weight.h"
#include "engine/numbers/to_text.h"

namespace stiefel {
namespace {

/// Most work of the references, of which every member has one.
constexpr double most_of_references = 3.0 / 4 * Choice::most_work;
/// Factor by which the error of a closed form between the compared steps is taken to exceed that at
/// them, where these are not all steps.
constexpr double between_samples = 1.75;

/// A point of the trade-off.
struct Point {
  Candidate candidate;
  MethodDescription method;
  double error = infinity;  ///< largest error up to the horizon, if the run went there
  double cost = infinity;
  std::size_t member = 0;           ///< the member with the largest error
  std::vector<double> course = {};  ///< largest error up to each compared step of the run
};

/// The points of a candidate, one after the other: which is next, and what it costs at least.
struct Refinement {
  Candidate candidate;
  MethodDescription next;
  double least_cost;
  int r = 0;        ///< Candidate::refined
  int useless = 0;  ///< points in a row that were not useful
  std::optional<Point> before = {};
};

/// Whether errors are useful after those of a run with a longer step, as far as both runs went.
/// Errors as large as the quantity itself do not yet fall with the step.
bool is_useful(const std::vector<double>& before, const std::vector<double>& now) {
  const std::size_t n = std::min(before.size(), now.size());
  return n == 0 || now[n - 1] > saturated_error || now[n - 1] <= useful_ratio * before[n - 1];
}

/// Searches the cheapest point of the trade-off within a tolerance.
class Search {
 public:
  /// Computes the references. `description` has tolerance, horizon and step; it must outlive
  /// the search.
  Search(const SceneDescription& description, MeasuredScene measured)
      : description_(description),
        motions_(std::move(measured.motions)),
        candidates_(std::move(measured.candidates)),
        all_(candidates_.size()),
        tolerance_(*description.tolerance),
        steps_(steps_to(*description.horizon, *description.step)) {
    const double time = std::abs(motions_.front().time(steps_));
    motions_.solve_references(steps_, Density::dense, {time, most_of_references, false}, {});
    left_ -= samples().work;
    // Where not all steps are compared, only of a closed form the error between them is known.
    if (!every_step()) std::erase_if(candidates_, std::not_fn(&Candidate::is_closed_form));
  }

  std::expected<Choice, Violations> choose() {
    if (reaches_horizon()) measure_all();
    if (!best_ && nearest_)
      if (auto whole = measure(nearest_->candidate, nearest_->method, infinity)) nearest_ = whole;
    if (best_)
      return Choice{best_->method, tolerance_,     *description_.horizon,
                    best_->error,  reason(*best_), Choice::most_work - left_};
    Violation violation{"tolerance", to_text(tolerance_), why_not()};
    violation.reason = "TOLERANCE_NOT_MET";
    violation.metadata = {{"tolerance", to_text(tolerance_)},
                          {"most_work", to_text(Choice::most_work)}};
    if (samples().first_price > 0)
      violation.metadata["reference_work"] = to_text(samples().first_price);
    if (nearest_) {
      if (motions_.count() > 1)
        violation.value += " (member " + std::to_string(nearest_->member) + ")";
      if (std::isfinite(nearest_->error))
        violation.metadata["best_error"] = to_text(nearest_->error);
      violation.metadata["best_method"] = to_text(nearest_->method);
      violation.metadata["best_work"] = to_text(nearest_->cost);
    }
    return std::unexpected(Violations{std::move(violation)});
  }

 private:
  /// Runs a method of a candidate up to the horizon, or until its error exceeds `most_error`.
  /// Returns nullopt where what is left of the work does not suffice.
  std::optional<Point> measure(const Candidate& candidate, const MethodDescription& method,
                               double most_error) {
    const auto compared = static_cast<double>(samples().steps.size());
    const double states = candidate.is_closed_form() ? compared : static_cast<double>(steps_);
    double takes = states * candidate.weight * method.substeps.value_or(1) +
                   compared * count() * comparison_work(motions_.front());
    std::optional<Run> run;
    if (takes <= left_) {
      run = motions_.run(method, candidate.weight,
                         {samples().steps, steps_, Watch::errors, {}, left_, most_error}, hardest_);
      left_ -= run->spent;
      takes = std::max(takes, run->spent);
    }
    if (!run || run->status.outcome == Outcome::cancelled) {
      too_dear_ = std::min(too_dear_, takes);
      return std::nullopt;
    }
    Point point{candidate, *motions_.front().with(method).value().description().method};
    point.member = hardest_ = run->member;
    double largest = 0;
    for (std::size_t i = 0; i < run->errors.size(); ++i) {
      largest = std::max(largest, run->errors[i].largest() + samples().answers[i].error);
      point.course.push_back(largest);
    }
    if (run->steps > 0)
      point.cost = run->work * static_cast<double>(steps_) / static_cast<double>(run->steps);
    if (run->status.reached() && run->steps == steps_ && std::isfinite(largest))
      point.error = largest * (every_step() ? 1 : between_samples);
    return point;
  }

  /// Measures the points of all candidates, the next one with the least cost first, until all that
  /// are left cost as much as `best_`.
  void measure_all() {
    std::vector<Refinement> going;
    for (const Candidate& candidate : candidates_)
      if (Refinement at{candidate, {}, 0}; set(at, 0)) going.push_back(std::move(at));
    while (!going.empty()) {
      stop_point();
      const auto cheapest = std::ranges::min_element(going, {}, &Refinement::least_cost);
      if (best_ && cheapest->least_cost >= best_->cost) return;
      if (!measure(*cheapest)) going.erase(cheapest);
    }
  }

  /// Measures the next point of a candidate. Returns whether another one follows.
  bool measure(Refinement& at) {
    auto point = measure(at.candidate, at.next, tolerance_);
    if (!point) return false;
    if (point->error <= tolerance_) {
      if (!best_ || point->cost < best_->cost) best_ = point;
      return false;
    }
    const auto time_and_error = [](const Point& one) {
      return std::pair(one.course.size(), one.course.empty() ? 0 : -one.course.back());
    };
    if (!nearest_ || time_and_error(*point) > time_and_error(*nearest_)) nearest_ = point;
    // A tighter tolerance may not change the steps yet.
    if (!at.before || point->cost != at.before->cost) {
      const bool useful = !at.before || is_useful(at.before->course, point->course);
      at.useless = useful ? 0 : at.useless + 1;
      at.before = std::move(point);
    }
    // Between the loosest tolerance, which may make one step at once, and those a hundred times
    // larger than the one asked for, a method's own tolerance rarely suffices.
    const int skipped = at.candidate.own_steps ? static_cast<int>(-std::log10(tolerance_)) - 6 : 0;
    return at.useless < patience && set(at, at.r == 0 ? std::max(1, skipped + 1) : at.r + 1);
  }

  /// Sets the next point to `r`. Returns false if the candidate has none.
  bool set(Refinement& at, int r) const {
    const auto method = at.candidate.refined(r);
    if (!method) return false;
    at.r = r;
    at.next = *method;
    at.least_cost =
        at.candidate.weight * method->substeps.value_or(1) * static_cast<double>(steps_);
    return true;
  }

  /// Describes error, horizon, work and reference of a point.
  std::string reason(const Point& point) const {
    const std::string rank = all_ == 1                ? "the only candidate"
                             : too_dear_ < point.cost ? "the cheapest run that was made, of "
                                                      : "the cheapest of ";
    std::string text = to_text(point.method) + ": error " + short_text(point.error) +
                       " up to t = " + to_text(*description_.horizon) + " at " +
                       short_text(point.cost) + " instructions: " + rank +
                       (all_ == 1 ? "" : std::to_string(all_) + " candidates") + " within " +
                       to_text(tolerance_) + "; compared with " + samples().reference + " (error " +
                       short_text(samples().answers.back().error) + ")";
    if (!is_weighed(motions_.front().with(point.method).value()))
      text += "; the work of its steps is estimated, not counted";
    if (!every_step())
      text += "; compared at " + std::to_string(samples().steps.size()) + " of " +
              std::to_string(steps_) +
              " steps, between which the error of a closed form is rounding";
    if (description_.members)
      text += "; the largest error of " + std::to_string(motions_.count()) +
              " members, in member " + std::to_string(point.member);
    return text;
  }

  std::string why_not() const {
    const std::string to = " up to t = " + to_text(*description_.horizon);
    const std::string may_take = "that a choice may take; give a method";
    const std::string reference = "the reference, " + samples().reference + ", ";
    if (all_ == 0) return "cannot be met: no method takes all of the members; give a method";
    if (samples().reference.empty())
      return "cannot be checked: " + motions_.front().system() + " has no reference; give a method";
    if (samples().steps.empty())
      return "cannot be checked: the first state of its reference, " + samples().reference +
             ", takes " + short_text(samples().first_price) + " of the " +
             short_text(Choice::most_work) + " instructions " + may_take;
    if (const double error = samples().answers.back().error; error > tolerance_)
      return "cannot be met" + to + ": " + reference + "has an error of " + short_text(error) +
             ", and a method in double precision has a larger one; the motion may be chaotic";
    if (candidates_.empty() || !reaches_horizon()) {
      const auto in_MiB = [](double bytes) {
        return to_text(std::ceil(bytes / (1 << 20))) + " MiB";
      };
      const double part = static_cast<double>(samples().last()) / static_cast<double>(steps_),
                   work = std::max(samples().all_work, samples().work / part),
                   bytes = static_cast<double>(steps_) * count() * sample_bytes(motions_.front());
      return "cannot be verified" + to + ": " + reference + "at each of " + std::to_string(steps_) +
             " steps takes about " + to_text(work, 3) + " instructions and " + in_MiB(bytes) +
             " of the " + to_text(most_of_references, 3) + " and " +
             in_MiB(Choice::most_sample_bytes) + " " + may_take;
    }
    const std::string dear = std::isinf(too_dear_)
                                 ? "; give a method"
                                 : "; another run takes about " + to_text(too_dear_, 3) +
                                       " instructions, and " + to_text(std::max(left_, 0.0), 3) +
                                       " are left of the " + short_text(Choice::most_work) + " " +
                                       may_take;
    if (!nearest_) return "cannot be met" + to + ": no run was measured up to there" + dear;
    return "cannot be met" + to + ": the nearest, " + to_text(nearest_->method) + " at " +
           short_text(nearest_->cost) + " instructions, " +
           (std::isfinite(nearest_->error) ? "has an error of " + short_text(nearest_->error)
                                           : "does not keep it") +
           dear;
  }

  const Samples& samples() const { return motions_.samples(); }
  bool every_step() const { return std::ssize(samples().steps) == steps_; }
  bool reaches_horizon() const { return samples().last() == steps_; }
  double count() const { return static_cast<double>(motions_.count()); }

  const SceneDescription& description_;
  MeasuredMotions motions_;
  std::vector<Candidate> candidates_;
  std::size_t all_;  ///< number of candidates before those were left out that cannot be verified
  double tolerance_;
  std::int64_t steps_;
  double left_ = Choice::most_work;
  std::optional<Point> best_;     ///< the cheapest point within the tolerance
  std::optional<Point> nearest_;  ///< the point that is within the tolerance for the longest time
  std::size_t hardest_ = 0;       ///< the member with the largest error so far
  double too_dear_ = infinity;    ///< least work of a run that was not made
};

}  // namespace

std::expected<Choice, Violations> choose_method(const SceneDescription& description) {
  auto measured = what_is_measured(description);
  if (!measured) return std::unexpected(std::move(measured.error()));
  return Search(description, *std::move(measured)).choose();
}

std::expected<ChosenScene, Violations> resolve_choosing(SceneDescription description,
                                                        double largest_repair) {
  std::optional<Choice> choice;
  if (wants_choice(description)) {
    Violations wrong = check_before_choice(description, largest_repair);
    if (!wrong.empty()) return std::unexpected(std::move(wrong));
    auto chosen = choose_method(description);
    if (!chosen) return std::unexpected(std::move(chosen.error()));
    choice = *std::move(chosen);
    description.method = choice->method;
    description.tolerance.reset();
  }
  auto scene = resolve_recommending(std::move(description), largest_repair);
  if (!scene) return std::unexpected(std::move(scene.error()));
  return ChosenScene{*std::move(scene), std::move(choice)};
}

}  // namespace stiefel
