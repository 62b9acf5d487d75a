#pragma once

#include "engine/simulation/accuracy/reference.h"
#include "tests/extremes/extremes.h"

namespace stiefel::extremes {

/// Many small motions combined into one large motion with full matrices. `copies` scenes of
/// rigid_body or stiefel of one Λ, block beside block, are one motion of Λ repeated; a rotation T
/// that mixes axes of equal λ only, Q ← QT, M ← TᵀMT, fills every block, and every map that is a
/// method's is that of the small ones. A scene with thousands of axes then has an exact reference.
class SideBySide {
 public:
  /// The scenes alternate between the given ones, which differ in their initial state only.
  SideBySide(std::vector<SceneDescription> small, int copies);

  const SceneDescription& large() const { return large_; }

  /// The state of the large motion when the k-th kind of small motion is at states[k].
  MotionState assembled(const std::vector<MotionState>& states) const;

 private:
  Matrix<long double> beside(const std::vector<Matrix<long double>>& blocks) const;

  std::size_t kinds_;
  int copies_;
  Matrix<long double> T_;
  SceneDescription large_;
};

}  // namespace stiefel::extremes
