#include "engine/linalg/lie/orthogonal.h"
#include "engine/rigid_body/moser_veselov/discrete_pairs.h"
#include "engine/rigid_body/moser_veselov/interpolation.h"
#include "engine/rigid_body/moser_veselov/j_d_inverse.h"
#include "engine/rigid_body/symmetric/left_right.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel_blocks.h"
#include "engine/parametric/parametric_psi.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/body/rigid_velocity.h"
#include "engine/rigid_body/symmetric/scaling.h"
#include "engine/catalogue/representations/phase.h"
#include "engine/catalogue/representations/representations.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

Phase phase(const Scene& scene, Dense Q, Dense M) {
  return {scene.inertia(), scene.step(), std::move(Q), std::move(M), {}};
}

/// Adds the margin of the blocks as a representation of M ≠ 0: the relative error of M is that of
/// the blocks divided by this margin. M = 0 is exact.
void add_condition(const Dense& M, double inverse_condition, Margins& margins) {
  if (!M.isZero(0)) margins.push_back({"1/condition of M", inverse_condition});
}

WithinDomain<Phase> read_momentum(const Scene& scene, Margins&) {
  return phase(scene, scene.Q(), scene.M());
}
WithinDomain<Expression> write_momentum(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"M", x.M}}};
}

/// Reads the right-invariant body, [RB] Prop. 2.1.
WithinDomain<Phase> read_right(const Scene& scene, Margins&) {
  return phase(scene, scene.Q().transpose(), -scene.M());
}
WithinDomain<Expression> write_right(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q.transpose()}, {"M", -x.M}}};
}

/// Reads (Q, P) by Ψ.
WithinDomain<Phase> read_pair(const Scene& scene, const Dense& Q, const Dense& P,
                              Margins& margins) {
  margins.push_back({"S", margin_S(Q, P)});
  margins.push_back({"Re spec(Q^T P) > 0", principal_cosine(Q, P)});
  Dense M = Psi(Q, P, scene.epsilon());
  add_condition(M, inverse_condition_Psi(M, scene.epsilon()), margins);
  return phase(scene, Q, std::move(M));
}
WithinDomain<Phase> read_symmetric(const Scene& scene, Margins& margins) {
  return read_pair(scene, scene.Q(), scene.block("P"), margins);
}
WithinDomain<Phase> read_right_symmetric(const Scene& scene, Margins& margins) {
  return read_pair(scene, scene.Q().transpose(), scene.block("P").transpose(), margins);
}

/// Writes (Q, P) by Ψ⁻¹, with the ε of the target, or chosen for M.
WithinDomain<Expression> write_symmetric(const Phase& x, const ConversionTarget& target,
                                         Margins& margins) {
  const double epsilon = target.epsilon.value_or(unit_epsilon(x.M));
  auto P = Psi_inverse(x.Q, x.M, epsilon);
  if (!P) return outside(P.error(), "epsilon");
  margins.push_back({"S_M", margin_S_M(x.M, epsilon)});
  add_condition(x.M, inverse_condition_Psi(x.M, epsilon), margins);
  return Expression{{{"Q", x.Q}, {"P", std::move(*P)}}, epsilon};
}
WithinDomain<Expression> write_right_symmetric(const Phase& x, const ConversionTarget& target,
                                               Margins& margins) {
  auto out = write_symmetric(x, target, margins);
  if (out)
    for (auto& [name, block] : out->blocks) block.transposeInPlace();
  return out;
}

/// Reads (Q, B), [RB] (5.5).
WithinDomain<Phase> read_mclachlan_scovel(const Scene& scene, Margins&) {
  return phase(scene, scene.Q(), M_of_B(scene.Q(), scene.block("B")));
}
WithinDomain<Expression> write_mclachlan_scovel(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"B", B_of_M(x.Q, x.M)}}};
}

