#include "engine/frames/stiefel_forms.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
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
WithinDomain<Expression> write(const Phase& x, const ConversionTarget&, Margins&) {
  const auto n = static_cast<double>(x.Q.rows());
  if (x.Q.rows() != 1) return outside({"V(1, N)", n, 1}, "to");
  return Expression{{{"q", x.Q}, {"qdot", Qdot_of_S(x.lambda, x.S)}}};
}
constexpr Representation representation = {false, read, write};

constexpr auto start = [](const auto& g) {
  if (has_costate(g.scene)) return start_of_costate(g, "q", "p");
  const decltype(g.block("q")) q = g.block("q"), qdot = g.block("qdot");
  return g.start(q, S_of_Qdot(g.lambda, qdot));
};

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
  info.file = "engine/frames/body/ellipsoid.h";
  return {.info = info,
          .check = check,
          .recommended = recommendations,
          .representation = &representation,
          .motion = &in_both<frame_equations, start>};
}

}  // namespace stiefel
