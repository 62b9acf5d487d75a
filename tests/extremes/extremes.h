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

/// A measured value, its bound, and the reason of the bound.
struct Record {
  std::string extreme, row, system, method;
  int order = 0;
  std::string arithmetic;
  std::string outcome = "REACHED";
  std::string measure;
  double value = 0, bound = 0;
  std::string why;
  double seconds = 0;
  /// For a known limit, where the bound is not met: the reason in one sentence.
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

/// The bound of a measurement that is shown but not judged.
inline constexpr double no_bound = std::numeric_limits<double>::infinity();

/// Writes a record to the file of `--long FILE` or `--short FILE`, and expects value ≤ bound or,
/// for a known limit, value > bound, so that the limit is still one. A relative error with a bound
/// of 1 or more proves nothing.
void report(const Record& record);

/// Returns whether the long form is run.
bool long_form();

/// u, half an ulp of 1: the error of one rounding.
inline constexpr double unit = 0x1p-53;

/// Returns the bound of the rounding error after `steps` steps of a motion with the condition κ:
/// 100 κ u √steps, in plain arithmetic 100 κ u steps.
double rounding_bound(const Scene& scene, std::int64_t steps, double condition);
std::string rounding_reason(const Scene& scene, double condition);

/// Returns the scene with every method that accepts it: each method of the catalogue in each order
/// (in the short form only the default order) and in both arithmetics. A discrete system gives one
/// scene without a method.
std::vector<SceneDescription> every_way(const SceneDescription& description);

/// The result of running a scene.
struct Trial {
  std::unique_ptr<Scene> scene;  ///< null when it was refused
  std::unique_ptr<Simulation> simulation;
  Violations refusals;
  RunStatus run_status;
  double seconds = 0;

  bool reached() const { return scene && run_status.reached(); }
  /// Returns "REACHED", "LEFT_DOMAIN", ..., or "REFUSED".
  std::string outcome() const;
  /// Returns the refusal or the run status as a sentence.
  std::string sentence() const;
};
Trial run(const SceneDescription& description, std::int64_t steps);

/// Returns a record with the names and the outcome of a run, without a measurement.
Record record_of(const std::string& extreme, const std::string& row,
                 const SceneDescription& description, const Trial& run);

/// Returns why a row may miss its bound; nothing if it may not.
using Limit = std::function<std::optional<std::string>(const SceneDescription&)>;
inline std::optional<std::string> no_limit(const SceneDescription&) { return std::nullopt; }

/// A scene that `measure` runs with every method that accepts it. Each run must be REACHED. Up to
/// rounding, its state must be that of the same map in quadruple precision (twin.h), its frame must
/// be orthonormal, and the invariants that its method declares exact must be kept. The distance of
/// the map in quadruple precision from the exact motion is the truncation, which is shown without a
/// bound. Methods without such a map are compared with the exact motion.
struct Row {
  std::string extreme, name;
  SceneDescription scene;  ///< without a method
  std::int64_t steps = 200;
  Limit limit = no_limit;
  double scene_rounding = 1;  ///< the rounding error of the scene's numbers, in units of u
  double kappa = 1;           ///< the condition κ of the invariants
};
void measure(const Row& row);

}  // namespace stiefel::extremes
