#pragma once

#include <limits>
#include <vector>

#include "engine/accuracy/reference.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Returns the number of steps to the first state at or beyond a time.
std::int64_t steps_to(double horizon, double step);

/// The states of the references with which runs are compared.
struct Samples {
  std::vector<std::int64_t> steps;               ///< ascending; include the coarse ones
  std::vector<std::vector<MotionState>> states;  ///< at each of the steps that of every motion
  std::vector<double> errors;  ///< at each of the steps the largest error of a reference
  std::string reference;       ///< the names of all references
  double work = 0;             ///< of all references together
  double all_work = 0;         ///< work of the references at every step, as far as is known
  /// Without samples: the work that the first one would take, as far as is known.
  double first_price = 0;

  std::int64_t last() const { return steps.empty() ? 0 : steps.back(); }
};

enum class Density { coarse, dense };

/// Returns the bytes of one sample of a scene.
double sample_bytes(const Scene& scene);

/// Returns the units of work of comparing one state with that of the reference.
double comparison_work(const Scene& scene);

/// Errors of at least this size are as large as the quantity itself: they do not grow any more, and
/// do not yet fall with the step.
constexpr double saturated_error = 0.1;

/// A run of one motion or several, and its errors against the references.
struct Run {
  RunStatus status;
  std::vector<MotionError> errors;  ///< at the samples that every motion reached, of the worst
  std::int64_t steps = 0;           ///< the smallest number of steps of a motion
  double work = 0;
  /// Part of the budget that was used: that of the comparisons, and `work`, or more where steps
  /// failed.
  double spent = 0;
  double cpu_seconds = 0;
  double drift = 0;
  std::string drift_of;
  std::size_t member = 0;  ///< of several motions that with the largest error

  /// Returns the largest error up to each sample, and up to the end.
  std::vector<double> course() const;
  double largest_error() const { return errors.empty() ? 0 : course().back(); }
};

enum class Watch {
  errors,                 ///< a closed form computes the compared states alone
  errors_and_invariants,  ///< every state is computed
  time,                   ///< every state is computed, none compared
};

/// How far a run goes: up to the last sample that is at most `to`, or until the token requests a
/// stop or `most_work` is used up; the run status is then `cancelled`. It ends at the first sample
/// where the error exceeds `most_error`.
struct RunBounds {
  std::int64_t to;
  Watch watch;
  std::stop_token stop = {};
  double most_work = StopScope::unlimited, most_error = infinity;
};

/// The motions on which methods are measured: one scene, or members of an ensemble. The error at a
/// sample is that of the worst motion, and the work is the sum over all motions.
class MeasuredMotions {
 public:
  /// Takes one scene or more, of one system, shape and step.
  explicit MeasuredMotions(std::vector<Scene> scenes) : scenes_(std::move(scenes)) {}

  std::size_t count() const { return scenes_.size(); }
  /// Returns the first scene, with its own method.
  const Scene& front() const { return scenes_.front(); }
  /// Whether every motion takes the method.
  bool take(const MethodDescription& method) const;

  /// Computes samples as far towards `steps` as the references get, each with an equal share of the
  /// budget. Coarse ones, with which a run over a part can be compared, are at eight equal
  /// distances, and at the half, the quarter, ... of the horizon. Dense samples are all steps,
  /// where these take at most the budget and Choice::most_sample_bytes; else they take at most a
  /// quarter of the budget, and are the coarse ones and up to 512 more, one at a pseudo-random
  /// place in each of as many equal parts of the horizon, so that no period of the motion hides an
  /// error from them. There are no samples where one motion has none; `first_price` is then the
  /// price for all motions, if each takes what this one does. Without a reference `reference` is
  /// empty.
  void solve_references(std::int64_t steps, Density density, const ReferenceNeed& need,
                        const std::stop_token& stop);
  const Samples& samples() const { return samples_; }

  /// Runs every motion with the method, one after another, until one of them stops; motion `first`
  /// before the others. `weight` is the work of a step of all motions. The status is that of the
  /// first motion that did not reach its end, with its index as member where there are several.
  /// Throws Stopped when an outer scope requires it.
  Run run(const MethodDescription& method, double weight, const RunBounds& bounds,
          std::size_t first = 0) const;

 private:
  std::vector<Scene> scenes_;
  Samples samples_;
};

}  // namespace stiefel
