#pragma once

#include <Eigen/Core>
#include <vector>

namespace stiefel {

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

}  // namespace stiefel
