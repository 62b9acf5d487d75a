#pragma once

#include <Eigen/Core>

namespace stiefel {

class Scene;

/// Functions that return how fast a motion of a system changes, for SystemEntry::rates; null where
/// nothing asks for it.
struct MotionRates {
  /// For a body in three dimensions: returns the largest of |ω| along the whole motion and of the
  /// frequency λ of Jacobi's functions. Where the moments violate the triangle inequality, both may
  /// be many times |ω| at the start. 0 at rest.
  double (*turning)(const Scene&) = nullptr;
  /// For a body in three dimensions with Λ and the vector m of M: returns the complementary
  /// parameter 1 − k² of Jacobi's functions, in which its motion is expressed: 0 on the separatrix
  /// and for a rotation about the middle axis, 1 for a symmetric body and for a rotation about
  /// another axis.
  double (*separatrix)(const Eigen::Vector3d& lambda, const Eigen::Vector3d& m) = nullptr;
};

/// Members of an ensemble whose MotionRates::separatrix is below this bound are next to the
/// separatrix. Plain arithmetic then loses more than 1e-8 in 100 rotations: the error is about
/// 1e-14 divided by the parameter.
constexpr double next_to_separatrix = 1e-5;

}  // namespace stiefel
