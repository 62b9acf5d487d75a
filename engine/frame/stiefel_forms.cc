#include "engine/frame/stiefel_forms.h"

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel_invariants.h"
#include "engine/motion/observables.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

SystemInfo stiefel_info(BlockInfo other) {
  SystemInfo info{};
  info.momentum = other.name;
  info.velocity = "Qdot";
  info.blocks = {{"Q", "n x N", true, "frame, orthonormal rows"}, other};
  info.fields = {{"Q", "n x N", "frame, orthonormal rows"},
                 {other.name, other.shape, other.description},
                 {"Qdot", "n x N", "Q', velocity of the frame"}};
  info.invariants = {
      {family::energy, "1/2 tr(S Lambda^-1 S^T), S = Q' Lambda", "[ST] (3)"},
      {family::spatial_momentum, "S Q^T - Q S^T, n x n", "[ST] (44)"},
      {family::orthogonality, "Q Q^T = I", ""},
  };
  return info;
}

bool check_stiefel_frame(SceneDraft& draft, const char* frame) {
  draft.refuse_other_numbers();
  draft.refuse_if(draft.given().body.has_value(), "body");
  draft.check_block_names();
  const auto found = draft.given().initial.find(frame);
  const Eigen::Index n = found == draft.given().initial.end() ? 1 : found->second.values.rows();
  if (!draft.set_inertia(2, Scene::max_elements)) return false;
  draft.check_inertia_positive();
  const Eigen::Index N = draft.scene().dimension();
  if (found != draft.given().initial.end() && n == N && found->second.values.cols() < N) {
    const Eigen::Index columns = found->second.values.cols();
    draft.refuse("initial." + std::string(frame), shape_text(n, columns),
                 "is the transpose of a frame, whose rows are orthonormal: must be " +
                     shape_text(columns, N));
    return false;
  }
  if (n > N || n > Scene::max_dimension || n * N > Scene::max_elements) {
    draft.refuse("initial." + std::string(frame), shape_text(n, N),
                 "must have n ≤ N, n ≤ " + std::to_string(Scene::max_dimension) + " and n N ≤ " +
                     std::to_string(Scene::max_elements));
    return false;
  }
  if (const RowMatrix* Q = draft.block(frame, n, N)) draft.set_frame(frame, *Q);
  return draft.sound();
}

void set_costate(SceneDraft& draft, const std::string& name, const RowMatrix& P) {
  const Eigen::VectorXd inverse = draft.scene().inertia().cwiseInverse();
  const double velocity = (P * inverse.asDiagonal()).cwiseAbs().maxCoeff();
  if (draft.check_velocity("initial." + name, "max |" + name + "Λ⁻¹|", velocity))
    draft.set_block(name, P);
}

void set_tangent(SceneDraft& draft, const char* frame, const char* name, bool is_velocity) {
  const Eigen::MatrixXd& Q = draft.scene().block(frame);
  const Eigen::VectorXd& lambda = draft.scene().inertia();
  const RowMatrix* given = draft.block(name, Q.rows(), Q.cols());
  if (given == nullptr) return;
  Eigen::MatrixXd V = *given;
  if (!is_velocity) V *= lambda.cwiseInverse().asDiagonal();
  if (!draft.check_velocity("initial." + std::string(name), "max |Q̇|", V.cwiseAbs().maxCoeff()))
    return;
  const Eigen::MatrixXd product = V * Q.transpose(), defect = product + product.transpose();
  const double size = defect.cwiseAbs().maxCoeff(), speed = V.stableNorm();
  if (!(size <= draft.largest_repair() * speed))
    return draft.refuse(
        "initial." + std::string(name), "max |Q̇Qᵀ + QQ̇ᵀ| = " + to_text(size),
        "must be tangent: Q̇Qᵀ skew-symmetric to " + to_text(draft.largest_repair()) + " ‖Q̇‖");
  if (!(size > 4 * static_cast<double>(Q.cols()) * 0x1p-53 * speed))
    return draft.set_block(name, *given);
  V = tangent_velocity<double>(lambda, Q, V);
  if (!is_velocity) V *= lambda.asDiagonal();
  draft.set_block(name, V);
}

