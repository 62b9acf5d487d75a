#pragma once

#include "engine/accuracy/reference.h"
#include "tests/extremes/extremes.h"

namespace stiefel::extremes {

/// Many small motions combined into one large motion with full matrices, so that a scene with
/// thousands of axes has an exact reference. `copies` scenes of rigid_body or stiefel with the same
/// Λ, block beside block, are one motion with Λ repeated. A rotation T that mixes only axes of
/// equal λ, Q ← QT, M ← TᵀMT, fills every block. The map of every method then acts as on the small
/// motions.
class SideBySide {
 public:
  /// The small scenes alternate between those of `small`, which differ only in their initial state.
  SideBySide(std::vector<SceneDescription> small, int copies);

  const SceneDescription& large() const { return large_; }

  /// Returns the state of the large motion when the k-th kind of small motion is at states[k].
  MotionState assembled(const std::vector<MotionState>& states) const;

 private:
  Matrix<long double> beside(const std::vector<Matrix<long double>>& blocks) const;

  std::size_t kinds_;
  int copies_;
  Matrix<long double> T_;
  SceneDescription large_;
};

}  // namespace stiefel::extremes