/// Reads two frames by Σ_L.
WithinDomain<Phase> read_two_frames(const Scene& scene, Margins& margins) {
  const Dense &Q_prev = scene.block("Q_prev"), &Q = scene.Q();
  margins.push_back({"S_L", margin_S_L(scene.inertia(), Q_prev, Q)});
  margins.push_back({"E_L", margin_E_L(scene.inertia(), Q_prev.transpose() * Q)});
  Dense M = Sigma_L(scene.inertia(), Q_prev, Q, scene.step());
  add_condition(M, inverse_condition_Sigma_L(scene.inertia(), M, scene.step()), margins);
  return phase(scene, Q, std::move(M));
}
WithinDomain<Expression> write_two_frames(const Phase& x, const ConversionTarget&,
                                          Margins& margins) {
  auto Q_prev = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!Q_prev) return outside(Q_prev.error(), "step");
  margins.push_back({"S_L", margin_S_L(x.lambda, *Q_prev, x.Q)});
  margins.push_back({"E_L", margin_E_L(x.lambda, Q_prev->transpose() * x.Q)});
  add_condition(x.M, inverse_condition_Sigma_L(x.lambda, x.M, x.step), margins);
  return Expression{{{"Q_prev", std::move(*Q_prev)}, {"Q", x.Q}}};
}

/// Reads (Q, P) with parameter, [RB] (8.5), (8.10). h = 1 for the flow.
WithinDomain<Phase> read_parametric(const Scene& scene, Margins& margins) {
  const Dense &Q = scene.Q(), &P = scene.block("P");
  const double defect = orthogonality_defect(Q);
  if (!(defect <= Scene::frame_tolerance))
    return outside({"O(N)", defect, Scene::frame_tolerance}, "initial.Q");
  Dense M = parametric_Psi(Q, P, scene.epsilon());
  add_condition(M, inverse_condition_parametric(Q, P, M, scene.epsilon()), margins);
  return phase(scene, Q, std::move(M));
}
WithinDomain<Expression> write_parametric_with(double h, const Phase& x,
                                               const ConversionTarget& target, Margins& margins) {
  const double mu = target.parameter.value_or(0);
  const double epsilon = target.epsilon.value_or(parametric_epsilon(x.lambda, x.M, mu / h));
  auto P = parametric_Psi_inverse(x.lambda, x.Q, x.M, mu / h, epsilon);
  if (!P) return outside(P.error(), target.epsilon ? "epsilon" : "parameter");
  margins.push_back({"S_M^mu", margin_parametric(x.lambda, x.M, mu / h, epsilon)});
  add_condition(x.M, inverse_condition_parametric(x.Q, *P, x.M, epsilon), margins);
  return Expression{{{"Q", x.Q}, {"P", std::move(*P)}}, epsilon, mu};
}
WithinDomain<Expression> write_parametric(const Phase& x, const ConversionTarget& target,
                                          Margins& margins) {
  return write_parametric_with(1, x, target, margins);
}
WithinDomain<Expression> write_discrete_parametric(const Phase& x, const ConversionTarget& target,
                                                   Margins& margins) {
  return write_parametric_with(x.step, x, target, margins);
}

/// Writes [RB] (7.15)–(7.21) in the paper's variables.
WithinDomain<Expression> write_interpolation(const Phase& x, const ConversionTarget&,
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
  Expression out{{{"Q", x.Q}, {"Q_next", next}}};
  out.blocks["Sigma"] = weight_behind(x.lambda, *before, x.Q, *P);
  out.blocks["Lambda_k"] = weight_ahead(x.lambda, x.Q, *P, next);
  out.blocks["Q_prev"] = std::move(*before);
  out.blocks["P"] = std::move(*P);
  return out;
}

}  // namespace

namespace representation {
constinit const Representation body = {true, read_momentum, write_momentum};
constinit const Representation right_body = {true, read_right, write_right};
constinit const Representation symmetric_body = {
    .square = true, .read = read_symmetric, .write = write_symmetric, .has_epsilon = true};
constinit const Representation right_symmetric_body = {.square = true,
                                                       .read = read_right_symmetric,
                                                       .write = write_right_symmetric,
                                                       .has_epsilon = true};
constinit const Representation mclachlan_scovel = {true, read_mclachlan_scovel,
                                                   write_mclachlan_scovel};
constinit const Representation two_frames = {true, read_two_frames, write_two_frames};
constinit const Representation parametric_body = {.square = true,
                                                  .read = read_parametric,
                                                  .write = write_parametric,
                                                  .has_epsilon = true,
                                                  .has_parameter = true};
constinit const Representation discrete_parametric_body = {.square = true,
                                                           .read = read_parametric,
                                                           .write = write_discrete_parametric,
                                                           .has_epsilon = true,
                                                           .has_parameter = true};
constinit const Representation interpolation = {true, nullptr, write_interpolation};
}  // namespace representation

}  // namespace stiefel
