#pragma once

#include <Eigen/Core>
#include <expected>
#include <stop_token>
#include <vector>

#include "stiefel/connect.h"
#include "stiefel/run_status.h"

namespace stiefel {

/// A geodesic of the metric tr(ΛQ̇ᵀQ̇) on V(n, N), for n = N on SO(N), with a range of times.
struct GeodesicRay {
  Eigen::VectorXd inertia;  ///< Λ: n < N: every λ_i > 0; n = N: λ_i + λ_j > 0 for i ≠ j
  Eigen::MatrixXd Q;        ///< n × N, orthonormal rows to Scene::frame_tolerance
  Eigen::MatrixXd Qdot;  ///< tangent: |Q̇Qᵀ + QQ̇ᵀ| ≤ Scene::frame_tolerance |Q̇|; is projected
  double time = 1;       ///< T > 0
  std::stop_token stop = {};
  double most_work = 1e12;  ///< operations after which the search ends at the time it has reached

  static constexpr Eigen::Index most_degrees = 128;  ///< most dimensions of V(n, N)
  static constexpr int most_points = 10'000;
};

/// A time t at which δQ̇(0) ↦ δQ(t), the differential of the exponential map, is singular.
struct ConjugatePoint {
  double time;
  int multiplicity;
  /// `multiplicity` tangent vectors δQ̇(0), n × N, orthonormal in tr(Λ·ᵀ·), whose Jacobi fields
  /// vanish at `time`.
  std::vector<Eigen::MatrixXd> kernel;
  /// How far the field nearest to vanishing, of those outside the kernel, is from it: sin θ with
  /// tan θ = |J| / (t |D_tJ|). Infinite where the kernel is all that there is.
  double gap;
};

struct FoundConjugatePoints {
  std::vector<ConjugatePoint> points;  ///< all with 0 < time ≤ min(T, until), in their order
  /// The time up to which every conjugate point is in the list: T, or less where `status` is not
  /// `reached`.
  double until = 0;
  RunStatus status;
};

/// Finds the conjugate points along a geodesic from its linearised equations. With J'' + R(t)J = 0
/// along the geodesic, J(0) = 0, the matrix J' + iωJ has a polar factor U, whose UUᵀ is unitary and
/// symmetric with the eigenvalues exp(2iθ_k). The angles θ_k pass the multiples of π, where J is
/// singular, only upwards, so that their sum counts the conjugate points with multiplicity, of even
/// multiplicity too. Steps are so short that |Δ Σθ_k| < π/2 by a bound of |R|. Times are located by
/// Newton's method on tan θ_k; those closer than `merged` times the time are one point.
std::expected<FoundConjugatePoints, ConnectRefusal> conjugate_points(const GeodesicRay& ray);

/// Returns a proven lower bound r of the injectivity radius of tr(ΛQ̇ᵀQ̇), in its lengths; 0 for
/// n = N with a λ_i ≤ 0. With λ_1 ≤ λ_2 ≤ ... ≤ λ_N,
///
///     r = π λ_1 / √λ_N (n < N),   r = π (λ_1 + λ_2) / √(2λ_N) (n = N),
///
/// which is π and √2 π for Λ = I. Q ↦ QΛ^{1/2} embeds V(n, N) in R^{nN}, where geodesics have a
/// curvature |II(v, v)| ≤ π/r: a loop is then at least 2r long (Schur), and by Gauss's equation the
/// sectional curvature is at most (π/r)², which keeps conjugate points at least r away
/// (Rauch). n = 1 has the larger π√(λ_1λ_2/λ_N), from the largest curvature of the ellipsoid, where
/// Klingenberg's theorems hold: N odd, or curvatures that are pinched by 1/4.
double injectivity_bound(const Eigen::VectorXd& inertia, Eigen::Index n);

}  // namespace stiefel
