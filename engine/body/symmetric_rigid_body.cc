// The systems of (Q, P): the symmetric representation, left- and right-invariant, reduced,
// discrete.
#include <cmath>

#include "engine/body/psi.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_forms.h"
#include "engine/body/rigid_tangents.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/two_form.h"
#include "engine/scene/scene_draft.h"
#include "engine/structure/tangent_spaces.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

/// A form of (Q, P), left- or right-invariant: the right one is the left one with Qᵀ, Pᵀ and −M,
/// [RB] Prop. 2.1, 3.4.
template <bool on_the_right>
struct Pair : OtherVariables<Pair<on_the_right>> {
  static constexpr const char* names[] = {"Q", "P"};
  static constexpr bool right = on_the_right;

  template <class Block>
  static Block left(const Block& block) {
    if constexpr (right)
      return block.transpose();
    else
      return block;
  }

  static void check(SceneDraft& draft) { check_pair(draft, 1); }
  /// Checks Λ for n = N and (Q, P) or (Q, M). Fills in the blocks Q and P, and `epsilon` if it is
  /// absent: with P it is `of_paper`; with M it is the power of two with ½ < ε‖M‖_op ≤ 1 (psi.h).
  static void check_pair(SceneDraft& draft, double of_paper) {
    if (!check_symmetric_frame(draft, true)) return;
    auto& epsilon = draft.given().epsilon;
    if (epsilon && !(std::isfinite(*epsilon) && *epsilon != 0))
      return draft.refuse("epsilon", to_text(*epsilon), "must be finite and not 0");
    if (!check_either(draft, "P", "M")) return;
    const Eigen::Index N = draft.scene().dimension();
    if (const RowMatrix* M = draft.block("M", N, N, false)) set_P_of_M(draft, *M);
    if (const RowMatrix* P = draft.block("P", N, N, false)) {
      if (!epsilon) epsilon = of_paper;
      if (!draft.sound()) return;
      const Dense M = Psi<double>(left(draft.scene().Q()), left<Dense>(*P), *epsilon);
      if (draft.check_momentum("initial.P", M)) draft.set_block("P", *P);
    }
  }
  static void set_P_of_M(SceneDraft& draft, const RowMatrix& given_M) {
    draft.set_skew("M", given_M);
    if (!draft.sound()) return;
    const Dense M = right ? Dense(-draft.scene().M()) : draft.scene().M();
    auto& epsilon = draft.given().epsilon;
    if (!epsilon) epsilon = unit_epsilon(M);
    const auto P = Psi_inverse(left(draft.scene().Q()), M, *epsilon);
    if (!P)
      return draft.refuse("epsilon", to_text(*epsilon),
                          "epsilon ‖M‖_op = " + to_text(P.error().value) +
                              " must be < 2; without " + "epsilon the scene takes " +
                              to_text(unit_epsilon(M)));
    draft.set_block("P", left(*P));
  }

  template <class Block>
  static std::array<Block, 2> body(const Block& Q, const Block& P, const auto& g) {
    return {left(Q), Psi(left(Q), left(P), g.epsilon)};
  }
  /// P = AQ with the constant A = PQᵀ of the scene, [RB] (8.2).
  static auto blocks(const Scene& scene) {
    return [A = constant_A<double>(left(scene.Q()), left(scene.block("P")))](
               const BodyView::Two& x) -> BodyView::Two {
      return {left(x[0]), left<Dense>(A * x[0])};
    };
  }

