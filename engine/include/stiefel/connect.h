#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <expected>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel {

/// The problem to find the geodesic that joins two frames in a given time: the minimum of
///
///     ∫₀ᵀ E dt,   E = ½ tr(ΛQ̇ᵀQ̇),   Q(0) = Q_0, Q(T) = Q_T        [RB] (5.1), [ST] (3)–(4)
///
/// or of its discrete form, K steps of h = T/K ([RB] (6.4); [ST] (54) with differences):
///
///     Σ ½ ‖(Q_{k+1} − Q_k) Λ^{1/2}‖² / h .
struct TwoPointProblem {
  Eigen::VectorXd inertia;    ///< Λ: n < N: every λ_i > 0; n = N: λ_i + λ_j > 0 for i ≠ j
  Eigen::MatrixXd Q_0, Q_T;   ///< n × N with orthonormal rows, repaired up to frame_tolerance
  double time = 1;            ///< T > 0
  std::uint64_t seed = 1;     ///< of the random starts
  int restarts = 4;           ///< paths through random frames, beside the direct ones
  std::stop_token stop = {};  ///< a stop request ends the search with Cancelled
  /// Operations after which the search ends with NotConverged: about ten minutes.
  double most_work = 1e12;

  /// max |QQᵀ − I| up to which a frame is accepted.
  static constexpr double frame_tolerance = 1e-9;
  /// max |Q(T) − Q_T| up to which frames count as joined.
  static constexpr double joined = 1e-11;
  /// Bytes that the discrete problem may take: more steps than fit are refused.
  static constexpr std::int64_t most_bytes = std::int64_t{512} << 20;
};

/// Whether the answer is the shortest of all geodesics that join the frames. The search returns the
/// lowest of the minima that it found, which proves nothing about the others.
///  yes:     Q_0 = Q_T; or Λ = λI and ‖Q̇‖_F T is within the injectivity radius, π for n < N and
///           √2·π for n = N (of the metric ‖Q̇‖_F: Zimmermann and Stoye 2024); or the frames form a
///           circle, n = N = 2 or V(1,2), of which both ways round were compared.
///  no:      a shorter path was seen whose geodesic could not be computed to `joined`.
///  unknown: everything else.
enum class Shortest { yes, no, unknown };

/// The initial state of the motion from Q_0 that is at Q_T at time T.
struct Geodesic {
  Eigen::MatrixXd Q;     ///< Q_0, n × N
  Eigen::MatrixXd Qdot;  ///< Q̇(0), n × N
  Eigen::MatrixXd S;     ///< Q̇(0)Λ, n × N: with Q a state of [ST] (37)–(39)
  Eigen::MatrixXd M;  ///< n = N: ΛΩ + ΩΛ, Ω = QᵀQ̇, a state of [RB] (2.2), (2.3); else empty
  double energy = 0;    ///< E
  double residual = 0;  ///< max |Q(T) − Q_T|, of the state above
  Shortest shortest = Shortest::unknown;
  int distinct = 0;  ///< geodesics seen, local minima of the action
  int start = 0;     ///< the start that led to this one; 0 is the direct path
};

/// The discrete geodesic: K steps of the variational integrator (the Moser–Veselov map at n = N).
struct DiscreteGeodesic {
  std::vector<Eigen::MatrixXd> Q;  ///< Q_0, ..., Q_K
  Eigen::MatrixXd S;               ///< the state (Q_0, S) whose K steps of T/K are Q
  Eigen::MatrixXd M;  ///< n = N: the momentum at Q_0, hM = UΛ − ΛUᵀ, U = Q_0ᵀQ_1; else empty
  double energy = 0;    ///< the action above over T
  double residual = 0;  ///< its largest gradient along the frames, over λ_max / T
  int distinct = 0;
  int start = 0;
};

namespace refusal {
/// The problem has no meaning: which field, its value, and the rule it breaks.
struct Invalid {
  std::string field, value, rule;
};
/// Q_0 or Q_T is no frame: max |QQᵀ − I|.
struct NotOrthonormal {
  const char* field;
  double defect;
};
/// n = N: the frames lie in different components of O(N).
struct UnequalDeterminants {
  int Q_0, Q_T;
};
/// No solution was found; the best residual: max |Q(T) − Q_T|, or the gradient for the discrete
/// problem; infinite when the search took `most_work`.
struct NotConverged {
  double residual;
};
/// The caller requested a stop.
struct Cancelled {};
}  // namespace refusal
using ConnectRefusal =
    std::variant<refusal::Invalid, refusal::NotOrthonormal, refusal::UnequalDeterminants,
                 refusal::NotConverged, refusal::Cancelled>;

/// Paths from several starts are relaxed to minima of the discrete action, K is doubled, and the
/// initial velocity of the shortest is corrected until its geodesic ends at Q_T. Costs
/// O(K d³) a start, d = nN − n(n+1)/2: meant for frames of up to a few hundred numbers.
std::expected<Geodesic, ConnectRefusal> connect(const TwoPointProblem& problem);
std::expected<DiscreteGeodesic, ConnectRefusal> connect(const TwoPointProblem& problem, int K);

/// The geodesic between two frames as a scene.
struct JoiningScene {
  Scene scene;  ///< from Q_0: `rigid_body` where n = N, else `stiefel`; `variational`
  double energy;
  double residual;
  Shortest shortest;
  int distinct;
  std::vector<Eigen::MatrixXd> trajectory;  ///< Q at `samples` + 1 equal times; empty for 0
};

/// The problem's answer; for steps > 0 that of its discrete form, whose scene takes `steps` steps
/// of order 2 to Q_T. Else the scene's step is time / max(samples, 1), of order 8 with as many
/// substeps as make h‖Q̇‖ 0.02.
std::expected<JoiningScene, ConnectRefusal> joining_scene(const TwoPointProblem& problem, int steps,
                                                          int samples);

}  // namespace stiefel
