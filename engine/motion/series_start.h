#pragma once

#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The equations that the motion of a system obeys in the variables of its start, with the
/// references for them (engine/accuracy/series_equations.h).
struct SeriesEquations;

/// How a scene reports a motion that a reference computes in its own variables.
template <class Scalar>
struct ReportedForm {
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
  Vector<Scalar> lambda, lambda_v;  ///< Λ; or Λ_U and Λ_V; lambda_v also for other constants
  Scalar mu;
  Matrix<Scalar> x;
  ReportedForm<Scalar> reported;
};

/// The numbers of a scene in Scalar.
template <class Scalar>
struct SceneNumbers {
  using Dense = Matrix<Scalar>;
  using Start = SeriesStart<Scalar>;

  explicit SceneNumbers(const Scene& of)
      : scene(of), lambda(numbers(of.inertia())), mu(of.parameter()), epsilon(of.epsilon()) {}

  static auto numbers(const auto& v) { return v.template cast<Scalar>().eval(); }
  Dense block(const char* name) const { return numbers(scene.block(name)); }
  Start start(const Dense& frame, const Dense& momentum) const {
    Start start{lambda, {}, mu, Dense(frame.rows() + momentum.rows(), momentum.cols()), {}};
    if (frame.size() > 0) start.x.topRows(frame.rows()) = frame;  // a scene with M alone has none
    start.x.bottomRows(momentum.rows()) = momentum;
    return start;
  }

  const Scene& scene;
  Vector<Scalar> lambda;
  Scalar mu, epsilon;
};

/// Computes the start of a system's motion in either precision of a reference.
struct MotionStart {
  const SeriesEquations* equations;
  SeriesStart<long double> (*extended)(const Scene&);
  SeriesStart<Quad> (*quadruple)(const Scene&);
};

/// The start of a motion, for SystemEntry::motion, by a function of SceneNumbers<Scalar>.
template <const SeriesEquations& equations, auto start>
inline constexpr MotionStart in_both = {
    &equations, [](const Scene& scene) { return start(SceneNumbers<long double>(scene)); },
    [](const Scene& scene) { return start(SceneNumbers<Quad>(scene)); }};

}  // namespace stiefel
