#pragma once

#include <algorithm>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The error of a motion: attitude is max |Q − Q̂|; momentum is max |M − M̂| / max |M̂|, or max |M|
/// where M̂ = 0. The maxima are over the elements, of complex matrices over their moduli. On V(n, N)
/// Q̇Λ takes the place of M, also in scenes of P or p, of which Q̇Λ is the part that moves Q.
struct MotionError {
  std::optional<double> attitude;
  double momentum = 0;
  double largest() const { return std::max(attitude.value_or(0), momentum); }
};

/// The method chosen for a scene that has a tolerance in place of a method.
struct Choice {
  MethodDescription method;
  double tolerance;  ///< the tolerance and the horizon for which the method was chosen
  double horizon;
  double error = 0;  ///< the largest error measured up to the horizon
  /// The chosen method and why: its error, up to which time, against which reference, at which
  /// work.
  std::string reason;
  double work = 0;  ///< units of work spent on the choice

  /// Most units of work that a choice may take (instructions; about a second).
  static constexpr double most_work = 4e9;
  /// Most bytes of the reference's states at every step, of all members together.
  static constexpr double most_sample_bytes = 64 << 20;
};

/// Chooses the cheapest point of the trade-off whose error stays within `tolerance`: method, order,
/// arithmetic, and substeps (1, 2, 4, ...) or tolerance (1e-3, 1e-4, ...); cost is counted work,
/// never the clock. The error is the largest of attitude and momentum up to `horizon`, measured
/// against a reference by a run of this scene over the whole horizon, at every step, plus the
/// reference's own error.
///
/// Takes at most Choice::most_work. Does not start a run that is predicted to take more than is
/// left of it, ends a run that takes more than predicted, and ends a run whose error is too large.
/// Refuses where the reference at every step exceeds three quarters of this work or
/// Choice::most_sample_bytes: a body with N = 4 beyond some 10 000 steps of h‖Ω‖ = 0.5 or 55 000 of
/// 0.05. Between steps the error of a closed form is rounding: where not every step can be compared
/// (N = 3, some 150 000 steps), `exact` is verified at up to 550 steps and is the only candidate.
/// Refuses at once where not even the first state of the reference can be computed, from about N =
/// 50 on.
///
/// An ensemble of at most TradeoffRequest::most_members members gets one method, and the tolerance
/// holds for each member: the error of a point is that of the hardest member, which has the largest
/// one. The work is that of all members together. Every point is measured first on the member that
/// was the hardest so far; on the others only where that member's error is within the tolerance.
///
/// Expects a valid description with tolerance, horizon and step. When no point meets the tolerance,
/// the violation has the reason TOLERANCE_NOT_MET and gives the nearest point, which is within the
/// tolerance for the longest time: its method, its error up to the horizon and its work; or the
/// work that the reference needs. Throws Stopped (stop.h).
std::expected<Choice, Violations> choose_method(const SceneDescription& description);

/// A resolved scene, and the choice of its method where the description had a tolerance.
struct ChosenScene {
  Scene scene;
  std::optional<Choice> choice;
};

/// Resolves a description. If it has a tolerance in place of a method, calls choose_method first;
/// the scene then has the chosen method, and no tolerance. If it has neither, the scene gets the
/// recommended method (resolve_recommending in scene.h). Throws Stopped (stop.h).
std::expected<ChosenScene, Violations> resolve_choosing(
    SceneDescription description, double largest_repair = Scene::frame_tolerance);

/// A request for a trade-off. The scene's method is ignored. For an ensemble, a point's error and
/// drift are those of the worst member, its work and times those of all members together.
struct TradeoffRequest {
  SceneDescription scene;
  std::optional<double> horizon = {};  ///< default: that of the scene, else 100 steps
  double budget = default_budget;      ///< units of work: instructions of one thread
  std::int64_t repeats = 3;            ///< timed runs of each point, at most 100

  static constexpr double default_budget = 5e10;  ///< about ten seconds
  static constexpr std::int64_t default_steps = 100;
  static constexpr int most_members = 1024;  ///< most members of an ensemble
};

struct TradeoffSetup {
  std::string machine, build;
  std::string reference;
  double reference_error = 0;  ///< at the last step that the reference reached
  double horizon = 0;
  std::int64_t steps = 0;            ///< number of steps to the horizon
  std::int64_t reference_steps = 0;  ///< number of steps that the reference reached
  double budget = 0;
  int repeats = 0;
  /// Number of candidates; each gives one point or more, or is too expensive.
  std::size_t curves = 0;
  /// One for each method whose work is estimated, because its steps were not counted.
  std::vector<std::string> warnings = {};
};

/// One method with its order, arithmetic, and substeps or tolerance. Errors, drift and work are
/// those at the horizon, extrapolated if the run was cut short.
struct TradeoffPoint {
  MethodDescription method;
  /// Empty where the run stopped. An error below `reference_error` is reported as
  /// `reference_error`.
  std::optional<MotionError> error;
  double drift = 0;  ///< largest drift of any invariant at up to 58 steps of the run
  std::string drift_of;
  double work = 0;
  std::vector<double> cpu_seconds_per_second;  ///< one for each timed run
  double steps_per_second = 0;                 ///< of the run with the median time
  std::int64_t measured_steps = 0;
  bool extrapolated = false;
  bool below_reference = false;  ///< whether the measured error is at most `reference_error`
  RunStatus status;
};

/// Measures error against work on one scene, for each method, order and arithmetic. The number of
/// substeps is 1, 2, 4, ..., or the tolerance 1e-3, 1e-4, ..., until the error stops falling or the
/// next run is predicted to take more than is left of the budget. Points come one at a time, the
/// one with the least predicted work next. Where one run of every candidate would take more than a
/// quarter of the budget, all are over the same part of the horizon; those in single precision are
/// measured in full or left out. All results except the times are the same on every machine with
/// the same build.
class Tradeoff {
 public:
  virtual ~Tradeoff() = default;

  /// Checks the request without running anything. The violations name its fields: "scene.step",
  /// "budget".
  static std::expected<std::unique_ptr<Tradeoff>, Violations> prepare(TradeoffRequest request);

  /// Computes the reference with at most about half of the budget; call it before `next`. Fails if
  /// the budget does not suffice for the first state.
  virtual std::expected<TradeoffSetup, Violations> solve_reference(const std::stop_token& stop) = 0;

  /// Measures and returns the next point; nullopt when there are no more, or on a stop request.
  virtual std::optional<TradeoffPoint> next(const std::stop_token& stop) = 0;

  /// Returns the indices of the points so far that no other point beats in both work and error.
  virtual std::vector<std::size_t> front() const = 0;
};

}  // namespace stiefel
