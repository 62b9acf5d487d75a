// The choice of a method for a tolerance (tradeoff.h).
#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/accuracy/search.h"
#include "engine/motion/resolve.h"
#include "engine/motion/step_weight.h"
#include "engine/numbers/to_text.h"

namespace stiefel {
namespace {

/// Share of the work that the references may take, of which every member has one.
constexpr double share_of_references = 3.0 / 4;
/// Factor by which the error of a closed form between the compared steps is taken to exceed that at
/// them, where these are not all steps.
constexpr double between_samples = 1.75;

/// Looks for the cheapest point of the trade-off within a tolerance.
class Chooser {
 public:
  /// Computes the references. `description` has tolerance, horizon and step; it must outlive the
  /// chooser.
  Chooser(const SceneDescription& description, PointSearch search)
      : description_(description),
        search_(std::move(search)),
        all_(search_.candidates().size()),
        tolerance_(*description.tolerance),
        steps_(steps_to(*description.horizon, *description.step)) {
    search_.solve_references(steps_, Density::dense, share_of_references, false, {});
    // Where not all steps are compared, only of a closed form the error between them is known.
    if (!every_step()) search_.leave_out(std::not_fn(&Candidate::is_closed_form));
    can_verify_ = samples().last() == steps_ && std::isfinite(search_.least_cost());
  }

  std::expected<Choice, Violations> choose() {
    if (can_verify_) look_at_points();
    if (best_)
      return Choice{best_->method, tolerance_,     *description_.horizon,
                    error(*best_), reason(*best_), Choice::most_work - search_.left()};
    if (nearest_)  // once more, up to the horizon
      if (auto whole = search_.measure(nearest_->candidate, nearest_->method, bounds()))
        nearest_ = whole;
    Violation violation{"tolerance", to_text(tolerance_), why_not()};
    violation.reason = "TOLERANCE_NOT_MET";
    violation.metadata = {{"tolerance", to_text(tolerance_)},
                          {"most_work", to_text(Choice::most_work)}};
    if (samples().first_price > 0)
      violation.metadata["reference_work"] = to_text(samples().first_price);
    if (nearest_) {
      if (motions().count() > 1)
        violation.value += " (member " + std::to_string(nearest_->run.member) + ")";
      if (std::isfinite(error(*nearest_)))
        violation.metadata["best_error"] = to_text(error(*nearest_));
      violation.metadata["best_method"] = to_text(nearest_->method);
      violation.metadata["best_work"] = to_text(nearest_->cost);
    }
    return std::unexpected(Violations{std::move(violation)});
  }

 private:
  /// Measures the points, the cheapest first, until all that are left cost as much as the best. A
  /// run ends where its error exceeds the tolerance.
  void look_at_points() {
    const auto kept = [](const Point& one) {
      return std::pair(one.run.errors.size(), -one.run.largest_error());
    };
    while (!best_ || search_.least_cost() < best_->cost) {
      auto point = search_.next(bounds(tolerance_));
      if (!point) return;
      if (error(*point) > tolerance_) {
        if (!nearest_ || kept(*point) > kept(*nearest_)) nearest_ = std::move(point);
      } else if (!best_ || point->cost < best_->cost) {
        best_ = std::move(point);
      }
    }
  }

  /// Returns the largest error up to the horizon; infinity if the run did not go there.
  double error(const Point& point) const {
    if (!point.run.status.reached() || point.run.steps < steps_) return infinity;
    const double largest = point.run.largest_error() + samples().errors.back();
    return std::isfinite(largest) ? largest * (every_step() ? 1 : between_samples) : infinity;
  }

