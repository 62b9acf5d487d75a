#include "engine/rigid_body/symmetric_data.h"

#include <cmath>

#include "engine/catalogue/representation.h"
#include "engine/catalogue/series_start.h"
#include "engine/catalogue/two_form.h"
#include "engine/laws/tangent_spaces.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/rigid_body/symmetric/left_right.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric/scaling.h"
#include "engine/rigid_body/symmetric/symmetric_invariants.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

void set_P_of_M(SceneDraft& draft, const RowMatrix& given_M, bool right) {
  draft.set_skew("M", given_M);
  if (!draft.sound()) return;
  const Eigen::MatrixXd &Q = draft.scene().Q(), &M = draft.scene().M();
  auto& epsilon = draft.given().epsilon;
  if (!epsilon) epsilon = unit_epsilon(M);
  auto P = right ? Psi_right_inverse(Q, M, *epsilon) : Psi_inverse(Q, M, *epsilon);
  if (!P)
    return draft.refuse("epsilon", to_text(*epsilon),
                        "epsilon ‖M‖_op = " + to_text(P.error().value) + " must be < 2; without " +
                            "epsilon the scene takes " + to_text(unit_epsilon(M)));
  draft.set_block("P", std::move(*P));
}

void check_left(SceneDraft& draft) { check_symmetric(draft, false); }
void check_right(SceneDraft& draft) { check_symmetric(draft, true); }

/// Reads (Q, P) by Ψ.
WithinDomain<Phase> read_pair(const Scene& scene, const Dense& Q, const Dense& P,
                              Margins& margins) {
  margins.push_back({"S", margin_S(Q, P)});
  margins.push_back({"Re spec(Q^T P) > 0", principal_cosine(Q, P)});
  Dense M = Psi(Q, P, scene.epsilon());
  add_condition(M, inverse_condition_Psi(M, scene.epsilon()), margins);
  return phase_of_body(scene, Q, std::move(M));
}
WithinDomain<Phase> read(const Scene& scene, Margins& margins) {
  return read_pair(scene, scene.Q(), scene.block("P"), margins);
}
WithinDomain<Phase> read_right(const Scene& scene, Margins& margins) {
  return read_pair(scene, scene.Q().transpose(), scene.block("P").transpose(), margins);
}

/// Writes (Q, P) by Ψ⁻¹, with the ε of the target, or chosen for M.
WithinDomain<Expression> write(const Phase& x, const ConversionTarget& target, Margins& margins) {
  const double epsilon = target.epsilon.value_or(unit_epsilon(x.M));
  auto P = Psi_inverse(x.Q, x.M, epsilon);
  if (!P) return outside(P.error(), "epsilon");
  margins.push_back({"S_M", margin_S_M(x.M, epsilon)});
  add_condition(x.M, inverse_condition_Psi(x.M, epsilon), margins);
  return Expression{{{"Q", x.Q}, {"P", std::move(*P)}}, epsilon};
}
WithinDomain<Expression> write_right(const Phase& x, const ConversionTarget& target,
                                     Margins& margins) {
  auto out = write(x, target, margins);
  if (out)
    for (auto& [name, block] : out->blocks) block.transposeInPlace();
  return out;
}

constexpr Representation left_pair = {
    .square = true, .read = read, .write = write, .has_epsilon = true};
constexpr Representation right_pair = {
    .square = true, .read = read_right, .write = write_right, .has_epsilon = true};

constexpr auto start = [](const auto& g) {
  const auto Q = g.block("Q");
  return g.start(Q, Psi(Q, g.block("P"), g.epsilon));
};
constexpr auto start_on_the_right = [](const auto& g) {
  const decltype(g.block("Q")) Q = g.block("Q").transpose(), P = g.block("P").transpose();
  auto of_left = g.start(Q, Psi(Q, P, g.epsilon));
  of_left.presentation.right = true;
  return of_left;
};

constexpr TwoForm form = {
    {"Omega_gl", {"Q", "P"}, "1/2 tr(eta_2^T xi_1 - eta_1^T xi_2) of (xi_i, eta_i)", "[RB] (3.5)"},
    {"Q", "P"},
    [](const Scene&) { return space_of(PairsOfRotations<double>()); }};

}  // namespace

SystemEntry symmetric_family(Side side) {
  const bool left = side == Side::left;
  const BlockInfo P = {
      "P", "N x N", false,
      left ? "costate, Q^T P - P^T Q = epsilon M" : "costate, P Q^T - Q P^T = epsilon M"};
  return {.info = rigid_form_info(P, true, side),
          .check = left ? check_left : check_right,
          .two_forms = {&form},
          .representation = left ? &left_pair : &right_pair,
          .motion =
              left ? &in_both<body_equations, start> : &in_both<body_equations, start_on_the_right>,
          .rate = Rate::angular_speed};
}

