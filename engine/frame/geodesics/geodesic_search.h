#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/frame/geodesics/path.h"
#include "stiefel/connect.h"

namespace stiefel {

/// Returns what is wrong with Λ as a metric tr(ΛQ̇ᵀQ̇) on V(n, N), for n = N on SO(N).
std::optional<refusal::Invalid> metric_fault(const Eigen::VectorXd& inertia, Eigen::Index n,
                                             Eigen::Index N);
/// Returns "n x N" of a refusal.
inline std::string shape(const Eigen::MatrixXd& Q) {
  return std::to_string(Q.rows()) + " x " + std::to_string(Q.cols());
}

/// What the search for a geodesic found, at the time scale 1.
struct Found {
  Eigen::MatrixXd V;  ///< Q̇(0); empty where there is none to the residual `joined`
  Shortest shortest = Shortest::none_shorter_found;
  /// The number of different geodesics that were seen, and the index of the start that led to this
  /// one.
  int distinct = 0, start = 0;
  double residual = std::numeric_limits<double>::infinity();  ///< the best where V is empty
  std::optional<double> length = {};  ///< of V at Λ = I or β, where it is known
};

/// Whether Λ spreads over more than 1:10, so that the search follows paths over powers of Λ.
inline bool is_wide(const Eigen::VectorXd& lambda) {
  const double least = lambda.minCoeff();
  return least > 0 && lambda.maxCoeff() > 10 * least;
}

/// A two-point problem scaled to the time 1, with repaired frames and Λ of the order of 1.
struct Posed {
  Eigen::VectorXd lambda;
  Eigen::MatrixXd Q_0, Q_T;
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

/// Whether Λ = λI to rounding.
bool is_round(const Eigen::VectorXd& lambda);

/// Returns the shortest geodesic from Q_0 to Q_T where a closed form proves that it is the
/// shortest; else nullopt. The cases are
///
///  n = N = 2 and V(1, 2): the frames form a circle. Both ways round are compared by their lengths
///           ∫ w dφ, w² = λ_1 + λ_2 for n = 2 and λ_1 sin²φ + λ_2 cos²φ for n = 1, an incomplete
///           elliptic integral of the second kind;
///  n = 1, Λ = λI: the great circle of length atan2(|Q_T − cQ_0|, c) ≤ π, c = Q_0Q_Tᵀ. Between
///           antipodes it is one of many;
///  n = N, Λ = λI: Q_0 exp(tW), W the logarithm of Q_0ᵀQ_T whose angles are at most π. The metric
///           is invariant on both sides, so its geodesics are these curves.
std::optional<Found> closed_geodesic(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q_0,
                                     const Eigen::MatrixXd& Q_T);

/// The products Q_0Q_0ᵀ, Q_TQ_Tᵀ and Q_TQ_0ᵀ of two n × N frames. Not finite where a frame is not.
struct FrameProducts {
  Eigen::MatrixXd of_Q_0, of_Q_T, mixed;
};
FrameProducts frame_products(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T);

/// The span of two n × N frames, n < N, with the orthonormal rows [Q_0; K], n + p in all, p =
/// min(n, N − n). A matrix X of n + p rows stands for the n × N block Xᵀ[Q_0; K]. Where the frames
/// are far enough apart, K is not computed: it is L⁻¹(Q_T − CQ_0), C = Q_TQ_0ᵀ and LLᵀ the products
/// of these rows. Refers to the arguments of the constructor.
class FrameSpan {
 public:
  FrameSpan(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T, const FrameProducts& products);

  /// Returns the X of Q_T.
  const Eigen::MatrixXd& target() const { return target_; }
  /// Returns the block of X.
  Eigen::MatrixXd lifted(const Eigen::MatrixXd& X) const;

 private:
  struct Squares {
    double least, ratio;
  };
  /// Finds L of K = L⁻¹Z from the products of the rows of Z; `whole` becomes whole · L. Returns the
  /// least square of a length that a row of Z has beside the rows before it, and its ratio to the
  /// largest; 0 where the rows are dependent.
  Squares factor(const Eigen::MatrixXd& products, Eigen::MatrixXd& whole);
  bool is_implied(const FrameProducts& products);
  /// Computes K in two passes; the second one first removes what rounding left of Q_0. Returns
  /// false where its rows are nearly dependent.
  bool is_orthonormalised();

  const Eigen::MatrixXd &Q_0_, &Q_T_, &C_;
  Eigen::Index n_, p_;
  Eigen::MatrixXd K_, to_K_, target_;  ///< K = to_K_ · K_, or of Q_T − CQ_0 where K_ is empty
};

/// Finds a geodesic from Q_0 to Q_T, 1 < n < N, in the metric of β, which is 1 where there is none,
///
///     ‖Q̇‖² = β tr(AAᵀ) + tr(HHᵀ),   Q̇ = AQ + H, HQᵀ = 0
///
/// (Hüper, Markina and Silva Leite 2021; β = 1 is the Euclidean metric, Λ = I, and β = 1/2 the
/// canonical one), by shooting in the span of both frames: with K orthonormal rows that complete
/// Q_0, n + p in all, p = min(n, N − n),
///
///     Q(t)ᵀ = [Q_0; K]ᵀ exp(tW) [I; 0] e^{(1 − 2β)tA},   W = [[2βA, −Bᵀ], [B, 0]],
///     V = −A Q_0 + BᵀK
///
/// (Edelman, Arias and Smith 1998). An iteration takes the miss at t = 1 back to t = 0 by
/// projections onto the tangent spaces at t = 1, 3/4, 1/2, 1/4 and 0 and subtracts it from (A, B)
/// (Zimmermann and Hüper 2022, "p-shooting"), and Anderson's method accelerates the iterations. It
/// takes 6 to 16 of them for lengths up to 0.8 π, and its work is proportional to Nn² + (n + p)³.
///
/// Where the length is not within a proved bound of the injectivity radius, it also searches from
/// Q_T to Q_0, and where one of the two does not converge, shortens a broken geodesic: so the
/// shortest length that it finds does not depend on the order of the frames. `restarts` further
/// searches start from random velocities of `seed`. The shortest geodesic counts, which is called
/// the shortest of all where that bound says so, else unknown. The residual is the largest 2-norm
/// of a row of Q(1) − Q_T. `best`, empty at first, is the shortest so far at any time.
void round_logarithm(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T,
                     const FrameProducts& products, const TwoPointProblem& problem, Found& best);

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
/// first; and corrects the velocities of the
/// shortest paths, on halved pieces where the corrections do not converge. `best`, empty at first,
/// is the shortest so far at any time: the direct path's geodesic comes first.
void by_multipliers(const Posed& p, const TwoPointProblem& problem, Found& best);

/// Searches at n = N by dense Newton steps of whole paths (`relax`), which needs no λ_i > 0. The
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
