#pragma once

#include <Eigen/Dense>
#include <array>
#include <memory>

#include "engine/methods/support/matrix_system.h"
#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// Tangent vectors that continuous orthonormalisation keeps orthonormal, as a frame F on V(k, D): k
/// orthonormal rows of D numbers. With A the derivative of a vector field along a motion and C =
/// FAFᵀ in columns, W = Fᵀ:
///
///     Ẇ = AW − WT,   T_ii = C_ii,   T_ij = C_ij + C_ji (i < j),   T_ij = 0 (i > j),
///     Ḟ = F·ξ, ξ skew;   V̇ = AV for V = WR,   Ṙ = TR
///
/// (Bridges and Reich, Physica D 156 (2001) 219). `munthe_kaas4` moves F by rotations of R^D, so
/// that FFᵀ = I stays to rounding; its stages give R to the same order.
class FrameFlow {
 public:
  using Dense = Eigen::MatrixXd;

  /// The most numbers of a state: a step takes about 60 D³ operations.
  static constexpr Eigen::Index largest = 256;

  /// `weights`: the factors by which the numbers of a vector, column by column, are multiplied.
  FrameFlow(MatrixSystem<Tangent> field, Eigen::VectorXd weights, Eigen::Index k);
  ~FrameFlow();
  FrameFlow(FrameFlow&&) noexcept;
  FrameFlow& operator=(FrameFlow&&) noexcept;

  void set_weights(const Eigen::VectorXd& weights);

  /// Moves V, D × k with orthonormal weighted columns, along the states x, h apart, and returns R:
  /// with the exact tangent, x[0] → x[2] takes V to V′R.
  Dense move(Dense& V, const std::array<Dense, 3>& x, double h);

 private:
  struct Flow;
  std::unique_ptr<Flow> flow_;
};

}  // namespace stiefel
