// The rigid body with parameter and its discrete form, [RB] (8.4)–(8.6), (8.10).
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>

#include "engine/body/parametric_rigid_body.h"
#include "engine/body/psi.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_forms.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/observables.h"
#include "engine/motion/representation.h"
#include "engine/motion/series_start.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/scene_draft.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

// Between (Q, M) and the (Q, P) with parameter μ, [RB] (8.5), Q ∈ GL(N), with the scaling of Prop.
// 3.13 (ε = 1 in the paper). For the discrete body, (8.10), replace μ by μ/h; ε = h gives the
// paper's P. All matrices are N × N:
//
//     G − G⁻¹ = ε(M + μΛ²) = 2W,   G = Q⁻¹P,
//     P = Q(W + (I + W²)^{1/2}),   spec(I + W²) off (−∞, 0].
//
// M is the skew part of (G − G⁻¹)/ε, because μΛ² is symmetric. For μ = 0 and Q ∈ O(N) this is Ψ.

/// Returns M.
Dense parametric_Psi(const Dense& Q, const Dense& P, double epsilon) {
  const Dense M = parametric_momentum(Q, P) / 2;
  return (M - M.transpose()) / epsilon;
}

/// The P of (Q, M), and its margin in the domain "S_M^mu": the smallest of |z| for the eigenvalues
/// z of I + W² with Re z > 0 and of |Im z| for the others.
struct InverseImage {
  Dense P;
  double margin = std::numeric_limits<double>::infinity();
};
/// Outside the domain the error holds the largest |w| over the eigenvalues iw of 2W on the
/// imaginary axis, which must be < 2.
WithinDomain<InverseImage> parametric_Psi_inverse(const Eigen::VectorXd& lambda, const Dense& Q,
                                                  const Dense& M, double mu, double epsilon) {
  constexpr double on_the_cut = 1e-12;
  Dense W = epsilon / 2 * M;
  W.diagonal() += epsilon / 2 * mu * lambda.cwiseAbs2();
  const Dense square = Dense::Identity(W.rows(), W.cols()) + W * W;
  const auto refused = [](double w) { return std::unexpected(OutsideDomain{"S_M^mu", w, 2}); };
  if (!square.allFinite()) return refused(2 * W.cwiseAbs().maxCoeff());
  InverseImage found;
  double cut = 0;  // where z on the cut is farthest from 0
  const Eigen::VectorXcd eigenvalues = spectrum(square);
  for (const std::complex<double> z : eigenvalues) {
    const double distance = z.real() > 0 ? std::abs(z) : std::abs(z.imag());
    found.margin = std::min(found.margin, distance);
    if (!(distance > on_the_cut)) cut = std::max(cut, std::abs(1.0 - z));  // z = 1 − (w/2)²
  }
  if (!(found.margin > on_the_cut)) return refused(2 * std::sqrt(cut));
  found.P = Q * (W + principal_root(square));
  return found;
}

/// Returns 1/condition of M as a function of P: ε‖M‖_op/(‖G‖(1 + ‖G⁻¹‖²)). P holds M with a
/// relative error of 2⁻⁵³ divided by this number: digits of M are lost where ‖εM‖ ≪ 1 or ‖M‖ ≪
/// |μ|‖Λ‖².
double inverse_condition_parametric(const Dense& Q, const Dense& P, const Dense& M,
                                    double epsilon) {
  const auto [G, inverse] = quotients(Q, P);
  return std::abs(epsilon) * skew_norm(M) / (skew_norm(G) * (1 + std::pow(skew_norm(inverse), 2)));
}

/// Returns ‖·‖_F of the matrices whose difference is M, increased by what the solves add to their
/// rounding.
double parametric_terms(const Eigen::VectorXd& lambda, double mu_over_h, double epsilon,
                        const Dense& Q, const Dense& P) {
  const auto solved = [](const Dense& A, const Dense& B) {
    stop_point(static_cast<double>(A.rows() * A.size()));
    const Lu<double> lu(A);
    return lu.solve(B).stableNorm() / lu.inverse_condition();
  };
  return (solved(Q, P) + solved(P, Q)) / std::abs(epsilon) +
         std::abs(mu_over_h) * lambda.cwiseAbs2().stableNorm();
}

/// Returns by how much the rounding of P can change M, at most `relative` times the sizes of G and
/// G⁻¹, whose difference is εM_μ.
double rounding_of_momentum(const Dense& Q, const Dense& P, double epsilon, double relative) {
  const auto quotient = quotients(Q, P);
  const double G = quotient[0].norm(), inverse = quotient[1].norm();
  const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
  return std::min(rounding * G * (1 + inverse * inverse), relative * (G + inverse)) /
         std::abs(epsilon);
}

