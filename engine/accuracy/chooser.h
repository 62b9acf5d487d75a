#pragma once

#include <expected>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/accuracy/error_growth.h"
#include "engine/accuracy/measured_motions.h"
#include "stiefel/tradeoff.h"

namespace stiefel {

/// Searches the cheapest method that keeps a tolerance in every one of some motions, by runs
/// against their references (choose_method, tradeoff.h).
///
/// Closed forms come first: their runs compute the compared states alone, so that measuring them
/// costs almost nothing. Short runs then estimate what each other candidate needs. In the order of
/// their cost the estimates are measured by runs over the whole horizon, compared at the samples.
/// The cheapest that is good there is compared at every step. Those that fail are refined, until
/// the cheapest one is verified.
class Chooser {
 public:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  /// `description` has tolerance, horizon and step; it and `place` must outlive the search.
  /// `candidates` are those that all the motions take. `budget` is the largest number of units of
  /// work.
  Chooser(const SceneDescription& description, const Place& place, MeasuredMotions motions,
          std::vector<Candidate> candidates, double budget);

  /// A method and what was measured of it.
  struct Trial {
    MethodDescription method;
    double error = infinity;  ///< largest error up to the horizon, in units of the tolerance
    double cost = infinity;
    std::int64_t steps = 0;
    double between = 1;          ///< factor by which `error` exceeds that at the samples
    bool too_expensive = false;  ///< not run, or ended, because it takes too much work
    /// Whether the error is known: no step of the horizon has a larger one, or one misses the
    /// tolerance.
    bool verified = false;
    bool good() const { return error <= 1; }
  };

  /// Returns the cheapest method that keeps the tolerance, or the refusal with reason
  /// TOLERANCE_NOT_MET. The trial is verified unless the description accepts an unverified choice
  /// and comparing every step takes more than the budget.
  std::expected<Trial, Violations> choose();

  /// Runs one method, an entry of the first candidate, over the whole horizon with all of the
  /// budget. Do not call it after `choose`. Returns nullopt where the budget does not suffice.
  std::optional<Trial> measure(const MethodDescription& method);

  /// Describes error, horizon, work and reference of a trial.
  std::string reason(const Trial& trial) const;
  /// Returns the units of work so far.
  double work() const { return budget_ - left_; }

 private:
  /// A candidate with substeps or a tolerance, to be verified or verified.
  struct Plan {
    const Candidate* candidate;
    Trial trial;
    double last_error = infinity;  ///< error of the last whole run of this candidate
    int useless = 0;               ///< number of refinements in a row that did not help
  };

  bool solve_references(double share);
  /// Runs a method up to `to` and compares it at the coarse steps, or at all samples if `to` is the
  /// horizon.
  Trial attempt(const Candidate& candidate, const MethodDescription& method, std::int64_t to);
  /// Runs a trial over the whole horizon and compares it at every step.
  void verify(const Candidate& candidate, Trial& trial);
  Trial attempt_part(const Candidate& candidate, const MethodDescription& method);
  std::optional<Trial> fewest_substeps(const Candidate& candidate);
  std::optional<Trial> loosest_tolerance(const Candidate& candidate);
  void estimate();
  std::optional<Trial> cheapest_verified();
  /// Adds plans for a candidate whose whole run was measured: with fewer substeps if the error is
  /// small, else with more, or in more accurate arithmetic.
  void refine(const Plan& run);
  std::optional<Trial> cheapest_estimate() const;
  bool reaches_horizon() const { return samples().last() == steps_; }
  /// What the search may still take, less what one verification takes.
  double spare() const { return left_ - (every_step_ ? verifying_ : 0); }
  double whole_cost(const Candidate& candidate, double substeps) const {
    return candidate.weight * substeps * static_cast<double>(steps_);
  }
  /// Whether a whole run is compared at every step without one that is compared at the samples
  /// before, because it takes more than the comparison.
  bool compared_at_once(const Trial& trial) const {
    return every_step_ && verifying_ > 0 && trial.cost >= verifying_;
  }
  double work_to_verify(const Trial& trial) const {
    const bool twice = trial.steps < steps_ && !compared_at_once(trial);
    return verifying_ + (twice ? 2 : 1) * trial.cost;
  }
  Violations refusal() const;
  std::string why_not() const;
  const Samples& samples() const { return motions_.samples(); }

  const SceneDescription& description_;
  const Place& place_;
  MeasuredMotions motions_;
  double tolerance_;
  std::int64_t steps_;
  std::vector<std::int64_t> coarse_;  ///< the coarse steps that the reference reached
  std::vector<Candidate> all_;
  ErrorGrowth growth_;  ///< growth for the current candidate
  double budget_, left_;
  /// Work of a reference and its comparison at every step; 0 where every step is a sample.
  double verifying_ = 0;
  /// Factor by which the largest error is taken to exceed that at the samples; no smaller than any
  /// that was measured.
  double between_ = 1.25;
  bool every_step_ = false;  ///< whether the budget suffices to compare every step
  double allowance_ = 0;     ///< what the estimate of the current candidate may still take
  double bound_ = infinity;  ///< cost from which on a candidate is not estimated
  std::vector<Plan> plans_;
  std::set<std::string> tried_;  ///< methods of which a whole run was made
  std::vector<Trial> too_dear_;  ///< estimates whose whole run takes more than the budget
  Trial nearest_;                ///< the trial with the least error
};

/// Chooses a method for an ensemble (choose_method, tradeoff.h): one method with one number of
/// substeps, whose error stays within the tolerance in every member.
///
/// The choice is made for some members, the pilots, at first for the fastest member alone: it is
/// the cheapest method that keeps the tolerance in all pilots. The method is then measured on each
/// of the other members, the fastest first. Up to four members in which it misses the tolerance
/// become pilots, and the choice is repeated, up to eight times. The method that is returned has
/// thus been measured on every member. The whole search takes at most Choice::most_work; where that
/// does not suffice to measure every member, the choice is refused.
std::expected<Choice, Violations> choose_for_members(const SceneDescription& description,
                                                     const Place& place);

}  // namespace stiefel