  /// Describes error, horizon, work and reference of a point.
  std::string reason(const Point& point) const {
    const std::string rank = all_ == 1 ? "the only candidate"
                             : search_.too_dear() < point.cost
                                 ? "the cheapest run that was made, of "
                                 : "the cheapest of ";
    std::string text = to_text(point.method) + ": error " + short_text(error(point)) +
                       " up to t = " + to_text(*description_.horizon) + " at " +
                       short_text(point.cost) + " instructions: " + rank +
                       (all_ == 1 ? "" : std::to_string(all_) + " candidates") + " within " +
                       to_text(tolerance_) + "; compared with " + samples().reference + " (error " +
                       short_text(samples().errors.back()) + ")";
    if (!is_weighed(motions().front().with(point.method).value()))
      text += "; the work of its steps is estimated, not counted";
    if (!every_step())
      text += "; compared at " + std::to_string(samples().steps.size()) + " of " +
              std::to_string(steps_) +
              " steps, between which the error of a closed form is rounding";
    if (description_.members)
      text += "; the largest error of " + std::to_string(motions().count()) +
              " members, in member " + std::to_string(point.run.member);
    return text;
  }

  std::string why_not() const {
    const std::string to = " up to t = " + to_text(*description_.horizon);
    const std::string may_take = "that a choice may take; give a method";
    const std::string reference = "the reference, " + samples().reference + ", ";
    if (all_ == 0) return "cannot be met: no method takes all of the members; give a method";
    if (samples().reference.empty())
      return "cannot be checked: " + motions().front().system() +
             " has no reference; give a method";
    if (samples().steps.empty())
      return "cannot be checked: the first state of its reference, " + samples().reference +
             ", takes " + short_text(samples().first_price) + " of the " +
             short_text(Choice::most_work) + " instructions " + may_take;
    if (const double error = samples().errors.back(); error > tolerance_)
      return "cannot be met" + to + ": " + reference + "has an error of " + short_text(error) +
             ", and a method in double precision has a larger one; the motion may be chaotic";
    if (!can_verify_) {
      const auto in_MiB = [](double bytes) {
        return to_text(std::ceil(bytes / (1 << 20))) + " MiB";
      };
      const double part = static_cast<double>(samples().last()) / static_cast<double>(steps_),
                   work = std::max(samples().all_work, samples().work / part),
                   bytes = static_cast<double>(steps_) * static_cast<double>(motions().count()) *
                           sample_bytes(motions().front());
      return "cannot be verified" + to + ": " + reference + "at each of " + std::to_string(steps_) +
             " steps takes about " + to_text(work, 3) + " instructions and " + in_MiB(bytes) +
             " of the " + to_text(share_of_references * Choice::most_work, 3) + " and " +
             in_MiB(Choice::most_sample_bytes) + " " + may_take;
    }
    const std::string dear =
        std::isinf(search_.too_dear())
            ? "; give a method"
            : "; another run takes about " + to_text(search_.too_dear(), 3) +
                  " instructions, and " + to_text(std::max(search_.left(), 0.0), 3) +
                  " are left of the " + short_text(Choice::most_work) + " " + may_take;
    if (!nearest_) return "cannot be met" + to + ": no run was measured up to there" + dear;
    return "cannot be met" + to + ": the nearest, " + to_text(nearest_->method) + " at " +
           short_text(nearest_->cost) + " instructions, " +
           (std::isfinite(error(*nearest_)) ? "has an error of " + short_text(error(*nearest_))
                                            : "does not keep it") +
           dear;
  }

  RunBounds bounds(double most_error = infinity) const {
    return {steps_, Watch::errors, {}, StopScope::unlimited, most_error};
  }
  const MeasuredMotions& motions() const { return search_.motions(); }
  const Samples& samples() const { return search_.samples(); }
  bool every_step() const { return std::ssize(samples().steps) == steps_; }

  const SceneDescription& description_;
  PointSearch search_;
  std::size_t all_;  ///< number of candidates before those were left out that cannot be verified
  double tolerance_;
  std::int64_t steps_;
  bool can_verify_;               ///< whether the references reach far enough for a candidate
  std::optional<Point> best_;     ///< the cheapest point within the tolerance
  std::optional<Point> nearest_;  ///< the point that is within the tolerance for the longest time
};

}  // namespace

std::expected<Choice, Violations> choose_method(const SceneDescription& description) {
  auto search = PointSearch::prepare(description, Choice::most_work);
  if (!search) return std::unexpected(std::move(search.error()));
  return Chooser(description, *std::move(search)).choose();
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