/// Returns the common data; `momentum` is the formula of the field M, which also defines epsilon.
SystemInfo parametric_info(std::string_view momentum) {
  SystemInfo info{};
  info.blocks = {{"Q", "N x N", true, "invertible"}, {"P", "N x N", true, "invertible"}};
  info.fields = {{"Q", "N x N", "invertible"},
                 {"P", "N x N", "invertible"},
                 {"M", "N x N", momentum},
                 {"epsilon", "1 x 1", momentum}};
  for (const auto& invariant : rigid_body_invariant_infos())
    if (invariant.name != family::spatial_momentum) info.invariants.push_back(invariant);
  info.invariants.push_back({family::PQ_inverse, "P Q^-1", "[RB] section 8"});
  return info;
}

/// Checks Λ; Q and P invertible with M = (Q⁻¹P − P⁻¹Q)/ε − (μ/h)Λ² skew; `parameter`, which is μ, 0
/// if absent; and `epsilon`, which if absent is h, as in the paper's own variables. h = 1 for the
/// flow.
void check_parametric(SceneDraft& draft, double h) {
  auto& given = draft.given();
  const bool has_inertia = check_square_inertia(draft, true, true);
  if (!std::isfinite(given.parameter.value_or(0)))
    draft.refuse("parameter", to_text(*given.parameter), "must be finite");
  given.parameter = given.parameter.value_or(0);
  if (!(std::isfinite(h) && h != 0)) return;  // the step is invalid and refused elsewhere
  given.epsilon = given.epsilon.value_or(h);
  if (!(std::isfinite(*given.epsilon) && *given.epsilon != 0))
    return draft.refuse("epsilon", to_text(*given.epsilon), "must be finite and not 0");
  if (!has_inertia) return;
  const Eigen::Index N = draft.scene().dimension();
  for (const char* name : {"Q", "P"}) {
    const RowMatrix* block = draft.block(name, N, N);
    if (block == nullptr) continue;
    if (const double quality = Lu<double>(*block).inverse_condition(); !(quality > 1e-12))
      draft.refuse("initial." + std::string(name), "1/condition " + to_text(quality),
                   "must be invertible");
    draft.set_block(name, *block);
  }
  if (!draft.sound()) return;
  const Dense &Q = draft.scene().Q(), &P = draft.scene().block("P");
  const double mu_over_h = *given.parameter / h;
  Dense M = parametric_momentum(Q, P) / *given.epsilon;  // before its skew part is taken
  M.diagonal() -= mu_over_h * draft.scene().inertia().cwiseAbs2();
  const double defect = (M + M.transpose()).cwiseAbs().maxCoeff();
  const double size = M.cwiseAbs().maxCoeff() + std::abs(mu_over_h);
  constexpr double relative = 1e-8;
  if (!M.allFinite() ||
      !(defect <= relative * size + rounding_of_momentum(Q, P, *given.epsilon, relative)))
    return draft.refuse(
        "initial", "max |M + Mᵀ| = " + to_text(defect),
        "M = (Q⁻¹P − P⁻¹Q)/ε − (μ/h)Λ², h = 1 for the flow, must be skew-symmetric");
  draft.check_momentum("initial", M);
  draft.check_velocity("parameter", "max |μλ|/h",
                       std::abs(mu_over_h) * draft.scene().inertia().cwiseAbs().maxCoeff());
}

/// Read and write (Q, P) with parameter, [RB] (8.5), (8.10).
WithinDomain<Phase> read_parametric(const Scene& scene, Margins& margins) {
  const Dense &Q = scene.Q(), &P = scene.block("P");
  const double defect = orthogonality_defect(Q);
  if (!(defect <= Scene::frame_tolerance))
    return outside({"O(N)", defect, Scene::frame_tolerance}, "initial.Q");
  Dense M = parametric_Psi(Q, P, scene.epsilon());
  add_condition(M, inverse_condition_parametric(Q, P, M, scene.epsilon()), margins);
  return phase_of_body(scene, Q, std::move(M));
}

WithinDomain<FormBlocks> write_parametric(double h, const Phase& x, const ConversionTarget& target,
                                          Margins& margins) {
  const double mu = target.parameter.value_or(0);
  // Without a given ε, ½ < ε(‖M‖_op + |μ/h|‖Λ‖²) ≤ 1, so that P is well inside the domain.
  const double epsilon = target.epsilon.value_or(
      unit_epsilon_of(skew_norm(x.M) + std::abs(mu / h) * x.lambda.cwiseAbs2().maxCoeff()));
  auto found = parametric_Psi_inverse(x.lambda, x.Q, x.M, mu / h, epsilon);
  if (!found) return outside(found.error(), target.epsilon ? "epsilon" : "parameter");
  margins.push_back({"S_M^mu", found->margin});
  add_condition(x.M, inverse_condition_parametric(x.Q, found->P, x.M, epsilon), margins);
  return FormBlocks{{{"Q", x.Q}, {"P", std::move(found->P)}}, epsilon, mu};
}

