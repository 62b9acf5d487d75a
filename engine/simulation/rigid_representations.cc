#include "engine/invariants/parametric_rigid_body.h"
#include "engine/linalg/orthogonal.h"
#include "engine/linalg/principal_root.h"
#include "engine/linalg/spectrum.h"
#include "engine/representations/discrete_pairs.h"
#include "engine/representations/interpolation.h"
#include "engine/representations/j_d_inverse.h"
#include "engine/representations/left_right.h"
#include "engine/representations/mclachlan_scovel.h"
#include "engine/representations/psi.h"
#include "engine/representations/rigid_velocity.h"
#include "engine/representations/scaling.h"
#include "engine/simulation/phase.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;

Phase phase(const Scene& scene, Dense Q, Dense M) {
  return {scene.inertia(), scene.step(), std::move(Q), std::move(M), {}};
}

WithinDomain<Phase> read_momentum(const Scene& scene, Margins&) {
  return phase(scene, scene.Q(), scene.M());
}
WithinDomain<Expression> write_momentum(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"M", x.M}}};
}

/// [RB] Prop. 2.1.
WithinDomain<Phase> read_right(const Scene& scene, Margins&) {
  return phase(scene, scene.Q().transpose(), -scene.M());
}
WithinDomain<Expression> write_right(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q.transpose()}, {"M", -x.M}}};
}

/// Ψ.
WithinDomain<Phase> read_pair(const Scene& scene, const Dense& Q, const Dense& P,
                              Margins& margins) {
  margins.push_back({"S", margin_S(Q, P)});
  margins.push_back({"Re spec(Q^T P) > 0", principal_cosine(Q, P)});
  return phase(scene, Q, Psi(Q, P, scene.epsilon()));
}
WithinDomain<Phase> read_symmetric(const Scene& scene, Margins& margins) {
  return read_pair(scene, scene.Q(), scene.block("P"), margins);
}
WithinDomain<Phase> read_right_symmetric(const Scene& scene, Margins& margins) {
  return read_pair(scene, scene.Q().transpose(), scene.block("P").transpose(), margins);
}

/// Ψ⁻¹ with the ε that is asked for, or preferred where it is well inside S_M, or chosen.
WithinDomain<Expression> write_pair(const Phase& x, const ConversionTarget& target,
                                    double preferred, Margins& margins) {
  const double chosen = margin_S_M(x.M, preferred) >= 1 ? preferred : scaling_epsilon(x.M);
  const double epsilon = target.epsilon.value_or(chosen);
  auto P = Psi_inverse(x.Q, x.M, epsilon);
  if (!P) return std::unexpected(P.error());
  margins.push_back({"S_M", margin_S_M(x.M, epsilon)});
  return Expression{{{"Q", x.Q}, {"P", std::move(*P)}}, epsilon};
}
WithinDomain<Expression> write_symmetric(const Phase& x, const ConversionTarget& target,
                                         Margins& margins) {
  return write_pair(x, target, 1, margins);
}
WithinDomain<Expression> write_discrete_symmetric(const Phase& x, const ConversionTarget& target,
                                                  Margins& margins) {
  return write_pair(x, target, x.step, margins);
}
WithinDomain<Expression> write_right_symmetric(const Phase& x, const ConversionTarget& target,
                                               Margins& margins) {
  auto out = write_pair(x, target, 1, margins);
  if (out)
    for (auto& [name, block] : out->blocks) block.transposeInPlace();
  return out;
}

/// [RB] (5.5).
WithinDomain<Phase> read_mclachlan_scovel(const Scene& scene, Margins&) {
  return phase(scene, scene.Q(), M_of_B(scene.Q(), scene.block("B")));
}
WithinDomain<Expression> write_mclachlan_scovel(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"B", B_of_M(x.Q, x.M)}}};
}

/// Σ_L.
WithinDomain<Phase> read_two_frames(const Scene& scene, Margins& margins) {
  const Dense &Q_prev = scene.block("Q_prev"), &Q = scene.Q();
  margins.push_back({"S_L", margin_S_L(scene.inertia(), Q_prev, Q)});
  margins.push_back({"E_L", margin_E_L(scene.inertia(), Q_prev.transpose() * Q)});
  return phase(scene, Q, Sigma_L(scene.inertia(), Q_prev, Q, scene.step()));
}
WithinDomain<Expression> write_two_frames(const Phase& x, const ConversionTarget&,
                                          Margins& margins) {
  auto Q_prev = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!Q_prev) return std::unexpected(Q_prev.error());
  margins.push_back({"S_L", margin_S_L(x.lambda, *Q_prev, x.Q)});
  margins.push_back({"E_L", margin_E_L(x.lambda, Q_prev->transpose() * x.Q)});
  return Expression{{{"Q_prev", std::move(*Q_prev)}, {"Q", x.Q}}};
}

