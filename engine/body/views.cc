// The rigid body in other variables: right-invariant, of McLachlan and Scovel, and as two frames.

#include "engine/body/discrete_pairs.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_forms.h"
#include "engine/body/rigid_tangents.h"
#include "engine/motion/method_entry.h"
#include "engine/motion/two_form.h"
#include "engine/scene/scene_draft.h"
#include "engine/structure/tangent_spaces.h"

namespace stiefel {
namespace {

using Two = BodyView::Two;

/// The motion is that of the left-invariant body with Qᵀ and −M, [RB] Prop. 2.1.
struct RightBody : OtherVariables<RightBody> {
  static constexpr const char* names[] = {"Q", "M"};
  static constexpr bool right = true;

  static void check(SceneDraft& draft) { check_rigid_body(draft, true); }
  template <class Block>
  static std::array<Block, 2> body(const Block& Q, const Block& M, const auto&) {
    return {Q.transpose(), -M};
  }
  static auto blocks(const Scene&) {
    return [](const Two& x) -> Two { return {x[0].transpose(), -x[1]}; };
  }
  static ViewTangent tangent(const Scene&) {
    const auto other = [](const Two& x) -> Two { return {x[0].transpose(), -x[1]}; };
    return {
        [=](const Two&, const Two& dx, const auto&) { return other(dx); },
        [=](const Two&, const Two&, const Two&, const Two& dy, const auto&) { return other(dy); }};
  }
  static constexpr Representation representation = {
      true, [](const Scene& scene, Margins&) { return WithinDomain<Phase>(phase(scene)); },
      [](const Phase& x, const ConversionTarget&, Margins&) {
        return WithinDomain<FormBlocks>({{{"Q", x.Q.transpose()}, {"M", -x.M}}});
      }};
};

/// B = QM, [RB] (5.5). QᵀB is skew for every B that belongs to a momentum; M is its skew part.
struct McLachlanScovel : OtherVariables<McLachlanScovel> {
  static constexpr const char* names[] = {"Q", "B"};

  /// Checks (Q, B) with QᵀB skew, or (Q, M).
  static void check(SceneDraft& draft) {
    if (!check_symmetric_frame(draft, false) || !check_either(draft, "B", "M")) return;
    const Dense& Q = draft.scene().Q();
    const Eigen::Index N = Q.rows();
    if (const RowMatrix* M = draft.block("M", N, N, false)) {
      draft.set_skew("M", *M);
      if (draft.sound()) draft.set_block("B", Q * draft.scene().M());
    }
    if (const RowMatrix* B = draft.block("B", N, N, false)) {
      const Dense R = Q.transpose() * *B;
      const double defect = (R + R.transpose()).cwiseAbs().maxCoeff();
      // The bound is no stricter than that on Q, which may have been repaired.
      if (!(defect <= draft.largest_repair() * B->cwiseAbs().maxCoeff()))
        return draft.refuse("initial.B", "max |QᵀB + BᵀQ| = " + to_text(defect),
                            "QᵀB must be skew-symmetric to " + to_text(draft.largest_repair()));
      const Dense M = (R - R.transpose()) / 2;
      if (draft.check_momentum("initial.B", M)) draft.set_block("B", Q * M);
    }
  }
  template <class Block>
  static std::array<Block, 2> body(const Block& Q, const Block& B, const auto&) {
    const Block R = Q.transpose() * B;
    return {Q, (R - R.transpose()) / 2};
  }
  static auto blocks(const Scene&) {
    return [](const Two& x) -> Two { return {x[0], x[0] * x[1]}; };
  }
  static ViewTangent tangent(const Scene&) {
    return {[](const Two& x, const Two& dx, const auto&) -> Two {
              return {dx[0], body(dx[0], x[1], 0)[1] + body(x[0], dx[1], 0)[1]};
            },
            [](const Two&, const Two&, const Two& y, const Two& dy, const auto&) -> Two {
              return {dy[0], dy[0] * y[1] + y[0] * dy[1]};
            }};
  }
  /// Returns vectors (δQ, δQ M + Q δM).
  static Dense tangent_part(const Dense& x, const Dense& G) {
    const Dense Q = x.topRows(x.cols()), dQ = tangent_to_frames<double>(Q, G.topRows(x.cols())),
                of_Q = dQ * Q.transpose() * x.bottomRows(x.cols());
    return stacked_pair<double>(dQ, of_Q + Q * body(Q, Dense(G.bottomRows(x.cols()) - of_Q), 0)[1]);
  }
  static constexpr Representation representation = {
      true, [](const Scene& scene, Margins&) { return WithinDomain<Phase>(phase(scene)); },
      [](const Phase& x, const ConversionTarget&, Margins&) {
        return WithinDomain<FormBlocks>({{{"Q", x.Q}, {"B", x.Q * x.M}}});
      }};
};

/// Two consecutive frames: M_k = Σ_L(Q_{k−1}, Q_k).
struct Frames : OtherVariables<Frames> {
  static constexpr const char* names[] = {"Q_prev", "Q"};

