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

/// A line of the report: the measured value of a row, its bound, and the reason of the bound.
struct Record {
  std::string extreme, row, system, method;
  int order = 0;
  std::string arithmetic, precision = "double";
  std::string outcome = "REACHED";
  std::string measure;
  double value = 0, bound = 0;
  std::string why;
  double seconds = 0;
  /// For a bound that is not met: the reason, one sentence.
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

/// The bound of a measurement that is shown and not judged.
inline constexpr double no_bound = std::numeric_limits<double>::infinity();

/// Writes a record where `--long FILE` says, and expects it to hold: value ≤ bound, and where there
/// is a known limit value > bound, so that the limit is one. A relative error with a bound of 1 or
/// more passes no test: the report counts it as one without a bound.
void report(const Record& record);

/// Whether the long form is run.
bool long_form();

/// ½ ulp of 1: the error of one rounding.
inline constexpr double unit = 0x1p-53;

/// The bound of rounding after `steps` steps of a motion of condition κ: 100 κ u √steps, in plain
/// arithmetic 100 κ u steps.
double rounding_bound(const Scene& scene, std::int64_t steps, double condition);
std::string rounding_reason(const Scene& scene, double condition);

/// The scene with every method that accepts it: each method of the catalogue in each order (in the
/// short form the default order) and in both arithmetics. A discrete system has no method.
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
  /// The refusal or the run status as a sentence.
  std::string sentence() const;
};
Trial run(const SceneDescription& description, std::int64_t steps);

/// A record with the names of a run, without its measurement.
Record record_of(const std::string& extreme, const std::string& row,
                 const SceneDescription& description, const Trial& run);

/// The reason why a row may miss its bound, for "known limits"; empty if it may not.
using Limit = std::function<std::optional<std::string>(const SceneDescription&)>;
inline std::optional<std::string> no_limit(const SceneDescription&) { return std::nullopt; }

/// One row, run with every method that accepts it. Each run must be REACHED. Up to rounding its
/// state must be that of the same map in quadruple precision (twin.h), its frame orthonormal, and
/// the invariants that its method declares exact kept. The distance of the map in quadruple
/// precision from the exact motion is the truncation, which is shown and has no bound. Methods
/// without such a map are compared with the exact motion.
struct Row {
  std::string extreme, name;
  SceneDescription scene;  ///< without a method
  std::int64_t steps = 200;
  Limit limit = no_limit;
  double unit = 1;   ///< the rounding of the scene's numbers, in units of u
  double kappa = 1;  ///< of the invariants
};
void measure(const Row& row);

}  // namespace stiefel::extremes
