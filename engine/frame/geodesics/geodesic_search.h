#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/frame/geodesics/found.h"
#include "engine/frame/geodesics/path.h"
#include "engine/frame/geodesics/relaxation.h"
#include "stiefel/connect.h"

namespace stiefel {

/// Whether Λ spreads over more than 1:10, so that the search follows paths over powers of Λ.
inline bool is_wide(const Eigen::VectorXd& lambda) {
  return lambda.maxCoeff() > 10 * lambda.minCoeff();
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

/// How much the energy of a geodesic may exceed the action of the path from which it was found.
inline constexpr double strayed = 0.02;

/// A velocity Q̇(0) and the max |Q(1) − Q_T| of its geodesic.
struct Velocity {
  Eigen::MatrixXd V;
  double residual = std::numeric_limits<double>::infinity();
};

/// Corrects the velocity of a relaxed path until its geodesic ends at Q_T. Each correction takes
/// the miss back by the linear equations of the path. Empty where its energy then exceeds the
/// action of the path.
Velocity corrected(const Posed& p, const Relaxation& relaxation);

/// Searches by the multipliers, n ≤ N and every λ_i > 0: relaxes the starts (`starts`) at 9 nodes,
/// of a wide Λ the direct one at 17, by way of powers Λ^s, and the further ones at 5 first; and
/// corrects the velocities of the shortest paths with the Taylor series of their geodesics. Where
/// the corrections do not converge, takes more nodes, then what `by_powers` finds for a wide Λ. Of
/// columns with equal λ only their span enters. `best`, empty at first, is the shortest so far at
/// any time: the direct path's geodesic comes first.
void by_multipliers(const Posed& p, const TwoPointProblem& problem, Found& best);

/// Follows a path over powers Λ^s to a wide Λ by Newton steps without shifts, from the root of Λ
/// of as many decades as Λ spreads over; at strides below 1/32 to any minimum near by. Ends where
/// that fails, or where `resolve`, which is called after each step and may replace the relaxation,
/// returns false. Returns whether the relaxation is at Λ.
bool follow_powers(const Eigen::VectorXd& lambda, std::unique_ptr<Relaxation>& relaxation,
                   const std::function<bool()>& resolve);

/// Follows the direct path over powers Λ^s to a wide Λ, n ≤ N and every λ_i > 0, on pieces of
/// polynomials that are halved wherever they do not resolve the path at this s, up to 16
/// pieces of 8 steps and `Relaxation::most_dense` equations; and corrects its velocity. Where few
/// nodes lead to paths that turn between two of them, which no geodesic does, this finds a
/// geodesic. Whether it is the shortest is unknown.
Velocity by_powers(const Posed& p, const TwoPointProblem& problem);

/// Searches by dense Newton steps of whole paths (`relax`), which needs no λ_i > 0 at n = N, and
/// corrects the velocity with the variational equation (`shoot`). The work is O(K d³), d the
/// degrees of freedom. `best` as above.
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
