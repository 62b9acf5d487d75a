#pragma once

#include <vector>

#include "engine/simulation/accuracy/measurement.h"

namespace stiefel {

/// The motions on which methods are measured: one scene, or members of an ensemble. Their error at
/// a sample is that of the worst of them, and their work the sum of all.
class MeasuredMotions {
 public:
  /// One scene or more, of one system, shape and step.
  explicit MeasuredMotions(std::vector<Scene> scenes);

  std::size_t count() const { return scenes_.size(); }
  /// With the scene's own method, whatever it is.
  const Scene& front() const { return scenes_.front(); }
  /// Whether every motion takes the method.
  bool take(const MethodDescription& method) const;

  /// Solves the reference of each motion, which shares the budget with those after it.
  void solve_references(std::int64_t steps, const ReferenceNeed& need, const std::stop_token& stop);

  /// Of a single motion its samples. Of several: the steps that every reference reaches, answers
  /// with the largest error of the references and without a state, all references' names, the sum
  /// of their work. No samples where one motion has none; `first_price` is then that of all, if
  /// each takes what this one does.
  const Samples& samples() const { return count() == 1 ? of_each_.front() : common_; }

  /// A run of every motion with the method, one after another, until one of them stops. `weight`:
  /// the work of a step of all of them. The steps are the fewest of any; the status is the first
  /// that did not reach its end, with the member among these motions where they are several.
  Run run(const MethodDescription& method, double weight, std::int64_t to, Watch watch,
          const std::stop_token& stop, double most_work = StopScope::unlimited) const;

 private:
  void take_in(const Samples& one);

  std::vector<Scene> scenes_;
  std::vector<Samples> of_each_;
  Samples common_;
};

/// The candidates that every motion takes, each with the work of a step of all of them.
std::vector<Candidate> taken_by_all(std::vector<Candidate> candidates,
                                    const MeasuredMotions& motions);

}  // namespace stiefel
