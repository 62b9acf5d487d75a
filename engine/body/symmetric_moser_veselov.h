#pragma once

#include "engine/body/discrete_blocks.h"

namespace stiefel {

/// The symmetric representation of the discrete rigid body, [RB] (4.7) = (SDRBn), for the step h,
/// with P scaled so that it belongs to εM (Prop. 3.13):
///
///     UΛ − ΛUᵀ = hM,   M = (QᵀP − PᵀQ)/ε,
///     Q_{k+1} = Q_k U,   P_{k+1} = P_k U.
///
/// ε = h gives the paper's own variables, in which h does not appear. On SO(N) × SO(N) it is the
/// Moser–Veselov map of (Q, M), and it keeps PQᵀ. Ends with left_domain where there is no U. State:
/// Q over P, 2N × N.
class SymmetricMoserVeselov : public DiscreteBlocks<SymmetricMoserVeselov> {
 public:
  SymmetricMoserVeselov(const Eigen::VectorXd& lambda, double h, double epsilon,
                        Arithmetic arithmetic = Arithmetic::compensated)
      : DiscreteBlocks(lambda, h, arithmetic), epsilon_(epsilon) {}

  void form_momentum(const Point& x, Point& M) const {
    M.noalias() = x.topRows(N_).transpose() * x.bottomRows(N_);
    M /= epsilon_;
  }

 private:
  double epsilon_;
};

}  // namespace stiefel
