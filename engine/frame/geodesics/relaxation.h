#pragma once

#include <Eigen/Core>

#include "engine/frame/geodesics/path.h"

namespace stiefel {

/// A discrete action of frames Q_k at the times t_k, k = 0, ..., K:
///
///     ½ Σ_kl S_kl tr(Q_kΛQ_lᵀ) ≈ ½ ∫₀¹ tr(ΛQ̇ᵀQ̇) dt .
struct Nodes {
  Eigen::VectorXd times, weights;  ///< K + 1 each; ∫f ≈ Σ w_k f(t_k)
  Eigen::MatrixXd stiffness;       ///< S, (K+1)²
  Eigen::MatrixXd inverse_root;    ///< S^{-1/2} of the inner nodes, (K−1)²
  Eigen::RowVectorXd start;        ///< Q̇(0) = Σ_k start_k Q_k
  Eigen::VectorXd breaks = {};     ///< ends of the pieces on which the path is a polynomial

  Eigen::Index inner() const { return times.size() - 2; }
};

/// Returns Gauss, Lobatto and Legendre's K + 1 nodes in each piece between `breaks`, which run from
/// 0 to 1: S = DᵀWD with D the derivatives of the polynomials through the Q_k, so that the error
/// falls faster than every power of 1/K where the path is smooth. A piece shares its ends with its
/// neighbours.
Nodes pieces(const Eigen::VectorXd& breaks, int K);

/// Returns K + 1 equally spaced nodes: S is that of differences, the action of K steps of the
/// variational method of order 2.
Nodes equally_spaced(int K);

/// Return the frames nearest to the polynomials of a path at other nodes, and the largest |QQᵀ − I|
/// of the polynomial of each piece half-way between its nodes, which tells how well the nodes
/// resolve the path.
Path moved(const Path& path, const Nodes& from, const Nodes& to);
Eigen::VectorXd defects(const Path& path, const Nodes& nodes);

/// The descent of a path to a local minimum of a discrete action, n ≤ N, every λ_j > 0, by the
/// multipliers alone. With q_j the column j of all inner frames, (K−1)n numbers, and Γ_k the
/// multiplier of Q_kQ_kᵀ = I, Newton's equations are
///
///     H_j δq_j + Σ_k γ_k q_jk = −ρ_j,   H_j = (1 + σ) λ_j S ⊗ I_n + blockdiag(w_k Γ_k),
///     sym(Q_k δQ_kᵀ) = 0,
///
/// ρ_j the gradient with Γ, σ the shift that makes the Hessian positive along the frames. One
/// eigenvalue problem, XᵀSX = I and XᵀΓX = D, gives every H_j⁻¹ = X ((1 + σ)λ_j + D)⁻¹ Xᵀ, and the
/// elimination of the δq_j leaves symmetric equations for the γ_k, (K−1)n(n+1)/2 numbers whatever
/// N. By Sylvester's law the Hessian is positive along the frames if and only if their matrix M = C
/// H⁻¹ Cᵀ has as many negative eigenvalues as all H_j together. With the positive eigenvalues alone
/// M is LLᵀ, so that M = L(I − YYᵀ)Lᵀ with a column of Y for each negative one, and it is positive
/// if and only if YᵀY − I is. The work is O(N (Kn)² (K + n) n + (Kn²)³).
///
/// More than `most_dense` equations are solved by conjugate gradients, an iteration at O(N (Kn)²),
/// with S ⊗ I as the preconditioner; the shift then makes every H_j positive.
class Relaxation {
 public:
  static constexpr Eigen::Index most_dense = 1500;

  Relaxation(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q_0, const Eigen::MatrixXd& Q_T,
             const Nodes& nodes);

  const Eigen::VectorXd& inertia() const { return lambda_; }
  /// Replaces Λ and keeps the path.
  void set_inertia(const Eigen::VectorXd& lambda);
  /// Starts from a path at the times of the nodes.
  void set_path(const Path& path);
  Path path() const;

  static constexpr double largest_shift = 1e6;
  /// Moves the inner frames until a step is below `tolerance`; each step is a Newton step, shifted
  /// where the Hessian is not positive or the action would rise. Returns false when that takes more
  /// than `most` steps, or a shift above `largest`.
  bool relax(double tolerance, int most = 100, double largest = largest_shift);

  double action() const { return action_; }
  /// Tells whether a step since the last call of `set_path` was shifted.
  bool shifted() const { return shifted_; }
  /// Returns Q̇(0), tangent at Q_0.
  Eigen::MatrixXd velocity() const;
  /// Returns the change of Q̇(0) that moves the end of the geodesic by `end`, to the accuracy of the
  /// discrete action.
  Eigen::MatrixXd response(const Eigen::MatrixXd& end) const;

 private:
  void measure();
  void model();
  bool solve(double shift);
  void subtract_negative(Eigen::Index negative);
  void assemble(const Eigen::MatrixXd& inverse);
  Eigen::MatrixXd step(const Eigen::MatrixXd& rho) const;
  Eigen::MatrixXd solved(const Eigen::MatrixXd& right) const;
  Eigen::VectorXd multipliers(const Eigen::VectorXd& right) const;
  void add_forces(const Eigen::VectorXd& gamma, Eigen::MatrixXd& out) const;
  Eigen::VectorXd constraint(const Eigen::Ref<const Eigen::MatrixXd>& q,
                             const Eigen::Ref<const Eigen::MatrixXd>& delta) const;
  void retract();
  auto node(Eigen::MatrixXd& q, Eigen::Index k) const { return q.middleRows(k * n_, n_); }
  auto node(const Eigen::MatrixXd& q, Eigen::Index k) const { return q.middleRows(k * n_, n_); }
  Eigen::MatrixXd tangent(Eigen::MatrixXd V) const;

  Eigen::VectorXd lambda_;
  Eigen::MatrixXd Q_0_, Q_T_;
  Nodes nodes_;
  Eigen::Index n_, N_, K_, unknowns_;  ///< K_: number of inner nodes
  Eigen::MatrixXd q_, gradient_, rho_, Gamma_, X_;
  Eigen::MatrixXd M_, Y_, capacity_;  ///< M = L(I − YYᵀ)Lᵀ; L in M_, the factor of YᵀY − I
  Eigen::VectorXd d_;
  Eigen::MatrixXd inverse_;  ///< 1/((1 + σ)λ_g + d), a column for each λ
  bool shifted_ = false;
  double action_ = 0, shift_ = 0;
};

}  // namespace stiefel
