#pragma once

#include <Eigen/Core>
#include <string>

namespace stiefel::testing {

/// A seeded free rigid body in three dimensions, of one of the kinds that are hard for closed
/// forms: generic, symmetric, nearly symmetric, sphere, plate, near an axis (tilts from 1e-1 to
/// 1e-160 and both signs), on the separatrix, near the separatrix but away from the axis, and
/// steady.
struct RandomTop {
  std::string kind;
  Eigen::VectorXd lambda;
  Eigen::Matrix<double, 7, 1> x;  ///< (q; m)
  double t;                       ///< from 1e-2 to 1e3 turns, of either sign

  explicit RandomTop(unsigned seed);

  /// Returns 1 plus a lower bound of the angle, in radians, by which the body turns until t.
  double one_and_angle() const;
  /// Returns whether Δ₂ = G² − 2E I₂ cancels to less than a sixteenth of its terms.
  bool near_separatrix() const;
};

}  // namespace stiefel::testing
