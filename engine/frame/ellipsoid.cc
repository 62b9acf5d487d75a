// Geodesics on the ellipsoid: points of V(1, N), by velocity q̇ = SΛ⁻¹ or costate p.
#include "engine/frame/stiefel_costate.h"
#include "engine/frame/stiefel_forms.h"
#include "engine/frame/stiefel_invariants.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/observables.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

// Compiled once, in stiefel.cc.
extern template class SimulationOf<Composition<RattleStiefel<double>>>;

namespace {

void check_ellipsoid(SceneDraft& draft) {
  if (!check_stiefel_frame(draft, "q")) return;
  if (draft.scene().block("q").rows() != 1)
    return draft.refuse("initial.q", shape_text(draft.scene().block("q").rows(), 0),
                        "must be 1 x N");
  if (draft.has_block("p") == draft.has_block("qdot"))
    return draft.refuse("initial", draft.has_block("p") ? "p and qdot" : "neither",
                        "must hold exactly one of p and qdot");
  if (const RowMatrix* p = draft.block("p", 1, draft.scene().dimension(), false))
    return set_costate(draft, "p", *p);
  set_tangent(draft, "q", "qdot", true);
}

bool has_costate(const Scene& scene) { return scene.block("p").size() > 0; }
constexpr std::array for_ellipsoid = {
    restricted("given p", has_costate, with_error_control(5e-12, 0.15)), with_error_control(5e-14)};

/// Reads (q, p) or (q, qdot), n = 1.
WithinDomain<Phase> read_ellipsoid(const Scene& scene, Margins&) {
  const Eigen::MatrixXd &q = scene.block("q"), &p = scene.block("p");
  if (p.size() > 0) return phase_of_costate(scene, q, p);
  Phase x{scene.inertia(), scene.step(), q, {}, {}};
  x.S = S_of_Qdot<double>(x.lambda, scene.block("qdot"));
  return x;
}
WithinDomain<FormBlocks> write_ellipsoid(const Phase& x, const ConversionTarget&, Margins&) {
  const auto n = static_cast<double>(x.Q.rows());
  if (x.Q.rows() != 1) return outside({"V(1, N)", n, 1}, "to");
  return FormBlocks{{{"q", x.Q}, {"qdot", Qdot_of_S(x.lambda, x.S)}}};
}
constexpr Representation ellipsoid_representation = {false, read_ellipsoid, write_ellipsoid};

constexpr auto ellipsoid_start = [](const auto& g) {
  if (has_costate(g.scene)) return start_of_costate(g, "q", "p");
  const decltype(g.block("q")) q = g.block("q"), qdot = g.block("qdot");
  return g.start(q, S_of_Qdot(g.lambda, qdot));
};

std::unique_ptr<Simulation> make_ellipsoid(const Scene& scene) {
  using Wide = long double;
  const bool costate = has_costate(scene);
  const int N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  Eigen::MatrixXd state = stacked(scene, "q", costate ? "p" : "qdot");
  if (!costate) state.row(1) *= lambda.asDiagonal();
  Observables observables(std::move(state));
  observables.block("q", 0, 1);
  if (costate)
    observables.block("p", 1, 1);
  else
    observables.computed_block({"qdot", 1, N}, [lambda](const Eigen::MatrixXd& x, auto out) {
      out = x.row(1).cwiseQuotient(lambda.transpose());
    });
  const SOfState S{lambda, 1, costate};
  report_geodesic(observables, S);
  const auto energy = std::move(observables.all_invariants);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    energy(x, out);
    const Eigen::VectorXd q = x.row(0), qdot = S.Qdot(x).transpose();
    if (out.wants(family::joachimsthal)) {
      const Wide J = joachimsthal<Wide>(lambda.cast<Wide>(), q.cast<Wide>(), qdot.cast<Wide>());
      // The scale is (qᵀΛ⁻¹q)‖q̇‖², or what it would be for a q̇ of the size of its terms.
      const Wide of_terms = S.terms(x) / lambda.minCoeff();
      const bool at_rest = is_rounding(qdot.stableNorm(), static_cast<double>(of_terms));
      out.add(family::joachimsthal, J, at_rest ? of_terms * of_terms / lambda.maxCoeff() : J);
    }
    if (!out.wants(family::lax, lambda.size() <= largest_lax_unasked)) return;
    const Vector<Wide> wide_q = q.cast<Wide>(), p = x.row(1).transpose().cast<Wide>();
    out.add_coefficients(family::lax, lax_coefficients<Wide>(lambda.cast<Wide>(), wide_q, p, N),
                         true);
  };
  if (costate)
    return make_simulation(scene, StiefelCostate<double>(lambda, 1), shared(observables));
  return make_simulation<Variational, Exact>(scene, Stiefel<double>(lambda, 1),
                                             shared(observables));
}

/// Returns why a method that applies to (q, qdot) does not apply to (q, p); empty if it does.
std::string refusal(const Scene& scene, std::string_view method) {
  if (!has_costate(scene)) return "";
  std::string others;
  for (const auto& on : methods_on<StiefelCostate<double>>({})) {
    if (on.method == method) return "";
    others += (others.empty() ? "" : " or ") + std::string(on.method);
  }
  return "does not accept the costate p; give qdot, or use " + others;
}

}  // namespace

SystemEntry ellipsoid_entry() {
  SystemInfo info = stiefel_info({"qdot", "1 x N", false, "velocity; or give p"});
  info.blocks = {{"q", "1 x N", true, "unit vector"},
                 {"qdot", "1 x N", false, "velocity, orthogonal to q; exactly one of qdot and p"},
                 {"p", "1 x N", false, "costate"}};
  info.fields = {{"q", "1 x N", "unit vector; x = Lambda^1/2 q has x^T Lambda^-1 x = 1"},
                 {"qdot", "1 x N", "q', velocity, if given"},
                 {"p", "1 x N", "costate, if given"},
                 {"Qdot", "1 x N", "q', velocity"}};
  info.invariants = {{family::energy, "1/2 q'^T Lambda q'", "[ST] (3)"},
                     {family::joachimsthal, "(q^T Lambda^-1 q) (q'^T q')", ""},
                     {family::lax,
                      "coefficients of mu^j in tr M(mu)^k, M(mu) = q p^T - p q^T + mu Lambda + "
                      "q q^T D / (mu q^T Lambda^-1 q), "
                      "D = (p^T Lambda^-1 q)^2 - (p^T Lambda^-1 p) (q^T Lambda^-1 q), "
                      "p = Lambda q' if not given",
                      "[ST] (17)-(19)"},
                     {family::orthogonality, "q^T q = 1", ""}};
  info.momentum = "p";
  info.velocity = "qdot";
  info.name = "ellipsoid";
  info.summary = "geodesics on the ellipsoid with semi-axes lambda_i^1/2, n = 1";
  info.equations = "q'' = -((q'^T q') / (q^T Lambda^-1 q)) Lambda^-1 q";
  info.source = "[ST] (9), (14), (16)";
  info.file = "engine/frame/stiefel.h";
  return {.info = info,
          .check = check_ellipsoid,
          .make = make_ellipsoid,
          .methods = methods_on<Stiefel<double>, Variational, Exact>,
          .refusal = refusal,
          .recommended = for_ellipsoid,
          .representation = &ellipsoid_representation,
          .motion = &in_both<frame_equations, ellipsoid_start>};
}

}  // namespace stiefel