  /// Along a view P = AQ with δA = δ(P_0 Q_0ᵀ).
  static ViewTangent tangent(const Scene& scene) {
    using Two = BodyView::Two;
    return {
        [epsilon = scene.epsilon()](const Two& x, const Two& dx, const auto&) -> Two {
          return {left(dx[0]),
                  Psi(left(dx[0]), left(x[1]), epsilon) + Psi(left(x[0]), left(dx[1]), epsilon)};
        },
        [](const Two& x, const Two& dx, const Two& y, const Two& dy, const auto&) -> Two {
          const Dense Q = left(x[0]), P = left(x[1]),
                      dA = constant_A<double>(left(dx[0]), P) + constant_A<double>(Q, left(dx[1]));
          return {left(dy[0]), left<Dense>(dA * y[0] + constant_A(Q, P) * dy[0])};
        }};
  }
  static constexpr Tangents tangents = {
      [](const Scene&) { return TangentSpace{tangent_to_pairs<double>}; }, tangents_of_bodies,
      tangent};

  /// Reads (Q, P) by Ψ.
  static WithinDomain<Phase> read(const Scene& scene, Margins& margins) {
    Phase x = Pair::phase(scene);
    const Dense P = left(scene.block("P"));
    margins.push_back({"S", margin_S(x.Q, P)});
    margins.push_back({"Re spec(Q^T P) > 0", principal_cosine(x.Q, P)});
    add_condition(x.M, inverse_condition_Psi(x.M, scene.epsilon()), margins);
    return x;
  }

  /// Writes (Q, P) by Ψ⁻¹, with the ε of the target, or chosen for M.
  static WithinDomain<FormBlocks> write(const Phase& x, const ConversionTarget& target,
                                        Margins& margins) {
    const double epsilon = target.epsilon.value_or(unit_epsilon(x.M));
    const auto P = Psi_inverse(x.Q, x.M, epsilon);
    if (!P) return outside(P.error(), "epsilon");
    margins.push_back({"S_M", margin_S_M(x.M, epsilon)});
    add_condition(x.M, inverse_condition_Psi(x.M, epsilon), margins);
    return FormBlocks{{{"Q", left(x.Q)}, {"P", left(*P)}}, epsilon};
  }

  static constexpr Representation representation = {
      .square = true, .read = read, .write = write, .has_epsilon = true};

  static SystemInfo info() {
    const BlockInfo P = {
        "P", "N x N", false,
        right ? "costate, P Q^T - Q P^T = epsilon M" : "costate, Q^T P - P^T Q = epsilon M"};
    return rigid_form_info(P, true, right ? Side::right : Side::left);
  }

  /// Returns the entry of a view, which has neither the two-form, whose states have every P and not
  /// those of one PQᵀ alone, nor the drift of PQᵀ, which is 0 by construction.
  static SystemEntry view_entry(SystemInfo info) {
    std::erase_if(info.invariants, [](const auto& i) { return i.name == family::PQt; });
    SystemEntry entry = Pair::entry(std::move(info));
    entry.tangents = &tangents;
    return entry;
  }
};

constexpr TwoForm form_of_symmetric = {
    {"Omega_gl", {"Q", "P"}, "1/2 tr(eta_2^T xi_1 - eta_1^T xi_2) of (xi_i, eta_i)", "[RB] (3.5)"},
    {"Q", "P"},
    [](const Scene& s) {
      return space_of(PairsOfRotations<double>{Eigen::VectorXd::Ones(s.dimension())});
    }};

/// Returns the observables of (Q, P), stacked to 2N × N: the blocks, M = (QᵀP − PᵀQ)/ε, the
/// constant PQᵀ, and the invariants of M.
Observables symmetric_observables(const Scene& scene) {
  const int N = scene.dimension();
  const double epsilon = scene.epsilon();
  Observables observables(stacked(scene, "Q", "P"));
  observables.block("Q", 0, N).block("P", N, N);
  const RigidForm of_blocks = {
      .Q = [N](const auto& x) { return x.topRows(N).eval(); },
      .M = [=](const auto& x) { return Psi<double>(x.topRows(N), x.bottomRows(N), epsilon); },
      .A = [N](const auto& x) { return constant_A<double>(x.topRows(N), x.bottomRows(N)); },
      .scaled = true,
      // The size of the matrices whose difference is M, since ‖Q‖_op = 1.
      .terms = [=](const auto& x) { return x.bottomRows(N).stableNorm() / std::abs(epsilon); }};
  report_rigid_form(observables, scene, of_blocks);
  return observables;
}