/// [RB] (8.5): M_μ = Q⁻¹P − P⁻¹Q = hM + μΛ², h = 1 for the flow.
WithinDomain<Phase> read_parametric_with(double h, const Scene& scene) {
  const Dense& Q = scene.Q();
  const double defect = orthogonality_defect(Q);
  if (!(defect <= Scene::frame_tolerance))
    return std::unexpected(OutsideDomain{"O(N)", defect, Scene::frame_tolerance});
  Dense M = parametric_momentum<double>(Q, scene.block("P"));
  M.diagonal() -= scene.parameter() * scene.inertia().cwiseAbs2();
  return phase(scene, Q, M / h);
}
WithinDomain<Phase> read_parametric(const Scene& scene, Margins&) {
  return read_parametric_with(1, scene);
}
WithinDomain<Phase> read_discrete_parametric(const Scene& scene, Margins&) {
  return read_parametric_with(scene.step(), scene);
}
/// P = Q(W + (I + W²)^{1/2}), W = ½M_μ, where spec(I + W²) is off (−∞, 0].
WithinDomain<Expression> write_parametric_with(double h, const Phase& x,
                                               const ConversionTarget& target, Margins& margins) {
  const double mu = target.parameter.value_or(0);
  Dense W = h * x.M;
  W.diagonal() += mu * x.lambda.cwiseAbs2();
  W /= 2;
  const Dense square = Dense::Identity(W.rows(), W.cols()) + W * W;
  double margin = std::numeric_limits<double>::infinity();
  const auto eigenvalues = spectrum(square);
  for (const std::complex<double> z : eigenvalues)
    margin = std::min(margin, z.real() > 0 ? std::abs(z) : std::abs(z.imag()));
  if (!(margin > 1e-12)) return std::unexpected(OutsideDomain{"S_M^mu", margin, 0});
  margins.push_back({"S_M^mu", margin});
  return Expression{{{"Q", x.Q}, {"P", x.Q * (W + principal_root(square))}}, {}, mu};
}
WithinDomain<Expression> write_parametric(const Phase& x, const ConversionTarget& target,
                                          Margins& margins) {
  return write_parametric_with(1, x, target, margins);
}
WithinDomain<Expression> write_discrete_parametric(const Phase& x, const ConversionTarget& target,
                                                   Margins& margins) {
  return write_parametric_with(x.step, x, target, margins);
}

/// [RB] (7.15)–(7.21) in the paper's variables.
WithinDomain<Expression> write_interpolation(const Phase& x, const ConversionTarget&,
                                             Margins& margins) {
  auto P = Psi_inverse(x.Q, x.M, x.step);
  if (!P) return std::unexpected(P.error());
  auto before = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!before) return std::unexpected(before.error());
  const auto U = J_D_inverse(x.lambda, x.step * x.M);
  if (!U) return std::unexpected(U.error());
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

const std::vector<Representation>& rigid_representations() {
  static const std::vector<Representation> all = {
      {"rigid_body", read_momentum, write_momentum},
      {"moser_veselov", read_momentum, write_momentum},
      {"right_rigid_body", read_right, write_right},
      {"symmetric_rigid_body", read_symmetric, write_symmetric},
      {"reduced_rigid_body", read_symmetric, write_symmetric},
      {"symmetric_moser_veselov", read_symmetric, write_discrete_symmetric},
      {"right_symmetric_rigid_body", read_right_symmetric, write_right_symmetric},
      {"mclachlan_scovel", read_mclachlan_scovel, write_mclachlan_scovel},
      {"moser_veselov_pair", read_two_frames, write_two_frames},
      {"parametric_rigid_body", read_parametric, write_parametric},
      {"parametric_moser_veselov", read_discrete_parametric, write_discrete_parametric},
      {"interpolation", nullptr, write_interpolation},
  };
  return all;
}

}  // namespace stiefel
