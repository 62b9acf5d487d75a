#include "engine/body/discrete_pairs.h"
#include "engine/body/interpolation.h"
#include "engine/body/psi.h"
#include "engine/motion/representation.h"

namespace stiefel {
namespace {

/// Writes [RB] (7.15)–(7.21) in the paper's variables.
WithinDomain<FormBlocks> write(const Phase& x, const ConversionTarget&, Margins& margins) {
  auto P = Psi_inverse(x.Q, x.M, x.step);
  if (!P) return outside(P.error(), "step");
  auto before = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!before) return outside(before.error(), "step");
  const auto U = J_D_inverse(x.lambda, x.step * x.M);
  if (!U) return outside(U.error(), "step");
  const Eigen::MatrixXd next = x.Q * *U;
  margins.push_back({"S_L", margin_S_L(x.lambda, *before, x.Q)});
  margins.push_back({"E_L", margin_E_L(x.lambda, before->transpose() * x.Q)});
  FormBlocks out{{{"Q", x.Q}, {"Q_next", next}}};
  out.blocks["Sigma"] = weight_behind(x.lambda, *before, x.Q, *P);
  out.blocks["Lambda_k"] = weight_ahead(x.lambda, x.Q, *P, next);
  out.blocks["Q_prev"] = std::move(*before);
  out.blocks["P"] = std::move(*P);
  return out;
}

}  // namespace

constinit const Representation representations::interpolation = {
    .square = true, .read = nullptr, .write = write};

}  // namespace stiefel
