#pragma once

#include <expected>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/accuracy/error_growth.h"
#include "engine/simulation/accuracy/measured_motions.h"

namespace stiefel {

/// The search for the cheapest method that keeps a tolerance in every one of some motions, by runs
/// against their references (choose_method, tradeoff.h).
class Chooser {
 public:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  /// `description` has tolerance, horizon and step; it and `place` must outlive the search.
  /// `candidates`: those that all the motions take. `budget`: the most units of work.
  Chooser(const SceneDescription& description, const Place& place, MeasuredMotions motions,
          std::vector<Candidate> candidates, double budget);

  /// A method with what was measured of it.
  struct Trial {
    MethodDescription method;
    double error = infinity;  ///< up to the horizon, in units of the tolerance
    double cost = infinity;
    std::int64_t steps = 0;
    bool too_dear = false;  ///< not run, or ended, for its work
    bool measured = false;  ///< run as far as the budget allows, whatever came of it
    bool good() const { return error <= 1; }
  };

  /// The cheapest that keeps the tolerance, or the refusal with reason TOLERANCE_NOT_MET.
  std::expected<Trial, Violations> choose();

  /// The error of one method, an entry of the first candidate, measured with all of the budget; not
  /// after `choose`. Nothing where the budget does not suffice.
  std::optional<Trial> measure(const MethodDescription& method);

  /// Error, up to when, at which work, against which reference.
  std::string reason(const Trial& trial) const;
  /// Units of work so far.
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
  Violations nothing() const;
  const Samples& samples() const { return motions_.samples(); }

  const SceneDescription& description_;
  const Place& place_;
  MeasuredMotions motions_;
  double tolerance_;
  std::int64_t steps_;
  std::vector<Candidate> all_;
  ErrorGrowth growth_;  ///< of the candidate in hand
  double budget_, left_;
  std::optional<Trial> best_;  ///< the cheapest that meets the tolerance
  Trial nearest_;              ///< of all, the one with the least error
};

}  // namespace stiefel
