#pragma once

#include "engine/linalg/arithmetic/quadruple.h"
#include "engine/linalg/arithmetic/scalar.h"
#include "stiefel/scene.h"

namespace stiefel {

/// How a scene reports a motion that a reference has in variables of its own.
template <class Scalar>
struct Presentation {
  bool right = false;            ///< Qᵀ and −M, [RB] Prop. 2.1
  bool complex = false;          ///< each block is its real part over its imaginary one
  Vector<Scalar> diagonal = {};  ///< μΛ², which M_μ = M + μΛ² has more than M
  Matrix<Scalar> axes = {};      ///< R of a body: Q_caller = QRᵀ, M_caller = RMRᵀ; else 0 × 0
};

enum class SeriesKind { rigid_body, parametric_rigid_body, stiefel, double_bracket };

/// A scene's motion at time 0 in the variables of a series, the frame over the momentum, computed
/// in Scalar from the numbers that the scene was given by:
///
///     right                 Qᵀ, −M                      [RB] Prop. 2.1
///     symmetric             M = (QᵀP − PᵀQ)/ε            Ψ
///     reduced               M = Qᵀ(PQᵀ − QPᵀ)Q/ε         [RB] (8.2)
///     McLachlan–Scovel      M = QᵀB                      [RB] (5.5)
///     body                  M = hat(I Rᵀω), Q = Q(q)R    I_caller = R I Rᵀ
///
/// Along the scene's own equations Q and these variables obey the series' ones whether or not
/// rounding left Q orthogonal, so the start has no error but that of Scalar. The equations of a
/// costate on V(n, N) are a geodesic's where QQᵀ = I alone, so there Q is made orthonormal first.
template <class Scalar_>
struct SeriesStart {
  using Scalar = Scalar_;
  SeriesKind kind;
  Vector<Scalar> lambda, lambda_v;  ///< Λ; Λ_U and Λ_V
  Scalar mu;
  Matrix<Scalar> x;
  Presentation<Scalar> presentation;
};

/// The start of a system's motion in both precisions of a reference.
struct MotionStart {
  SeriesStart<long double> (*extended)(const Scene&);
  SeriesStart<Quad> (*quadruple)(const Scene&);
};

}  // namespace stiefel
