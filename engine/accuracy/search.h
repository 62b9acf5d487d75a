#pragma once

#include <functional>

#include "engine/accuracy/candidates.h"
#include "engine/accuracy/measurement.h"

namespace stiefel {

/// A point of the trade-off: a method of a candidate, and its run.
struct Point {
  Candidate candidate;
  MethodDescription method;
  Run run;
  double cost;  ///< work up to the horizon, if the run goes on as it did; 0 without a step
};

/// The points of the trade-off of a scene or an ensemble, the one with the least predicted cost
/// first, as far as a budget goes: for each candidate 1, 2, 4, ... substeps, or the tolerances
/// 1e-3, 1e-4, ..., until the error does not fall any more.
class PointSearch {
 public:
  /// Takes the candidates that all motions of a description take, or returns its violations; more
  /// than TradeoffRequest::most_members members are one. Ignores method and tolerance.
  static std::expected<PointSearch, Violations> prepare(const SceneDescription& description,
                                                        double budget);

  /// Computes the references up to the horizon with at most `share` of the budget; call it before
  /// the others.
  void solve_references(std::int64_t steps, Density density, double share, bool quadruple,
                        const std::stop_token& stop);
  void leave_out(const std::function<bool(const Candidate&)>& which);

  /// Returns a bound below the cost of the next point; infinity when there is none.
  double least_cost() const;
  /// Measures the next point. A candidate has no more points where `times` runs of its next one are
  /// predicted to take more than is left, or one took more. Returns nullopt when there are no more
  /// points, or on a stop request. Runs in single precision go up to the horizon: rounding is a
  /// random walk there, of which a part of a run does not tell.
  std::optional<Point> next(const RunBounds& bounds, double times = 1);
  /// Measures a method of a candidate, with the member first that had the largest error so far.
  /// Returns nullopt where what is left does not suffice.
  std::optional<Point> measure(const Candidate& candidate, const MethodDescription& method,
                               RunBounds bounds, double times = 1);
  /// Runs the method of a point once more.
  Run again(const Point& point, const std::stop_token& stop);

  const MeasuredMotions& motions() const { return motions_; }
  const Samples& samples() const { return motions_.samples(); }
  std::vector<Candidate> candidates() const;
  std::int64_t steps() const { return steps_; }
  double left() const { return left_; }
  /// Returns the least work of a run that was not made.
  double too_dear() const { return too_dear_; }

 private:
  /// A candidate, its next point, and what is known of those before.
  struct Curve {
    Candidate candidate;
    int r = 0;                        ///< Candidate::refined
    int useless = 0;                  ///< points in a row that were not useful
    double cost = -1;                 ///< of the last point
    std::vector<double> course = {};  ///< largest error up to each sample, of the last useful point
  };
  double least_cost(const Curve& curve) const;

  PointSearch(std::vector<Scene> scenes, double budget)
      : motions_(std::move(scenes)), left_(budget) {}

  MeasuredMotions motions_;
  std::vector<Curve> curves_;  ///< those that have a next point
  std::int64_t steps_ = 0;     ///< to the horizon
  double left_;                ///< what is left of the budget
  double too_dear_ = infinity;
  std::size_t hardest_ = 0;  ///< the member with the largest error in the last run
};

struct CostAndError {
  double cost;
  double error;
};

/// Returns the indices of the points that no other point beats in both cost and error, the cheapest
/// first. Of equal points only the first is on the front; a point whose error is NaN never is.
std::vector<std::size_t> pareto_front(const std::vector<CostAndError>& points);

}  // namespace stiefel
