#pragma once

#include <optional>

#include "engine/linalg/principal_moments_3.h"
#include "engine/linalg/quadruple.h"
#include "engine/simulation/reference.h"

namespace stiefel {

/// A rigid body at step 0 in quadruple precision, as its scene means it: (Q, M) of `rigid_body`
/// from the numbers that the scene was given by, rounded to 113 bits instead of 53.
///
///     right                 Qᵀ, −M                        [RB] Prop. 2.1
///     symmetric             M = (QᵀP − PᵀQ)/ε              Ψ
///     reduced               M = Qᵀ(PQᵀ − QPᵀ)Q/ε           [RB] (8.2)
///     McLachlan–Scovel      M = QᵀB                        [RB] (5.5)
///     body                  M = hat(Rᵀ I ω), Q = Q(q) R    I = R diag(moments) Rᵀ
struct RigidStart {
  Vector<Quad> lambda;                              ///< N
  std::optional<PrincipalMoments3<Quad>> moments;   ///< where N = 3
  Matrix<Quad> Q, M;                                ///< N × N; no Q in a momentum-only scene
  Matrix<Quad> axes;                                ///< R, or 0 × 0: Q_caller = Q Rᵀ
  bool right = false;

  /// The scene's own variables and axes of a state (Q, M).
  MotionState presented(Matrix<long double> Q, Matrix<long double> M) const;
};

/// Nothing for what is no rigid body, and for what GL(N) acts on.
std::optional<RigidStart> rigid_start(const Scene& scene);

}  // namespace stiefel