bool check_symmetric_frame(SceneDraft& draft) {
  draft.refuse_if(draft.given().body.has_value(), "body");
  draft.refuse_if(!draft.given().inertia_u.empty(), "inertia_u");
  draft.refuse_if(!draft.given().inertia_v.empty(), "inertia_v");
  draft.refuse_if(draft.given().parameter.has_value(), "parameter");
  if (!draft.set_inertia()) return false;
  draft.check_inertia_sums();
  draft.check_block_names();
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* Q = draft.block("Q", N, N)) draft.set_frame("Q", *Q);
  return draft.sound();
}

bool check_either(SceneDraft& draft, const std::string& one, const std::string& other) {
  if (draft.has_block(one) != draft.has_block(other)) return true;
  draft.refuse("initial", draft.has_block(one) ? one + " and " + other : "neither",
               "must hold exactly one of " + one + " and " + other);
  return false;
}

void check_symmetric(SceneDraft& draft, bool right, std::optional<double> of_paper) {
  if (!check_symmetric_frame(draft)) return;
  auto& epsilon = draft.given().epsilon;
  if (epsilon && !(std::isfinite(*epsilon) && *epsilon != 0))
    return draft.refuse("epsilon", to_text(*epsilon), "must be finite and not 0");
  if (!check_either(draft, "P", "M")) return;
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* M = draft.block("M", N, N, false)) set_P_of_M(draft, *M, right);
  if (const RowMatrix* P = draft.block("P", N, N, false)) {
    if (!epsilon) epsilon = of_paper.value_or(1);
    if (!draft.sound()) return;
    const Eigen::MatrixXd& Q = draft.scene().Q();
    const Eigen::MatrixXd M =
        right ? Psi_right<double>(Q, *P, *epsilon) : Psi<double>(Q, *P, *epsilon);
    if (draft.check_momentum("initial.P", M)) draft.set_block("P", *P);
  }
}

BodyView view_of_pair(const Scene& scene) {
  using Pair = std::pair<Dense, Dense>;
  const Eigen::Index N = scene.dimension();
  const bool right = system_entry(scene.system())->info.side == Side::right;
  const auto left = [=](const Dense& top, const Dense& bottom) {
    return right ? Pair(top.transpose(), bottom.transpose()) : Pair(top, bottom);
  };
  const auto over = [=](const Dense& top, const Dense& bottom) {
    Dense x(2 * N, N);
    x << top, bottom;
    return x;
  };
  const auto [Q_0, P_0] = left(scene.Q(), scene.block("P"));
  return {.body =
              [=, epsilon = scene.epsilon()](const Dense& x) {
                const auto [Q, P] = left(x.topRows(N), x.bottomRows(N));
                return over(Q, Psi(Q, P, epsilon));
              },
          .blocks =
              [=, A = constant_A(Q_0, P_0)](const Dense& x) {
                const Dense Q = x.topRows(N);
                const auto [top, bottom] = left(Q, A * Q);
                return over(top, bottom);
              }};
}

void as_view_of_pair(SystemEntry& entry) {
  // The view holds PQᵀ as a constant, so that its drift is 0 by construction.
  std::erase_if(entry.info.invariants, [](const auto& i) { return i.name == family::PQt; });
  entry.two_forms = {};  // a form needs states with every P, the view has those with one PQᵀ
  entry.recommended = for_views;
  entry.view = view_of_pair;
  entry.priced_as = "rigid_body";
  entry.packs = &body_packs;
  entry.rates = &body_rates;
}

StackedObservables symmetric_observables(const Scene& scene) {
  const int N = scene.dimension();
  const double epsilon = scene.epsilon();
  StackedObservables observables(stacked(scene, "Q", "P"));
  observables.block("Q", 0, N).block("P", N, N);
  report_rigid_form(
      observables, scene,
      {.Q = [N](const auto& x) { return x.topRows(N).eval(); },
       .M = [=](const auto& x) { return Psi<double>(x.topRows(N), x.bottomRows(N), epsilon); },
       .A = [N](const auto& x) { return constant_A<double>(x.topRows(N), x.bottomRows(N)); },
       .scaled = true,
       // The size of the matrices whose difference is M, since ‖Q‖_op = 1.
       .terms = [=](const auto& x) { return x.bottomRows(N).stableNorm() / std::abs(epsilon); }});
  return observables;
}

}  // namespace stiefel
