#pragma once

#include <vector>

#include "engine/accuracy/measurement.h"

namespace stiefel {

/// The motions on which methods are measured: one scene, or members of an ensemble. The error at a
/// sample is that of the worst motion, and the work is the sum over all motions.
class MeasuredMotions {
 public:
  /// Takes one scene or more, of one system, shape and step.
  explicit MeasuredMotions(std::vector<Scene> scenes);

  std::size_t count() const { return scenes_.size(); }
  /// Returns the first scene, with its own method.
  const Scene& front() const { return scenes_.front(); }
  /// Whether every motion takes the method.
  bool take(const MethodDescription& method) const;

  /// Computes the reference of each motion; each may use an equal share of what is left of the
  /// budget.
  void solve_references(std::int64_t steps, Density density, const ReferenceNeed& need,
                        const std::stop_token& stop);

  /// Returns the steps that every reference reaches, answers with the largest error of the
  /// references and without a state, the names of all references, and the sum of their work. Has no
  /// samples where one motion has none; `first_price` is then the price for all motions, if each
  /// takes what this one does.
  const Samples& samples() const { return common_; }

  /// Runs every motion with the method, one after another, until one of them stops. `weight` is the
  /// work of a step of all motions. The result has the smallest number of steps of any motion, and
  /// the status of the first motion that did not reach its end, with its index as member where
  /// there are several. The run ends as well once the error of a motion exceeds `most_error`;
  /// motion `first` is run before the others.
  Run run(const MethodDescription& method, double weight, const RunBounds& bounds,
          std::size_t first = 0) const;

 private:
  void take_in(const Samples& one);

  std::vector<Scene> scenes_;
  std::vector<Samples> of_each_;
  Samples common_;
};

/// The motions of a scene, and the candidates that all of them take, each with the work of a step
/// of all motions.
struct MeasuredScene {
  MeasuredMotions motions;
  std::vector<Candidate> candidates;
};

/// Returns what is measured on a scene or ensemble, or its violations; more than
/// TradeoffRequest::most_members members are one. Ignores the method and the tolerance of the
/// description.
std::expected<MeasuredScene, Violations> what_is_measured(const SceneDescription& description);

}  // namespace stiefel