  static void check(SceneDraft& draft) {
    if (!check_square_inertia(draft, false, false)) return;
    const Eigen::Index N = draft.scene().dimension();
    for (const char* name : names)
      if (const RowMatrix* Q = draft.block(name, N, N)) draft.set_frame(name, *Q);
  }
  template <class Block>
  static std::array<Block, 2> body(const Block& Q_prev, const Block& Q, const auto& g) {
    return {Q, Sigma_L(g.lambda, Q_prev, Q, g.step)};
  }
  /// Q_{k−1} = Σ_L⁻¹(Q_k, M_k) is not a number where rounding has moved M_k beyond the edge of the
  /// domain.
  static auto blocks(const Scene& scene) {
    return [lambda = scene.inertia(), h = scene.step()](const Two& x) -> Two {
      const auto Q_prev = Sigma_L_inverse(lambda, x[0], x[1], h);
      return {Q_prev.value_or(Dense::Constant(x[0].rows(), x[0].cols(), std::nan(""))), x[0]};
    };
  }
  /// With V = Q_{k−1}ᵀQ_k, δV = Vυ: ΛVυ + υVᵀΛ = δ(hM) − δΛV + VᵀδΛ.
  static ViewTangent tangent(const Scene& scene) {
    return {[lambda = scene.inertia(), h = scene.step()](const Two& x, const Two& dx,
                                                         const auto& along) -> Two {
              return {dx[1], Sigma_L(lambda, dx[0], x[1], h) + Sigma_L(lambda, x[0], dx[1], h) +
                                 Sigma_L(along.lambda, x[0], x[1], h) -
                                 along.step / h * Sigma_L(lambda, x[0], x[1], h)};
            },
            [blocks = blocks(scene), lambda = scene.inertia(), h = scene.step()](
                const Two&, const Two&, const Two& y, const Two& dy, const auto& along) -> Two {
              const Dense V = blocks(y)[0].transpose() * y[0];
              const Dense of_lambda = along.lambda.asDiagonal() * V;
              Dense upsilon = h * dy[1] + along.step * y[1] - of_lambda + of_lambda.transpose();
              Lyapunov<double> equation(V.rows());
              equation.factor(V.transpose() * lambda.asDiagonal());
              equation.solve(upsilon, upsilon);
              return {(dy[0] - y[0] * upsilon) * V.transpose(), dy[0]};
            }};
  }

  static void add_margins(const Eigen::VectorXd& lambda, const Dense& Q_prev, const Dense& Q,
                          const Dense& M, double h, Margins& margins) {
    margins.push_back({"S_L", margin_S_L(lambda, Q_prev, Q)});
    margins.push_back({"E_L", margin_E_L(lambda, Q_prev.transpose() * Q)});
    add_condition(M, inverse_condition_Sigma_L(lambda, M, h), margins);
  }
  /// Reads two frames by Σ_L.
  static WithinDomain<Phase> read(const Scene& scene, Margins& margins) {
    Phase x = phase(scene);
    add_margins(x.lambda, scene.block("Q_prev"), x.Q, x.M, x.step, margins);
    return x;
  }
  static WithinDomain<FormBlocks> write(const Phase& x, const ConversionTarget&, Margins& margins) {
    auto Q_prev = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
    if (!Q_prev) return outside(Q_prev.error(), "step");
    add_margins(x.lambda, *Q_prev, x.Q, x.M, x.step, margins);
    return FormBlocks{{{"Q_prev", std::move(*Q_prev)}, {"Q", x.Q}}};
  }
  static constexpr const Representation& representation = representations::moser_veselov_pair;
};

constexpr TwoForm form_of_frames = {
    {"Omega_L",
     {"Q_prev", "Q"},
     "1/2 tr(u_1 Lambda v_2^T - v_1 Lambda u_2^T) of u = (u_1, u_2), v = (v_1, v_2)",
     "[RB] (7.8)"},
    {"Q_prev", "Q"},
    [](const Scene& s) { return space_of(PairsOfRotations<double>{s.inertia()}); }};

/// Writes [RB] (7.15)–(7.21) in the paper's variables.
WithinDomain<FormBlocks> write_interpolation(const Phase& x, const ConversionTarget&,
                                             Margins& margins) {
  auto P = Psi_inverse(x.Q, x.M, x.step);
  if (!P) return outside(P.error(), "step");
  auto before = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!before) return outside(before.error(), "step");
  const auto U = J_D_inverse(x.lambda, x.step * x.M);
  if (!U) return outside(U.error(), "step");
  const Dense next = x.Q * *U;
  margins.push_back({"S_L", margin_S_L(x.lambda, *before, x.Q)});
  margins.push_back({"E_L", margin_E_L(x.lambda, before->transpose() * x.Q)});
  FormBlocks out{{{"Q", x.Q}, {"Q_next", next}}};
  out.blocks["Sigma"] = weight_behind(x.lambda, *before, x.Q, *P);
  out.blocks["Lambda_k"] = weight_ahead(x.lambda, x.Q, *P, next);
  out.blocks["Q_prev"] = std::move(*before);
  out.blocks["P"] = std::move(*P);
  return out;
}

TangentSpace pairs_of_rotations(const Scene&) { return {tangent_to_pairs<double>}; }
constexpr Tangents of_right = {[](const Scene&) { return TangentSpace(); }, tangents_of_bodies,
                               RightBody::tangent},
                   of_mclachlan_scovel = {[](const Scene&) {
                                            return TangentSpace{McLachlanScovel::tangent_part};
                                          },
                                          tangents_of_bodies, McLachlanScovel::tangent},
                   of_frames = {pairs_of_rotations, tangents_of_maps, Frames::tangent};

}  // namespace

