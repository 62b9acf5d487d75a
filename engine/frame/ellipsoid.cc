#include "engine/frame/stiefel_forms.h"
#include "engine/frame/stiefel_invariants.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/stacked_observables.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

// Compiled once, in stiefel.cc.
extern template class SimulationOf<Composition<RattleStiefel<double>>>;

namespace {

void check(SceneDraft& draft) {
  if (!check_stiefel_frame(draft, "q")) return;
  if (draft.scene().block("q").rows() != 1)
    return draft.refuse("initial.q", shape_text(draft.scene().block("q").rows(), 0),
                        "must be 1 x N");
  if (draft.has_block("p") == draft.has_block("qdot"))
    return draft.refuse("initial", draft.has_block("p") ? "p and qdot" : "neither",
                        "must hold exactly one of p and qdot");
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* p = draft.block("p", 1, N, false)) set_costate(draft, "p", *p);
  if (const RowMatrix* qdot = draft.block("qdot", 1, N, false)) {
    const double along = (*qdot * draft.scene().block("q").transpose())(0, 0);
    if (!(std::abs(along) <= draft.largest_repair() * qdot->stableNorm()))
      return draft.refuse("initial.qdot", "q·qdot = " + to_text(along), "must be orthogonal to q");
    if (draft.check_velocity("initial.qdot", "max |qdot|", qdot->cwiseAbs().maxCoeff()))
      draft.set_block("qdot", *qdot);
  }
}

bool has_costate(const Scene& scene) { return scene.block("p").size() > 0; }
constexpr std::array recommendations = {
    restricted("given p", has_costate, with_error_control(5e-12, 0.15)), with_error_control(5e-14)};

/// Reads (q, p) or (q, qdot), n = 1.
WithinDomain<Phase> read(const Scene& scene, Margins&) {
  const Eigen::MatrixXd &q = scene.block("q"), &p = scene.block("p");
  if (p.size() > 0) return phase_of_costate(scene, q, p);
  Phase x{scene.inertia(), scene.step(), q, {}, {}};
  x.S = S_of_Qdot<double>(x.lambda, scene.block("qdot"));
  return x;
}
WithinDomain<FormBlocks> write(const Phase& x, const ConversionTarget&, Margins&) {
  const auto n = static_cast<double>(x.Q.rows());
  if (x.Q.rows() != 1) return outside({"V(1, N)", n, 1}, "to");
  return FormBlocks{{{"q", x.Q}, {"qdot", Qdot_of_S(x.lambda, x.S)}}};
}
constexpr Representation representation = {false, read, write};

constexpr auto start = [](const auto& g) {
  if (has_costate(g.scene)) return start_of_costate(g, "q", "p");
  const decltype(g.block("q")) q = g.block("q"), qdot = g.block("qdot");
  return g.start(q, S_of_Qdot(g.lambda, qdot));
};

using Wide = long double;

/// Returns q̇ from the rows q and q̇, or q and p of a costate.
Eigen::VectorXd velocity(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& x, bool costate) {
  if (!costate) return x.row(1);
  EllipsoidCostate<double> system(lambda);
  Eigen::MatrixXd dx = x;
  system.field(x, dx);
  return dx.row(0);
}

std::unique_ptr<Simulation> make_ellipsoid(const Scene& scene) {
  const bool costate = scene.block("p").size() > 0;
  const Eigen::VectorXd lambda = scene.inertia();
  StackedObservables observables(stacked(scene, "q", costate ? "p" : "qdot"));
  observables.block("q", 0, 1).block(costate ? "p" : "qdot", 1, 1);
  const SizeOf terms = terms_of_S(scene, 1, costate);
  report_geodesic(
      observables, scene, 1,
      [=](const Eigen::MatrixXd& x) -> Eigen::MatrixXd {
        return velocity(lambda, x, costate).cwiseProduct(lambda).transpose();
      },
      terms);
  const auto energy = std::move(observables.all_invariants);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    energy(x, out);
    const Eigen::VectorXd q = x.row(0), qdot = velocity(lambda, x, costate);
    if (out.wants(family::joachimsthal)) {
      const Wide J = joachimsthal<Wide>(lambda.cast<Wide>(), q.cast<Wide>(), qdot.cast<Wide>());
      // The scale is (qᵀΛ⁻¹q)‖q̇‖², or what it would be for a q̇ of the size of its terms.
      const Wide of_terms = terms(x) / lambda.minCoeff();
      const bool at_rest = is_rounding(qdot.stableNorm(), static_cast<double>(of_terms));
      out.add(family::joachimsthal, J, at_rest ? of_terms * of_terms / lambda.maxCoeff() : J);
    }
    if (!out.wants(family::lax, lambda.size() <= largest_lax_unasked)) return;
    const Vector<Wide> wide_q = q.cast<Wide>();
    const Vector<Wide> p = costate ? Vector<Wide>(x.row(1).transpose().cast<Wide>())
                                   : Vector<Wide>(lambda.cwiseProduct(qdot).cast<Wide>());
    out.add_coefficients(
        family::lax,
        lax_coefficients<Wide>(lambda.cast<Wide>(), wide_q, p, static_cast<int>(lambda.size())),
        true);
  };
  if (costate) return make_simulation(scene, EllipsoidCostate<double>(lambda), shared(observables));
  return make_simulation(scene, Ellipsoid<double>(lambda), shared(observables));
}

/// Returns why a method that applies to (q, qdot) does not apply to (q, p); empty if it does.
std::string refusal(const Scene& scene, std::string_view method) {
  if (scene.block("p").size() == 0) return "";
  std::string others;
  for (const auto& on : methods_on<EllipsoidCostate<double>>({})) {
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
  info.file = "engine/frame/ellipsoid.h";
  return {.info = info,
          .check = check,
          .make = make_ellipsoid,
          .methods = methods_on<Ellipsoid<double>>,
          .refusal = refusal,
          .recommended = recommendations,
          .representation = &representation,
          .motion = &in_both<frame_equations, start>};
}

}  // namespace stiefel
