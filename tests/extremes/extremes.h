#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel::extremes {

/// A line of the report: what was measured of a row, the bound, and the reason of the bound.
struct Record {
  std::string extreme, row, system, method;
  int order = 0;
  std::string arithmetic, precision = "double";
  std::string outcome = "REACHED";
  std::string measure;
  double value = 0, bound = 0;
  std::string why;
  double seconds = 0;
  /// Of a bound that is not met: what happens there.
  std::optional<std::string> limit = {};

  Record with(std::string what, double is, double at_most, std::string because) const {
    Record r = *this;
    r.measure = std::move(what);
    r.value = is;
    r.bound = at_most;
    r.why = std::move(because);
    return r;
  }
};

/// The bound of a measure that is only shown.
inline constexpr double no_bound = std::numeric_limits<double>::infinity();

/// Writes a record where `--long FILE` says, and expects it to hold: value ≤ bound, and where
/// there is a known limit value > bound, so that the limit is one. A relative error bounded by 1 or
/// more has passed no test: report.py counts and prints it as one without a bound.
void report(const Record& record);

/// The whole suite is run, and not its short form.
bool long_form();

/// ½ ulp of 1: what one rounding does.
inline constexpr double unit = 0x1p-53;

/// What `steps` roundings may do to a motion of condition κ: 100 κ u √steps, in plain arithmetic
/// 100 κ u steps.
double rounding_bound(const Scene& scene, std::int64_t steps, double condition);
std::string rounding_reason(const Scene& scene, double condition);

/// The scene of `system` in every hand that takes it: each method of the catalogue, of each order
/// (in the short form of its default), in both arithmetics. A discrete system as it is.
std::vector<SceneDescription> every_way(const SceneDescription& description);

/// A scene, run.
struct Trial {
  std::unique_ptr<Scene> scene;  ///< null when it was refused
  std::unique_ptr<Simulation> simulation;
  Violations refusals;
  RunStatus run_status;
  double seconds = 0;

  bool reached() const { return scene && run_status.reached(); }
  /// "REACHED", "LEFT_DOMAIN", ..., "REFUSED".
  std::string outcome() const;
  /// The refusal or the run status in words.
  std::string sentence() const;
};
Trial run(const SceneDescription& description, std::int64_t steps);

/// The record of a run, to be filled in.
Record record_of(const std::string& extreme, const std::string& row,
                 const SceneDescription& description, const Trial& run);

/// What a row is allowed to miss: the sentence for "known limits", or nothing.
using Limit = std::function<std::optional<std::string>(const SceneDescription&)>;
inline std::optional<std::string> no_limit(const SceneDescription&) { return std::nullopt; }

/// One row by every way: it must be REACHED; its state must be that of the same map in quadruple
/// precision (twin.h), its frame orthonormal, and what its method declares exact kept, all up to
/// rounding. How far that map in quadruple precision is from the exact motion is its truncation,
/// which is shown and has no bound. Methods without such a map are compared with the exact motion.
struct Row {
  std::string extreme, name;
  SceneDescription scene;  ///< without a method
  std::int64_t steps = 200;
  Limit limit = no_limit;
  double unit = 1;   ///< how much coarser than u the scene's own numbers are
  double kappa = 1;  ///< of the invariants
};
void measure(const Row& row);

}  // namespace stiefel::extremes
