#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <expected>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel {

/// The two-point problem: to find the geodesic that joins two frames in a given time, the minimum
/// of
///
///     ∫₀ᵀ E dt,   E = ½ tr(ΛQ̇ᵀQ̇),   Q(0) = Q_0, Q(T) = Q_T        [RB] (5.1), [ST] (3)–(4)
///
/// or of its discrete form, K steps of h = T/K ([RB] (6.4); [ST] (54) with differences):
///
///     Σ ½ ‖(Q_{k+1} − Q_k) Λ^{1/2}‖² / h .
struct TwoPointProblem {
  Eigen::VectorXd inertia;  ///< Λ: n < N: every λ_i > 0; n = N: λ_i + λ_j > 0 for i ≠ j
  /// β > 0, with an empty `inertia`: the metric E = ½ (β tr(AAᵀ) + tr(HHᵀ)), Q̇ = AQ + H, HQᵀ = 0
  /// (Hüper, Markina and Silva Leite 2021) in place of that of Λ. β = 1 is Λ = I, β = 1/2 the
  /// canonical metric. For 1 < n < N and β ≠ 1 no Λ has these geodesics.
  std::optional<double> beta = {};
  /// n × N with orthonormal rows to Scene::frame_tolerance; each is replaced by the nearest frame,
  /// as the Q of a scene is.
  Eigen::MatrixXd Q_0, Q_T;
  double time = 1;         ///< T > 0
  std::uint64_t seed = 1;  ///< seed of the random starts
  /// Number of paths through random frames, in addition to the direct ones, from which the search
  /// looks for shorter geodesics. With 0, a search takes four of them where a direct path leads
  /// over a saddle or Λ spans more than 1:10, unless the frames are large.
  int restarts = 0;
  std::stop_token stop = {};  ///< a stop request ends the search with Cancelled
  /// Number of operations after which the search ends with the shortest geodesic so far, as
  /// `Shortest::ended`, or with NotConverged. They are the same on every machine.
  double most_work = 1e12;
  /// What one core does, within about a factor of three.
  static constexpr double operations_per_second = 5e9;

  /// max |Q(T) − Q_T| up to which frames count as joined.
  static constexpr double joined = 1e-11;
  /// Most bytes that a search may take; `connect` refuses a K, or frames, that need more.
  static constexpr std::int64_t most_bytes = std::int64_t{512} << 20;
  /// Most steps of a path that a search relaxes by dense Newton steps in d ≤ 128 degrees of
  /// freedom: 128 to 512, such that 5 d² numbers a step take at most 84 MB.
  static constexpr int most_path_steps(double d) {
    return static_cast<int>(std::clamp(128 * 128 * 128 / std::max(d * d, 1.0), 128.0, 512.0));
  }
};

/// Tells whether the answer is the shortest of all geodesics that join the frames.
///  yes:                proved: Q_0 = Q_T; or a closed form (n = N = 2 and V(1,2), of which both
///                      ways round are compared; n = 1 or n = N with Λ = λI); or Λ = λI and
///                      ‖Q̇‖_F T ≤ π, the injectivity radius for n < N in the metric ‖Q̇‖_F
///                      (Zimmermann and Stoye 2024); or β = 1/2 and a length up to √(4/5) π
///                      (Rentmeesters 2013); or √(2E) T is at most `injectivity_bound`
///                      (conjugate_points.h).
///  no:                 a shorter path was seen whose geodesic could not be computed to `joined`;
///                      or the geodesic passes a conjugate point, beyond which none is the
///                      shortest.
///  none_shorter_found: every start led to a minimum and none of these is shorter, for Λ = λI the
///                      searches from both ends, which proves nothing about minima that no start
///                      leads to.
///  unknown:            a start did not lead to a minimum; or the discrete problem; or a metric of
///                      β without a proof.
///  ended:              `most_work` ended the search, and this is the shortest that it had found.
enum class Shortest { yes, no, none_shorter_found, unknown, ended };

/// The geodesic from Q_0 to Q_T, given by its state at time 0.
struct Geodesic {
  Eigen::MatrixXd Q;     ///< Q_0, n × N
  Eigen::MatrixXd Qdot;  ///< Q̇(0), n × N
  Eigen::MatrixXd S;  ///< Q̇(0)Λ, n × N: with Q a state of [ST] (37)–(39); empty without a Λ
  Eigen::MatrixXd M;  ///< n = N: ΛΩ + ΩΛ, Ω = QᵀQ̇, a state of [RB] (2.2), (2.3); else empty
  double energy = 0;    ///< E
  double residual = 0;  ///< max |Q(T) − Q_T| of the motion from this state
  Shortest shortest = Shortest::unknown;
  /// Number of different geodesics that the search found, each a local minimum of the action.
  int distinct = 0;
  int start = 0;  ///< index of the start that led to this geodesic; 0 is the direct path
};

