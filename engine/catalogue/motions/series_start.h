#pragma once

#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"
#include "engine/catalogue/motions/series_equations.h"
#include "stiefel/scene.h"

namespace stiefel {

/// How a scene reports a motion that a reference computes in its own variables.
template <class Scalar>
struct Presentation {
  bool right = false;            ///< reported as Qᵀ and −M, [RB] Prop. 2.1
  bool complex = false;          ///< each block is stored as its real part over its imaginary part
  Vector<Scalar> diagonal = {};  ///< μΛ², the part of M_μ = M + μΛ² to be subtracted
  Matrix<Scalar> axes = {};      ///< R of a body: Q_caller = QRᵀ, M_caller = RMRᵀ; else 0 × 0
};

/// The motion of a scene at time 0 in the variables of a series, the frame over the momentum,
/// computed in Scalar from the numbers with which the scene was given:
///
///     right                 Qᵀ, −M                      [RB] Prop. 2.1
///     symmetric             M = (QᵀP − PᵀQ)/ε            Ψ
///     reduced               M = Qᵀ(PQᵀ − QPᵀ)Q/ε         [RB] (8.2)
///     McLachlan–Scovel      M = QᵀB                      [RB] (5.5)
///     body                  M = hat(I Rᵀω), Q = Q(q)R    I_caller = R I Rᵀ
///
/// Along the scene's own equations Q and these variables obey the equations of the series whether
/// or not rounding left Q orthogonal, so the start has only the error of Scalar. The equations of a
/// costate on V(n, N) are those of a geodesic only where QQᵀ = I, so there Q is made orthonormal
/// first.
template <class Scalar_>
struct SeriesStart {
  using Scalar = Scalar_;
  const SeriesEquations* equations;
  Vector<Scalar> lambda, lambda_v;  ///< Λ in lambda; or Λ_U in lambda and Λ_V in lambda_v
  Scalar mu;
  Matrix<Scalar> x;
  Presentation<Scalar> presentation;
};

/// Computes the start of a system's motion in either precision of a reference.
struct MotionStart {
  SeriesStart<long double> (*extended)(const Scene&);
  SeriesStart<Quad> (*quadruple)(const Scene&);
};

}  // namespace stiefel