constinit const Representation representations::moser_veselov_pair = {
    .square = true, .read = Frames::read, .write = Frames::write};
constinit const Representation representations::interpolation = {
    .square = true, .read = nullptr, .write = write_interpolation};

SystemEntry right_rigid_body_entry() {
  SystemInfo info = rigid_form_info({"M", "N x N", true, "momentum, skew"}, false, Side::right);
  info.name = "right_rigid_body";
  info.summary = "free rigid body in N dimensions, right-invariant";
  info.equations = "Q' = Omega Q, M' = [Omega, M], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (RightRBn), Prop. 2.1";
  info.file = "engine/body/views.cc";
  SystemEntry entry = RightBody::entry(std::move(info));
  entry.tangents = &of_right;
  return entry;
}

SystemEntry mclachlan_scovel_entry() {
  SystemInfo info = rigid_form_info({"B", "N x N", false, "B = Q M, so that Q^T B is skew"}, false);
  info.name = "mclachlan_scovel";
  info.summary = "rigid body in the variables of McLachlan and Scovel";
  info.equations = "Q' = Q J^-1(Q^T B), B' = B J^-1(Q^T B), M = Q^T B";
  info.source = "[RB] (5.5)";
  info.file = "engine/body/views.cc";
  SystemEntry entry = McLachlanScovel::entry(std::move(info));
  entry.tangents = &of_mclachlan_scovel;
  return entry;
}

SystemEntry moser_veselov_pair_entry() {
  SystemInfo info = rigid_form_info({"M", "N x N", false, ""}, false);
  info.blocks = {{"Q_prev", "N x N", true, "frame one step before"},
                 {"Q", "N x N", true, "frame, orthogonal"}};
  info.fields = {{"Q_prev", "N x N", "frame one step before"},
                 {"Q", "N x N", "frame, orthogonal"},
                 {"M", "N x N", "body momentum, M = (Lambda U - U^T Lambda) / h, U = Q_prev^T Q"},
                 {"Omega", "N x N", "J^-1(M): Omega_ij = M_ij / (lambda_i + lambda_j)"}};
  info.name = "moser_veselov_pair";
  info.summary = "discrete rigid body of Moser and Veselov on pairs of frames";
  info.equations =
      "h M_k = Lambda V - V^T Lambda, V = Q_{k-1}^T Q_k, U Lambda - Lambda U^T = h M_k, "
      "Q_{k+1} = Q_k U";
  info.source = "[RB] (4.4)";
  info.file = "engine/body/views.cc";
  info.discrete = true;
  info.velocity = {};
  info.momentum = {};
  info.invariants.push_back(discrete_hamiltonian_info);
  SystemEntry entry = Frames::entry(std::move(info));
  entry.methods = keeps_all;
  entry.recommended = {};
  entry.two_forms = {&form_of_frames};
  entry.priced_as = "moser_veselov";
  entry.tangents = &of_frames;
  return entry;
}

}  // namespace stiefel
