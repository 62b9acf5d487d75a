#pragma once

#include <optional>

#include "engine/invariants/parametric_rigid_body.h"
#include "engine/linalg/lie/principal_moments_3.h"
#include "engine/linalg/lie/so_3.h"
#include "engine/representations/mclachlan_scovel.h"
#include "engine/representations/stiefel_legendre.h"
#include "engine/simulation/accuracy/reference.h"
#include "engine/simulation/scene/given_axes.h"

namespace stiefel {

/// How a scene reports a motion that a reference has in variables of its own.
template <class Scalar>
struct Presentation {
  bool right = false;            ///< Qᵀ and −M, [RB] Prop. 2.1
  bool complex = false;          ///< each block is its real part over its imaginary one
  Vector<Scalar> diagonal = {};  ///< μΛ², which M_μ = M + μΛ² has more than M
  Matrix<Scalar> axes = {};      ///< R of a body: Q_caller = QRᵀ, M_caller = RMRᵀ; else 0 × 0

  /// A state in rows: the frame, then the momentum.
  MotionState of(const Matrix<Scalar>& x, Eigen::Index momentum_rows) const {
    Matrix<Scalar> momentum = x.bottomRows(momentum_rows);
    if (diagonal.size() > 0) momentum.diagonal() -= diagonal;
    MotionState state{in_columns(x.topRows(x.rows() - momentum_rows)), in_columns(momentum),
                      complex};
    if (right) {
      state.attitude.transposeInPlace();
      state.momentum *= -1;
    }
    if (axes.size() > 0) {
      const Matrix<long double> R = axes.template cast<long double>();
      if (state.attitude.size() > 0) state.attitude = (state.attitude * R.transpose()).eval();
      state.momentum = (R * state.momentum * R.transpose()).eval();
    }
    return state;
  }

 private:
  Matrix<long double> in_columns(const Matrix<Scalar>& block) const {
    if (!complex) return block.template cast<long double>();
    const Eigen::Index p = block.rows() / 2;
    Matrix<long double> columns(p, 2 * block.cols());
    for (Eigen::Index j = 0; j < block.cols(); ++j) {
      columns.col(2 * j) = block.col(j).head(p).template cast<long double>();
      columns.col(2 * j + 1) = block.col(j).tail(p).template cast<long double>();
    }
    return columns;
  }
};

/// The frame nearest to a Q whose rows are orthonormal to rounding in double precision: Newton and
/// Schulz's iteration, twice, squares the defect of 1e-16 each time.
template <class Scalar>
Matrix<Scalar> orthonormal(Matrix<Scalar> Q) {
  for (int k = 0; k < 2; ++k) {
    const Matrix<Scalar> defect = Matrix<Scalar>::Identity(Q.rows(), Q.rows()) - Q * Q.transpose();
    Q += (defect * Q / 2).eval();
  }
  return Q;
}

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

/// Nothing for a discrete system, but for those of Moser and Veselov on (Q, M), (Q, P) and
/// (Q_{k−1}, Q_k), whose start is the rigid body's.
template <class Scalar>
std::optional<SeriesStart<Scalar>> start_of(const Scene& scene) {
  using Dense = Matrix<Scalar>;
  const std::string& system = scene.system();
  const auto block = [&](const char* name) -> Dense {
    return scene.block(name).template cast<Scalar>();
  };
  SeriesStart<Scalar> start{SeriesKind::rigid_body,
                            scene.inertia().template cast<Scalar>(),
                            {},
                            Scalar(scene.parameter()),
                            {},
                            {}};
  const Vector<Scalar>& lambda = start.lambda;
  const auto with = [&](SeriesKind kind, const Dense& frame, const Dense& momentum) {
    start.kind = kind;
    start.x.resize(frame.rows() + momentum.rows(), momentum.cols());
    start.x << frame, momentum;
    return start;
  };

  if (system == "double_bracket") {
    const auto vector = [](const std::vector<double>& l) -> Vector<Scalar> {
      return Eigen::Map<const Eigen::VectorXd>(l.data(), static_cast<Eigen::Index>(l.size()))
          .template cast<Scalar>();
    };
    start.lambda = vector(scene.description().inertia_u);
    start.lambda_v = vector(scene.description().inertia_v);
    start.presentation.complex = true;
    return with(SeriesKind::double_bracket, block("Q"), block("P"));
  }
  const Dense Q = block(system == "ellipsoid" ? "q" : "Q");
  if (system == "parametric_rigid_body") {
    start.presentation.diagonal = start.mu * lambda.cwiseAbs2();
    const Dense M = parametric_momentum<Scalar>(Q, block("P")) / Scalar(scene.epsilon());
    return with(SeriesKind::parametric_rigid_body, Q, M);
  }

  const auto frame = [&](const Dense& S) { return with(SeriesKind::stiefel, Q, S); };
  if (system == "stiefel") return frame(block("S"));
  const auto costate = [&](const char* name) {
    const Dense on = orthonormal<Scalar>(Q);
    return with(SeriesKind::stiefel, on, Legendre_inverse<Scalar>(lambda, on, block(name)));
  };
  if (system == "stiefel_momentum" || system == "stiefel_costate") return costate("P");
  if (system == "ellipsoid")
    return scene.block("p").size() > 0 ? costate("p")
                                       : frame(S_of_Qdot<Scalar>(lambda, block("qdot")));

  if (const auto& given = scene.description().body) {
    const auto [I, R] = given_axes<Scalar>(*given);
    start.lambda =
        PrincipalMoments3<Scalar>(I, Vector3<Scalar>(I(1) - I(2), I(2) - I(0), I(0) - I(1)))
            .lambda();
    start.presentation.axes = R;
    const auto vector = [](const auto& v) { return v.template cast<Scalar>().eval(); };
    const auto q = vector(Eigen::Vector4d(given->attitude.data()));
    const auto omega = vector(Eigen::Vector3d(given->angular_velocity.data()));
    const Vector3<Scalar> m = I.cwiseProduct(R.transpose() * omega);
    using std::sqrt;
    const Dense attitude = rotation_matrix<Scalar>((q / sqrt(Scalar(q.squaredNorm()))).eval()) * R;
    return with(SeriesKind::rigid_body, attitude, hat(m));
  }
  const auto body = [&](const Dense& of, const Dense& M) {
    return with(SeriesKind::rigid_body, of, M);
  };
  const auto epsilon = Scalar(scene.epsilon());
  if (system == "rigid_body" || system == "moser_veselov") return body(Q, block("M"));
  if (system == "symmetric_rigid_body" || system == "symmetric_moser_veselov")
    return body(Q, dense_M<Scalar>(Q, block("P")) / epsilon);
  if (system == "reduced_rigid_body")
    return body(Q, Q.transpose() * momentum_m<Scalar>(Q, block("P")) * Q / epsilon);
  if (system == "mclachlan_scovel") return body(Q, M_of_B<Scalar>(Q, block("B")));
  if (system == "moser_veselov_pair") {
    const Dense W = lambda.asDiagonal() * (block("Q_prev").transpose() * Q);
    return body(Q, (W - W.transpose()) / Scalar(scene.step()));
  }
  start.presentation.right = true;
  if (system == "right_rigid_body") return body(Q.transpose(), -block("M"));
  if (system == "right_symmetric_rigid_body")
    return body(Q.transpose(), dense_M<Scalar>(Q.transpose(), block("P").transpose()) / epsilon);
  return std::nullopt;
}

}  // namespace stiefel