Phase phase_of_costate(const Scene& scene, const Eigen::MatrixXd& Q, const Eigen::MatrixXd& P) {
  Phase x{scene.inertia(), scene.step(), Q, {}, {}};
  if (x.square())
    x.M = dense_M(Q, P);
  else
    x.S = Legendre_inverse(x.lambda, Q, P);
  return x;
}

WithinDomain<Phase> read_costate(const Scene& scene, Margins&) {
  return phase_of_costate(scene, scene.Q(), scene.block("P"));
}

Eigen::MatrixXd S_of(const Phase& x) {
  return x.square() ? S_of_Qdot<double>(x.lambda, x.Q * inverse_inertia(x.lambda, x.M)) : x.S;
}

void report_geodesic(Observables& observables, const SOfState& S) {
  observables.field({"Qdot", static_cast<int>(S.n), static_cast<int>(S.lambda.size())},
                    [S](const auto& x, auto out) { out = S.Qdot(x); });
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    using Wide = long double;
    const Eigen::MatrixXd lower = S(x);
    const Wide of_terms = S.terms(x), of_S = lower.cast<Wide>().stableNorm();
    const bool at_rest = is_rounding(static_cast<double>(of_S), static_cast<double>(of_terms));
    if (out.wants(family::energy)) {
      const Wide E = stiefel_energy<Wide>(S.lambda, lower);
      out.add(family::energy, E, at_rest ? of_terms * of_terms / (2 * S.lambda.maxCoeff()) : E);
    }
    if (!out.wants(family::spatial_momentum)) return;
    out.add_skew(family::spatial_momentum,
                 momentum_m<Wide>(x.topRows(S.n).cast<Wide>(), lower.cast<Wide>()),
                 at_rest ? of_terms : of_S);
  };
  observables.frame_defect = [n = S.n](const Eigen::MatrixXd& x) {
    return std::optional(orthogonality_defect(x.topRows(n)));
  };
  observables.speed = [S](const Eigen::MatrixXd& x) { return S.Qdot(x).stableNorm(); };
}

template <class Scalar>
SeriesStart<Scalar> start_of_costate(const SceneNumbers<Scalar>& g, const char* frame,
                                     const char* costate) {
  Matrix<Scalar> Q = g.block(frame);
  for (int k = 0; k < 2; ++k) {
    const Matrix<Scalar> defect = Matrix<Scalar>::Identity(Q.rows(), Q.rows()) - Q * Q.transpose();
    Q += (defect * Q / 2).eval();
  }
  return g.start(Q, Legendre_inverse<Scalar>(g.lambda, Q, g.block(costate)));
}
template SeriesStart<long double> start_of_costate(const SceneNumbers<long double>&, const char*,
                                                   const char*);
template SeriesStart<Quad> start_of_costate(const SceneNumbers<Quad>&, const char*, const char*);

namespace {

/// Returns Q̇, from M where n = N, else from S.
Eigen::MatrixXd Qdot_of(const Phase& x) {
  return x.square() ? Eigen::MatrixXd(x.Q * inverse_inertia(x.lambda, x.M))
                    : Qdot_of_S(x.lambda, x.S);
}
WithinDomain<FormBlocks> write_velocity(const Phase& x, const ConversionTarget&, Margins&) {
  return FormBlocks{{{"Q", x.Q}, {"Qdot", Qdot_of(x)}}};
}

/// Writes U by 𝒵, [ST] Theorem 2.
WithinDomain<FormBlocks> write_angular_velocity(const Phase& x, const ConversionTarget&, Margins&) {
  if (x.square()) return FormBlocks{{{"Q", x.Q}, {"U", x.Q.transpose() * Qdot_of(x)}}};
  const auto N = static_cast<double>(x.Q.cols());
  if (x.Q.cols() > largest_written_M) return outside({"N", N, largest_written_M}, "to");
  OptimalControl<double> U(x.lambda, x.Q.rows());
  U.set(x.Q, x.S);
  return FormBlocks{{{"Q", x.Q}, {"U", U.dense()}}};
}

}  // namespace

namespace representations {
constinit const Representation velocity = {false, nullptr, write_velocity};
constinit const Representation angular_velocity = {false, nullptr, write_angular_velocity};
}  // namespace representations

}  // namespace stiefel
