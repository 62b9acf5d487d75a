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

/// max |Q − Q̂|, and max |M − M̂| / max |M̂| (max |M| where M̂ = 0), over the elements, of complex
/// matrices their moduli.
struct MotionError {
  std::optional<double> attitude;
  double momentum = 0;
  double largest() const { return std::max(attitude.value_or(0), momentum); }
};

/// The method chosen for a scene with a tolerance instead of a method.
struct Choice {
  MethodDescription method;
  /// The choice and its reasons: error, up to when, against which reference, at which work.
  std::string reason;
  double work = 0;  ///< units of work that the choice took

  /// The most that a choice takes: units of work, instructions, about a second.
  static constexpr double most_work = 4e9;
  /// Members of an ensemble whose references are held at a time.
  static constexpr int most_pilots = 33;
};

/// The cheapest method, order, arithmetic and substeps whose error, the largest of attitude and
/// momentum at eight times up to `horizon` and there, stays within `tolerance`, by runs of this
/// scene worth about a second: errors against a reference, work counted, never the clock. Each
/// number of substeps follows from the last by the declared order and is then run. Where whole runs
/// would cost too much, shorter ones are extrapolated by the declared growth, doubled; runs in
/// single precision are not, and are then out of the question.
///
/// Takes at most Choice::most_work. What is predicted to take more than is left of it is not run,
/// and a run that takes more than predicted is ended. Where not even the first state of the
/// reference is within it, from about N = 50 on, the choice is refused at once.
///
/// Of an ensemble the method is one for all members, and the tolerance holds in each: every member
/// is measured with it. The work is that of all members together; where it does not suffice for
/// all, some thousand bodies of a thousand steps, the choice is refused.
///
/// Expects a sound description with tolerance, horizon and step. When nothing meets the tolerance
/// the refusal has reason TOLERANCE_NOT_MET, with the best that was found, or with the price of the
/// reference. Throws Stopped (stop.h).
std::expected<Choice, Violations> choose_method(const SceneDescription& description,
                                                const Place& place = {});

/// Scene::resolve; of a description with a tolerance instead of a method, choose_method before it.
std::expected<Scene, Violations> resolve_choosing(SceneDescription description,
                                                  double largest_repair = Scene::frame_tolerance,
                                                  const Place& place = {});

/// A request for a trade-off. The scene's method is ignored. Of an ensemble a point's error and
/// drift are those of the worst member, its work and times those of all members together.
struct TradeoffRequest {
  SceneDescription scene;
  std::optional<double> horizon = {};  ///< else the scene's, else 100 steps
  double budget = default_budget;      ///< units of work; see step_weight.h
  std::int64_t repeats = 3;            ///< timed runs of each point, at most 100

  static constexpr double default_budget = 5e10;  ///< about ten seconds
  static constexpr std::int64_t default_steps = 100;
  static constexpr int most_members = 1024;  ///< of an ensemble
};

struct TradeoffSetup {
  std::string machine, build;
  std::string reference;
  double reference_error = 0;  ///< at the end of its run
  double horizon = 0;
  std::int64_t steps = 0;            ///< to the horizon
  std::int64_t reference_steps = 0;  ///< steps that the reference reached
  double budget = 0;
  int repeats = 0;
  std::size_t curves = 0;  ///< candidates, each of which gives one point or more, or is too dear
};

/// One method with its order, arithmetic, and substeps or tolerance. Errors, drift and work are
/// those at the horizon, extrapolated if the run was cut short.
struct TradeoffPoint {
  MethodDescription method;
  /// Empty where the run stopped. A part below `reference_error` is reported as `reference_error`.
  std::optional<MotionError> error;
  double drift = 0;  ///< the worst of the invariants' over the run
  std::string drift_of;
  double work = 0;
  std::vector<double> cpu_seconds_per_second;  ///< of each timed run
  double steps_per_second = 0;                 ///< the median's
  std::int64_t measured_steps = 0;
  bool extrapolated = false;
  bool below_reference = false;  ///< what was measured is not above `reference_error`
  RunStatus status;
};

/// Error against work on one scene, for each method, order and arithmetic with 1, 2, 4, ...
/// substeps, or with the tolerances 1e-3, 1e-4, ..., until the error falls no more or the point's
/// share of the budget is used up. The whole survey keeps the budget: a candidate whose first run
/// is predicted to take more than is left of it is left out. Runs in single precision whose error
/// is rounding are measured whole or left out. Points come one at a time. All results except the
/// times are the same on every machine with the same build.
class Tradeoff {
 public:
  ~Tradeoff();
  Tradeoff(Tradeoff&&) noexcept;

  /// Checks the request; moves nothing. The violations are of its fields: "scene.step", "budget".
  static std::expected<Tradeoff, Violations> prepare(TradeoffRequest request);

  /// Solves the reference with at most about half of the budget; call it first. Fails if the budget
  /// does not suffice for the first state.
  std::expected<TradeoffSetup, Violations> solve_reference(const std::stop_token& stop);

  /// The next point; nothing when there are no more, or the token asks to stop.
  std::optional<TradeoffPoint> next(const std::stop_token& stop);

  /// Indices of the points so far that no other one beats in both work and error.
  std::vector<std::size_t> front() const;

 private:
  class Survey;
  explicit Tradeoff(std::unique_ptr<Survey> survey);
  std::unique_ptr<Survey> survey_;
};

}  // namespace stiefel
