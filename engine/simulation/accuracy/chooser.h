#pragma once

#include <expected>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/accuracy/error_growth.h"
#include "engine/simulation/accuracy/measured_motions.h"

namespace stiefel {

/// Searches the cheapest method that keeps a tolerance in every one of some motions, by runs
/// against their references (choose_method, tradeoff.h).
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
    bool measured = false;       ///< run as far as the budget allows, whatever the outcome
    bool good() const { return error <= 1; }
  };

  /// Returns the cheapest method that keeps the tolerance, or the refusal with reason
  /// TOLERANCE_NOT_MET.
  std::expected<Trial, Violations> choose();

  /// Measures the error of one method, an entry of the first candidate, with all of the budget. Do
  /// not call it after `choose`. Returns nullopt where the budget does not suffice.
  std::optional<Trial> measure(const MethodDescription& method);

  /// Describes error, horizon, work and reference of a trial.
  std::string reason(const Trial& trial) const;
  /// Returns the units of work so far.
  double work() const { return budget_ - left_; }

 private:
  bool solve_references();
  Trial attempt(const Candidate& candidate, const MethodDescription& method, double allowed);
  Trial attempt(const Candidate& candidate, const MethodDescription& method);
  std::optional<Trial> fewest_substeps(const Candidate& candidate);
  std::optional<Trial> loosest_tolerance(const Candidate& candidate);
  double whole_cost(const Candidate& candidate, double substeps) const {
    return candidate.weight * substeps * static_cast<double>(steps_);
  }
  Violations refusal() const;
  const Samples& samples() const { return motions_.samples(); }

  const SceneDescription& description_;
  const Place& place_;
  MeasuredMotions motions_;
  double tolerance_;
  std::int64_t steps_;
  std::vector<Candidate> all_;
  ErrorGrowth growth_;  ///< growth for the current candidate
  double budget_, left_;
  std::optional<Trial> best_;  ///< the cheapest trial that meets the tolerance
  Trial nearest_;              ///< the trial with the least error
};

}  // namespace stiefel
