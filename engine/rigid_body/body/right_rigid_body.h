#pragma once

#include <string_view>

#include "engine/linalg/lie/multiplication.h"
#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "engine/methods/support/concepts.h"
#include "engine/numbers/stoppable_product.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// The free rigid body in N dimensions, right-invariant: [RB] (RightRBn)
///
///     Q̇_r = Ω_r Q_r,   Ṁ_r = [Ω_r, M_r],   M_r = J(Ω_r) = ΛΩ_r + Ω_rΛ.
///
/// Q_r = Qᵀ and M_r = −M = Mᵀ for Q and M of the left-invariant body (Prop. 2.1). The motion keeps
/// the energy, m_r = Q_rᵀM_rQ_r, the eigenvalues of M_r and every coefficient of tr((M_r + μΛ²)^k).
/// State: Q_r over M_r, 2N × N, or M_r alone, N × N. SO(N) acts from the left: Q_r ↦ e^Θ Q_r, M_r ↦
/// e^Θ M_r e^{−Θ}.
template <class Scalar_>
class RightRigidBody {
 public:
  static constexpr const char* name = "right_rigid_body";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  /// Whether an invariant is constant along the orbits of the group.
  static constexpr bool conserved_on_orbits(std::string_view invariant) {
    return invariant == family::spatial_momentum || invariant == family::casimirs ||
           invariant == family::orthogonality;
  }

  explicit RightRigidBody(Vector<Scalar> lambda)
      : lambda_(std::move(lambda)),
        action_(lambda_.size()),
        Omega_(action_.zero()),
        product_(Omega_) {}

  const Vector<Scalar>& lambda() const { return lambda_; }

  void field(const State& x, State& dx) {
    generator(x, Omega_);
    const Eigen::Index top = x.rows() - N();
    stoppable_product(Omega_, x.topRows(top), dx.topRows(top));
    inertia_bracket(lambda_, Omega_, dx.bottomRows(N()));
    dx.bottomRows(N()) *= Scalar(-1);
  }

  Algebra zero() const { return action_.zero(); }
  void generator(const State& x, Algebra& Omega) const {
    inverse_inertia(lambda_, x.bottomRows(N()), Scalar(2), Omega);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const { action_.bracket(a, b, c); }

  /// Computes e^Θ M e^{−Θ} − M = Y − Yᵀ + YDᵀ with D = e^Θ − I and Y = DM.
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    action_.displacement(x, Theta, dx);
    stoppable_product(dx.bottomRows(N()), action_.D().transpose(), product_);
    dx.bottomRows(N()) += product_ / 2;
    subtract_transpose(dx.bottomRows(N()));
  }

 private:
  Eigen::Index N() const { return lambda_.size(); }

  Vector<Scalar> lambda_;
  LeftMultiplication<Scalar> action_;
  Algebra Omega_, product_;
};

}  // namespace stiefel
