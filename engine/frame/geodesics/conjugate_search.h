#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "engine/frame/geodesics/jacobi_flow.h"

namespace stiefel {

/// A point where the Jacobi fields J of unit speed, J(0) = 0, D_sJ(0) = E_i, become dependent.
struct Crossing {
  double length;
  int multiplicity;
  Eigen::MatrixXd kernel;  ///< orthonormal D_sJ(0) of the fields that vanish, nN × multiplicity
  /// sin θ of the next angle, tan θ = |J|/(s|D_sJ|), s the length; infinite if there is none.
  double gap;
};

/// Moves along a geodesic and finds every conjugate point on the way. The Lagrangian angles θ_k of
/// (A, B), tan θ = ωAB⁻¹, obey θ′ = ω cos²θ + (K/ω) sin²θ along each of their directions. With |K|
/// bounded by κ², steps h ≤ 1/(dκ) and ω = 1/(dh) keep the sum of their changes within ±1, less
/// than π/2: their values modulo π then tell how many of them have passed a multiple of π, which
/// they only pass upwards.
class ConjugateSearch {
 public:
  /// Points closer than this times their length are one point.
  static constexpr double merged = 1e-10;

  /// Starts at (Q, V), tr(ΛVᵀV) = 1.
  ConjugateSearch(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                  const Eigen::MatrixXd& V);

  /// Takes a step, at most to `limit`, and returns the crossings in it. Returns false where the
  /// geodesic cannot be continued.
  bool advance(double limit, std::vector<Crossing>& crossings);

  double length() const { return length_; }

 private:
  struct Family {
    JacobiFlow::State x;
    Eigen::MatrixXd A, B;
    Eigen::VectorXd angles;  ///< in [0, π), in ascending order
  };
  Family after(double h, double omega);
  int crossed(const Family& later) const;
  double locate(double h, double omega, int count, int index);
  Crossing crossing(double at, int multiplicity);
  void take(Family&& next, double h, double omega);

  std::unique_ptr<JacobiFlow> flow_;
  Eigen::MatrixXd E_;  ///< the basis at the start
  JacobiFlow::State x_, error_;
  Eigen::VectorXd angles_;    ///< at x_, for the ω of the step
  Eigen::MatrixXd to_start_;  ///< columns of x_ are those of the fields of E_ times this
  double length_ = 0, next_ = 0;
};

}  // namespace stiefel
