#pragma once

#include <Eigen/Core>
#include <string>

namespace stiefel::testing {

/// A seeded free rigid body in three dimensions, of one of the kinds that closed forms find hard:
/// generic, symmetric, nearly symmetric, sphere, plate, near an axis (tilts from 1e-1 to 1e-160 and
/// both signs), on the separatrix, near it away from the axis, and steady.
struct RandomTop {
  std::string kind;
  Eigen::VectorXd lambda;
  Eigen::Matrix<double, 7, 1> x;  ///< (q; m)
  double t;                       ///< from 1e-2 to 1e3 turns, either way

  explicit RandomTop(unsigned seed);

  /// At least so many radians are turned until t, and one more.
  double one_and_angle() const;
  /// Whether Δ₂ = G² − 2E I₂ cancels to less than a sixteenth of its terms.
  bool near_separatrix() const;
};

}  // namespace stiefel::testing