/// Returns the observables of Q over P: the blocks, M and epsilon, and the invariants.
Observables parametric_observables(const Scene& scene, double h) {
  const int N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  const double mu_over_h = scene.parameter() / h, epsilon = scene.epsilon();
  const auto M = [=](const Dense& x) -> Dense {
    return parametric_Psi(x.topRows(N), x.bottomRows(N), epsilon);
  };
  Observables observables(stacked(scene, "Q", "P"));
  observables.block("Q", 0, N).block("P", N, N);
  observables.field({"M", N, N}, [M](const auto& x, auto out) { out = M(x); });
  observables.field({"epsilon", 1, 1}, [epsilon](const auto&, auto out) { out(0, 0) = epsilon; });
  observables.all_invariants = [=](const Dense& x, InvariantList& out) {
    // εM is the difference of G = Q⁻¹P and G⁻¹, which are near 1 when εM is small.
    const double terms =
        parametric_terms(lambda, mu_over_h, epsilon, x.topRows(N), x.bottomRows(N));
    rigid_body_invariants(Side::left, lambda, Dense(), M(x), out, terms);
    if (!out.wants(family::PQ_inverse)) return;
    stop_point(static_cast<double>(N * x.size()));
    const Dense A =
        Lu<double>(x.topRows(N).transpose()).solve(x.bottomRows(N).transpose()).transpose();
    out.add_elements(family::PQ_inverse, A, A.norm());
  };
  observables.speed = [=](const Dense& x) { return angular_velocity_norm(lambda, M(x)); };
  return observables;
}

template <bool discrete>
constexpr Representation parametric_representation = {
    .square = true,
    .read = read_parametric,
    .write =
        [](const Phase& x, const ConversionTarget& target, Margins& margins) {
          return write_parametric(discrete ? x.step : 1, x, target, margins);
        },
    .has_epsilon = true,
    .has_parameter = true};

constexpr auto parametric_start = [](const auto& g) {
  const auto Q = g.block("Q");
  auto made = g.start(Q, parametric_momentum(Q, g.block("P")) / g.epsilon);
  made.reported.diagonal = g.mu * g.lambda.cwiseAbs2();
  return made;
};

/// Whether Omega is constant, so that a step by the exponential is exact.
bool turns_evenly(const Scene& scene) {
  const Eigen::VectorXd& lambda = scene.inertia();
  return lambda.size() == 2 || (lambda.array() == lambda(0)).all();
}

constexpr std::array for_parametric = {
    Recommendation{.where = "N = 2, or Lambda a multiple of the identity",
                   .takes = turns_evenly,
                   .method = "munthe_kaas4",
                   .order = 4},
    with_error_control(5e-14, 0.1)};

std::unique_ptr<Simulation> make_parametric_rigid_body(const Scene& scene) {
  return make_simulation(
      scene, ParametricRigidBody<double>(scene.inertia(), scene.parameter(), scene.epsilon()),
      shared(parametric_observables(scene, 1)));
}

std::unique_ptr<Simulation> make_parametric_moser_veselov(const Scene& scene) {
  using Map = ParametricMoserVeselov;
  return std::make_unique<SimulationOf<Map>>(
      scene, Map(scene.inertia(), scene.step(), scene.parameter(), scene.epsilon()),
      shared(parametric_observables(scene, scene.step())));
}

}  // namespace

SystemEntry parametric_rigid_body_entry() {
  SystemInfo info = parametric_info("M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2, skew");
  info.name = "parametric_rigid_body";
  info.summary = "rigid body in GL(N) with the spectral parameter mu";
  info.equations = "Q' = Q (Omega + mu Lambda), P' = P (Omega + mu Lambda), Omega = J^-1(M)";
  info.source = "[RB] (8.4)-(8.6)";
  info.file = "engine/body/parametric_rigid_body.h";
  return {.info = info,
          .check = [](SceneDraft& draft) { check_parametric(draft, 1); },
          .make = make_parametric_rigid_body,
          .methods = methods_on<ParametricRigidBody<double>>,
          .recommended = for_parametric,
          .representation = &parametric_representation<false>,
          .motion = &in_both<parametric_equations, parametric_start>,
          .example_step = 0.4};
}

SystemEntry parametric_moser_veselov_entry() {
  SystemInfo info = parametric_info("M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2 / h, skew");
  info.name = "parametric_moser_veselov";
  info.summary = "discrete rigid body in GL(N) with the spectral parameter mu";
  info.equations =
      "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k (U + mu Lambda), P_{k+1} = P_k (U + mu Lambda)";
  info.source = "[RB] (8.10)-(8.11)";
  info.file = "engine/body/parametric_rigid_body.h";
  info.discrete = true;
  return {.info = info,
          .check = [](SceneDraft& draft) { check_parametric(draft, draft.step()); },
          .make = make_parametric_moser_veselov,
          .methods = keeps_all,
          .representation = &parametric_representation<true>};
}

}  // namespace stiefel