/// The discrete geodesic: K steps of the variational integrator, which is the Moser–Veselov map at
/// n = N.
struct DiscreteGeodesic {
  std::vector<Eigen::MatrixXd> Q;  ///< Q_0, ..., Q_K
  Eigen::MatrixXd S;               ///< the state (Q_0, S) whose K steps of T/K are Q
  Eigen::MatrixXd M;  ///< n = N: the momentum at Q_0, hM = UΛ − ΛUᵀ, U = Q_0ᵀQ_1; else empty
  double energy = 0;  ///< the discrete action divided by T
  /// Largest gradient of the discrete action along the frames, relative to λ_max / T.
  double residual = 0;
  int distinct = 0;
  int start = 0;
};

namespace refusal {
/// A field of the problem breaks a rule.
struct Invalid {
  std::string field, value, rule;
};
/// Q_0 or Q_T is not a frame: max |QQᵀ − I| is `defect`.
struct NotOrthonormal {
  const char* field;
  double defect;
};
/// n = N: the frames lie in different components of O(N). Q_0 and Q_T hold their determinants, ±1.
struct UnequalDeterminants {
  int Q_0, Q_T;
};
/// The search found no solution. `residual` is the best max |Q(T) − Q_T|, for the discrete problem
/// the gradient; it is infinite when no path came near or the search used up `most_work`.
struct NotConverged {
  double residual;
  bool ended = false;  ///< whether `most_work` ended the search
};
/// The caller requested a stop.
struct Cancelled {};
}  // namespace refusal
using ConnectRefusal =
    std::variant<refusal::Invalid, refusal::NotOrthonormal, refusal::UnequalDeterminants,
                 refusal::NotConverged, refusal::Cancelled>;

/// Returns what `connect` refuses before it searches.
std::optional<ConnectRefusal> refusal_of(const TwoPointProblem& problem);

/// Solves the two-point problem; with K its discrete form. For Λ = λI and β, 1 < n < N, the answer
/// comes from shooting in the span of both frames, at the cost O(Nn² + n³), with `restarts` random
/// velocities; where that fails, a broken geodesic is shortened. Otherwise the search relaxes paths
/// to minima of the action by the multipliers of QQᵀ = I, at the cost O(Nn⁴ + n⁶) whatever Λ is,
/// and corrects the initial velocity of the shortest path until its geodesic ends at Q_T. At n = N
/// with a λ_i ≤ 0, for up to 128 degrees of freedom, dense Newton steps of whole paths take their
/// place; they cost O(K d³) for each start, d = nN − n(n+1)/2, as the discrete problem does up to
/// that d. Beyond, the multipliers solve it too, at the cost O(N (Kn)² n² + (Kn²)³).
std::expected<Geodesic, ConnectRefusal> connect(const TwoPointProblem& problem);
std::expected<DiscreteGeodesic, ConnectRefusal> connect(const TwoPointProblem& problem, int K);

/// The geodesic between two frames as a scene.
struct JoiningScene {
  /// Starts from Q_0: `rigid_body` where n = N, else `stiefel`; `variational`. Absent where it was
  /// not asked for, and where a metric of β has no Λ.
  std::optional<Scene> scene;
  Eigen::MatrixXd Qdot;  ///< Q̇(0); empty for the discrete problem
  double energy;
  double residual;
  Shortest shortest;
  int distinct;
  /// Q at `samples` + 1 equally spaced times; empty if `samples` is 0.
  std::vector<Eigen::MatrixXd> trajectory;
};

/// Solves the problem and returns the answer as a scene. For steps > 0 it solves the discrete form,
/// and the scene takes `steps` steps of order 2 to Q_T. Otherwise the scene's step is time /
/// max(samples, 1), its method has order 8, and h‖Q̇‖ is 0.02 with its number of substeps.
std::expected<JoiningScene, ConnectRefusal> joining_scene(const TwoPointProblem& problem, int steps,
                                                          int samples, bool with_scene = true);

}  // namespace stiefel
