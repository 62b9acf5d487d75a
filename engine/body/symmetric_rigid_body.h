#pragma once

#include <string_view>

#include "engine/body/exact/turned_body.h"
#include "engine/body/multiplied_blocks.h"
#include "engine/body/psi.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// The symmetric representation of the rigid body, left-invariant: [RB] (3.1) = (SRBn), with the
/// scaling of Prop. 3.13,
///
///     Q̇ = QΩ,   Ṗ = PΩ,   Ω = J⁻¹(M),   M = (QᵀP − PᵀQ)/ε.
///
/// On SO(N) × SO(N) it is the rigid body with ‖M‖_op ≤ 2/ε. The motion keeps PQᵀ, hence m = QMQᵀ =
/// (PQᵀ − QPᵀ)/ε, the energy and every other invariant of the rigid body. State: Q over P, 2N × N.
/// SO(N) acts from the right on both blocks, x ↦ x exp Θ.
template <class Scalar>
class SymmetricRigidBody
    : public MultipliedBlocks<SymmetricRigidBody<Scalar>, Scalar, MatrixKind::skew> {
 public:
  using Base = MultipliedBlocks<SymmetricRigidBody, Scalar, MatrixKind::skew>;
  using typename Base::Algebra, typename Base::State;
  static constexpr const char* name = "symmetric_rigid_body";

  explicit SymmetricRigidBody(Vector<Scalar> lambda, Scalar epsilon = 1)
      : Base(std::move(lambda), epsilon) {}

  /// Whether an invariant is constant along the orbits of the group: functions of PQᵀ and of QQᵀ
  /// are, and both are quadratic in the state.
  static constexpr bool conserved_on_orbits(std::string_view invariant) {
    return invariant == family::spatial_momentum || invariant == family::casimirs ||
           invariant == family::orthogonality || invariant == family::PQt;
  }
  static constexpr bool quadratic(std::string_view invariant) {
    return conserved_on_orbits(invariant);
  }

  void generator(const State& x, Algebra& Omega) {
    const Eigen::Index N = x.cols();
    D_.noalias() = x.topRows(N).transpose() * x.bottomRows(N);
    inverse_inertia(lambda_, D_, epsilon_, Omega);
  }

 private:
  using Base::D_, Base::epsilon_, Base::lambda_;
};

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

// The maps of methods that are made for the symmetric representation: (SDRBn), which is the
// Moser–Veselov map under Ψ, and the closed form.

inline auto map_of(Variational, const SymmetricRigidBody<double>& body, double h,
                   const MethodOptions& options) {
  return composed(
      [body](double stage, Arithmetic arithmetic) {
        return SymmetricMoserVeselov(body.lambda(), stage, body.epsilon(), arithmetic);
      },
      h, options);
}

inline auto map_of(Exact, const SymmetricRigidBody<double>& body, double h, const MethodOptions&) {
  return closed_form_map<Eigen::MatrixXd>(
      [body](const Eigen::MatrixXd& start) -> TurnedBody {
        const TurnedBody::Dense x = start.cast<long double>(), Q = x.topRows(x.cols()),
                                P = x.bottomRows(x.cols());
        const long double epsilon = body.epsilon();
        return {body.lambda().cast<long double>(), Psi(Q, P, epsilon), x};
      },
      h);
}
template <>
inline constexpr Declared declared<Exact, SymmetricRigidBody<double>> = {
    .where = "N = 3, or Lambda of at most two values", .takes = TurnedBody::has};

}  // namespace stiefel
