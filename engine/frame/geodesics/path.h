#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <stop_token>
#include <vector>

namespace stiefel {

/// Frames Q_0, ..., Q_K, n × N each, at the times k/K.
using Path = std::vector<Eigen::MatrixXd>;

/// Returns (AAᵀ)^{-1/2}A: the frame nearest to A.
Eigen::MatrixXd polar(const Eigen::MatrixXd& A);

/// Returns N − n orthonormal rows that are orthogonal to those of Q.
Eigen::MatrixXd complement(const Eigen::MatrixXd& Q);

/// Returns d = nN − n(n+1)/2 orthonormal tangent vectors δ at Q, sym(δQᵀ) = 0, each as a column of
/// length nN, in which δ stands column by column.
Eigen::MatrixXd tangent_basis(const Eigen::MatrixXd& Q);

/// Returns the action (K/2) Σ ‖(Q_{k+1} − Q_k)Λ^{1/2}‖².
double action(const Eigen::VectorXd& lambda, const Path& path);

/// Returns the largest component of the action's gradient along the frames, divided by K λ_max.
double largest_gradient(const Eigen::VectorXd& lambda, const Path& path);

/// Returns Q̇(0) of a relaxed path, which is a trajectory of the variational step: Q̇ = S_0Λ⁻¹,
/// where S_0 = (Q_1 − Q_0)ΛK − BQ_0/2K is tangent; at n = N from M/K = UΛ − ΛUᵀ, U = Q_0ᵀQ_1.
Eigen::MatrixXd initial_velocity(const Eigen::VectorXd& lambda, const Path& path);

/// Returns the change of that velocity where the end of the path moves by `end`, to an error of the
/// order of 1/K; zero where the path is no minimum of the action.
Eigen::MatrixXd response(const Eigen::VectorXd& lambda, const Path& path,
                         const Eigen::MatrixXd& end);

/// Returns the path with 2K steps: every new midpoint is the frame nearest to the mean of its
/// neighbours.
Path refined(const Path& path);

/// Returns max |Q_k − Q'_k| over all k and all entries.
double distance(const Path& a, const Path& b);

/// Moves the inner frames to a local minimum of the action by Newton's method in tangent
/// coordinates. The Hessian is block tridiagonal: 2KΛ − sym(g_kQ_kᵀ) and −KΛ, g_k the gradient in
/// the ambient space; it is shifted by a multiple of Λ where it is not positive or the action would
/// rise. Returns false when the steps do not become smaller than `tolerance`, or on a stop request.
bool relax(const Eigen::VectorXd& lambda, Path& path, double tolerance,
           const std::stop_token& stop = {});

/// A rotation R = Z exp(W) Zᵀ of R^N, det R = 1, in plane rotations: each plane rotates two columns
/// of Z by an angle in [−π, π].
struct PlaneRotations {
  struct Plane {
    Eigen::Index first, second;
    double angle;
  };
  Eigen::MatrixXd Z;
  std::vector<Plane> planes;

  /// Takes the angles from the real Schur form of R, which is block diagonal.
  explicit PlaneRotations(const Eigen::MatrixXd& R);

  /// Returns Z exp(sW) Zᵀ.
  Eigen::MatrixXd at(double s) const;

  /// Returns ZWZᵀ, the logarithm of R with these angles.
  Eigen::MatrixXd logarithm() const;
};

/// Returns paths from Q_0 to Q_T at given times, from 0 to 1, to be relaxed, the direct one first.
///
/// n ≥ N − 1: the frames are rotations once a missing row is filled in. The paths are Q_0 exp(sW)
/// with W = log(Q_0ᵀQ_T), then W with the angle θ of one plane replaced by θ ∓ 2π, for every plane;
/// without restarts only where |θ| ≥ π/2.
/// Polar factors are not used, because their paths leave det = 1 at n = N. n < N − 1: the polar
/// factors of (1−s)Q_0 + sQ_T, bent where that matrix is nearly singular; where Λ is `wide`, also
/// the other way round, through the opposite of the middle of that path. In both cases `restarts`
/// paths through a random frame follow, whose halves are built in the same way.
std::vector<Path> starts(const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T,
                         const Eigen::VectorXd& times, int restarts, std::uint64_t seed, bool wide);

}  // namespace stiefel