std::unique_ptr<Simulation> make_symmetric_rigid_body(const Scene& scene) {
  return make_simulation<Variational, Exact>(
      scene, SymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
      shared(symmetric_observables(scene)));
}

std::unique_ptr<Simulation> make_symmetric_moser_veselov(const Scene& scene) {
  return make_simulation_by<Variational>(
      scene, SymmetricRigidBody<double>(scene.inertia(), scene.epsilon()),
      shared(symmetric_observables(scene)));
}

constexpr auto reduced_start = [](const auto& g) {
  using Block = decltype(g.block("Q"));
  const Block Q = g.block("Q"), A = constant_A(Q, g.block("P")), of_m = A - A.transpose();
  return g.start(Q, Q.transpose() * of_m * Q / g.epsilon);
};

}  // namespace

bool check_symmetric_frame(SceneDraft& draft, bool has_epsilon) {
  if (!check_square_inertia(draft, has_epsilon, false)) return false;
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

SystemEntry symmetric_rigid_body_entry() {
  SystemInfo info = Pair<false>::info();
  info.name = "symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body";
  info.equations = "Q' = Q Omega, P' = P Omega, M = (Q^T P - P^T Q) / epsilon";
  info.source = "[RB] (3.1), Prop. 3.13";
  info.file = "engine/body/symmetric_rigid_body.h";
  return {.info = info,
          .check = Pair<false>::check,
          .make = make_symmetric_rigid_body,
          .methods = methods_on<SymmetricRigidBody<double>, Variational, Exact>,
          .recommended = for_products,
          .two_forms = {&form_of_symmetric},
          .dirac_bracket = true,
          .representation = &Pair<false>::representation,
          .motion = &in_both<body_equations, Pair<false>::Start{}>,
          .rate = Rate::angular_speed};
}

SystemEntry right_symmetric_rigid_body_entry() {
  SystemInfo info = Pair<true>::info();
  info.name = "right_symmetric_rigid_body";
  info.summary = "symmetric representation of the rigid body, right-invariant";
  info.equations = "Q' = Omega Q, P' = Omega P, M = (P Q^T - Q P^T) / epsilon";
  info.source = "[RB] Prop. 3.4";
  info.file = "engine/body/symmetric_rigid_body.cc";
  return Pair<true>::view_entry(std::move(info));
}

SystemEntry reduced_rigid_body_entry() {
  SystemInfo info = Pair<false>::info();
  info.name = "reduced_rigid_body";
  info.summary = "symmetric representation with its constant P Q^T taken out";
  info.equations = "Q' = Q J^-1(Q^T (A - A^T) Q) / epsilon, A = P Q^T constant, P = A Q";
  info.source = "[RB] (8.2)";
  info.file = "engine/body/symmetric_rigid_body.cc";
  SystemEntry entry = Pair<false>::view_entry(std::move(info));
  entry.motion = &in_both<body_equations, reduced_start>;
  return entry;
}

SystemEntry symmetric_moser_veselov_entry() {
  SystemEntry entry = symmetric_rigid_body_entry();
  SystemInfo& info = entry.info;
  info.name = "symmetric_moser_veselov";
  info.summary = "symmetric representation of the discrete rigid body";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, P_{k+1} = P_k U";
  info.source = "[RB] (4.7)";
  info.file = "engine/body/symmetric_rigid_body.h";
  info.discrete = true;
  info.velocity = {};
  info.invariants.push_back(discrete_hamiltonian_info);
  entry.check = [](SceneDraft& draft) { Pair<false>::check_pair(draft, draft.step()); };
  entry.make = make_symmetric_moser_veselov;
  entry.methods = keeps_all;
  entry.recommended = {};
  return entry;
}

}  // namespace stiefel
