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
/// Closed forms come first: their runs compute the compared states alone, so verifying them costs
/// almost nothing. Short runs then estimate what each other candidate needs. The estimates are
/// verified in the order of their cost by runs over the whole horizon, and those that fail are
/// refined, until the cheapest one is verified.
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
    bool too_expensive = false;  ///< not run, or ended, because it takes too much work
    /// Whether the error is known: no step of the horizon has a larger one, or one misses the
    /// tolerance.
    bool verified = false;
    bool good() const { return error <= 1; }
  };

  /// Returns the cheapest method that keeps the tolerance, or the refusal with reason
  /// TOLERANCE_NOT_MET. The trial is verified unless the description accepts an unverified choice
  /// and comparing every step takes more than the budget or than the memory of the samples.
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
  /// Whether every step up to the horizon is a sample.
  bool every_step() const { return std::ssize(samples().steps) == steps_; }
  double comparison_work() const {
    return static_cast<double>(motions_.count()) * stiefel::comparison_work(motions_.front());
  }
  double work_of_whole_run(const Trial& trial) const {
    return trial.cost + static_cast<double>(samples().steps.size()) * comparison_work();
  }
  double bytes_of_samples() const {
    return static_cast<double>(steps_) * static_cast<double>(motions_.count()) *
           sample_bytes(motions_.front());
  }
  bool accepts_estimate() const { return description_.verification == "optional"; }
  double whole_cost(const Candidate& candidate, double substeps) const {
    return candidate.weight * substeps * static_cast<double>(steps_);
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
