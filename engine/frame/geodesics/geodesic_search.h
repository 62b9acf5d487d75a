#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engine/frame/geodesics/found.h"
#include "engine/frame/geodesics/path.h"
#include "stiefel/connect.h"

namespace stiefel {

/// Whether Λ spreads over more than 1:10, so that the search follows paths over powers of Λ.
inline bool is_wide(const Eigen::VectorXd& lambda) {
  const double least = lambda.minCoeff();
  return least > 0 && lambda.maxCoeff() > 10 * least;
}

/// A two-point problem scaled to the time 1, with repaired frames and Λ of the order of 1.
struct Posed {
  Eigen::VectorXd lambda;
  double scale;  ///< Λ = scale · lambda, a power of 2
  Eigen::MatrixXd Q_0, Q_T;

  bool wide() const { return is_wide(lambda); }
};

/// Returns ½ Σ λ_i ‖v_i‖² of a velocity.
inline double energy(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& V) {
  return (V.cwiseAbs2() * lambda).sum() / 2;
}

/// A velocity Q̇(0) and the max |Q(1) − Q_T| of its geodesic.
struct Velocity {
  Eigen::MatrixXd V;
  double residual = std::numeric_limits<double>::infinity();
};

/// Corrects the velocity V of a path until its geodesic ends at Q_T. Each correction takes the miss
/// back by `response`, the change of the velocity that moves the end of the path. Empty where the
/// energy then exceeds the action of the path.
Velocity corrected(const Posed& p, Eigen::MatrixXd V, double action,
                   const std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>& response);

/// Paths with more than this times the least energy so far are not corrected.
inline constexpr double margin = 1.1;

/// What a search has seen.
struct ShortestSoFar {
  double least = std::numeric_limits<double>::infinity();         ///< energy
  double least_missed = std::numeric_limits<double>::infinity();  ///< action without a geodesic

  /// Takes the velocity that a path led to.
  void take(const Posed& p, const Velocity& velocity, double action, int start, Found& best);
  /// `complete`: every start has led to a minimum.
  Shortest verdict(bool complete) const;
};

/// Searches by the multipliers, every λ_i > 0: relaxes the starts (`starts`) on polynomials of
/// degree 8, of a wide Λ the direct one by way of powers Λ^s, and the further ones at 5 nodes
/// first; and corrects the velocities of the shortest paths, on halved pieces where the corrections
/// do not converge. `best`, empty at first, is the shortest so far at any time: the direct path's
/// geodesic comes first.
void by_multipliers(const Posed& p, const TwoPointProblem& problem, Found& best);

/// Searches by dense Newton steps of whole paths (`relax`), which needs no λ_i > 0 at n = N. The
/// work is O(K d³), d the degrees of freedom. `best` as above.
void by_paths(const Posed& p, const TwoPointProblem& problem, Found& best);

/// A path that a start led to.
struct RelaxedPath {
  Path path;
  double action;
  int start;
  bool settled;  ///< whether the path is a local minimum; else relaxing it took too long
};

/// Degrees of freedom up to which paths are relaxed by dense Newton steps.
inline constexpr double most_dense_degrees = 128;

/// Returns the different paths of K steps that the starts lead to, sorted by the action: by dense
/// Newton steps up to `most_dense_degrees`, and where a λ_i is not positive, else by the
/// multipliers.
std::vector<RelaxedPath> relaxed(const Posed& posed, const TwoPointProblem& problem, int K,
                                 double tolerance);

}  // namespace stiefel
