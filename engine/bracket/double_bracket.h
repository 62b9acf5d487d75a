#pragma once

#include <complex>
#include <string_view>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/dense/so_n.h"
#include "engine/methods/concepts.h"
#include "engine/numbers/scalar.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// Complex matrices in real numbers. Z = X + iY, p × q, is stored as X over Y, 2p × q, and acts as
///
///     R(Z) = [[X, −Y], [Y, X]],   R(WZ) = R(W)R(Z),   R(Z†) = R(Z)ᵀ,
///
/// The stored form is the left half of R(Z), so R(W)·stored(Z) = stored(WZ). Code for real matrices
/// of any scalar thereby serves complex ones, and a complex state is a block of real numbers.
/// `complex_as_real` writes R(Z).
template <class Stored, class Real>
void complex_as_real(const Eigen::MatrixBase<Stored>& stored, Eigen::MatrixBase<Real>& R) {
  const Eigen::Index p = stored.rows() / 2, q = stored.cols();
  R.leftCols(q) = stored;
  R.topRightCorner(p, q) = -stored.bottomRows(p);
  R.bottomRightCorner(p, q) = stored.topRows(p);
}

/// The coupled double bracket equations on U(p) × U(q), [RB] (5.7)–(5.11), complex p × q Q and P:
///
///     Q̇ = UQ − QV,   U = J_U⁻¹(PQ† − QP†),   J_U(X) = Λ_U X + XΛ_U,
///     Ṗ = UP − PV,   V = J_V⁻¹(P†Q − Q†P),   J_V(X) = Λ_V X + XΛ_V,
///
/// with all entries of Λ_U and Λ_V positive. They keep the Hamiltonian ¼⟨U, J_U U⟩ + ¼⟨V, J_V V⟩
/// and the singular values of Q, of P and of every aQ + bP. The limit Λ_U → ∞ is the left-invariant
/// rigid body and Λ_V → ∞ the right-invariant one, both in the symmetric representation.
///
/// State: Re Q, Im Q, Re P, Im P stacked by rows, 4p × q (complex_as_real). The pair (e^a, e^b)
/// acts from the left as Q ↦ e^a Q e^{−b}, so the bracket is −[·, ·]. An element of the algebra is
/// diag(a, b), as in Q̂ of (5.11), with a and b as real skew matrices of twice the size.
template <class Scalar_>
class DoubleBracket {
 public:
  static constexpr const char* name = "double_bracket";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;

  /// Whether an invariant is constant along the orbits of the group.
  static constexpr bool conserved_on_orbits(std::string_view invariant) {
    return invariant == family::singular_values;
  }

  DoubleBracket(const Vector<Scalar>& lambda_u, const Vector<Scalar>& lambda_v)
      : p_(lambda_u.size()),
        q_(lambda_v.size()),
        lambda_u_(2 * p_),
        lambda_v_(2 * q_),
        exponential_(2 * (p_ + q_), MatrixKind::skew),
        theta_(zero()),
        D_(theta_),
        Q_(2 * p_, 2 * q_),
        P_(2 * p_, 2 * q_),
        G_U_(2 * p_, 2 * p_),
        G_V_(2 * q_, 2 * q_),
        product_(2 * p_, q_) {
    lambda_u_ << lambda_u, lambda_u;
    lambda_v_ << lambda_v, lambda_v;
  }

  auto lambda_u() const { return lambda_u_.head(p_); }
  auto lambda_v() const { return lambda_v_.head(q_); }

  void field(const State& x, State& dx) {
    generator(x, theta_);
    for (const Eigen::Index top : {Eigen::Index(0), 2 * p_}) {
      complex_as_real(x.middleRows(top, 2 * p_), Q_);
      dx.middleRows(top, 2 * p_).noalias() = a(theta_) * Q_.leftCols(q_);
      dx.middleRows(top, 2 * p_).noalias() -= Q_ * b(theta_).leftCols(q_);
    }
  }

  Algebra zero() const { return Algebra::Zero(2 * (p_ + q_), 2 * (p_ + q_)); }

  /// Sets ξ = diag(U, V).
  void generator(const State& x, Algebra& xi) {
    complex_as_real(x.topRows(2 * p_), Q_);
    complex_as_real(x.bottomRows(2 * p_), P_);
    G_U_.noalias() = P_ * Q_.transpose();
    G_V_.noalias() = P_.transpose() * Q_;
    auto U = xi.topLeftCorner(2 * p_, 2 * p_);
    auto V = xi.bottomRightCorner(2 * q_, 2 * q_);
    inverse_inertia(lambda_u_, G_U_, Scalar(1), U);
    inverse_inertia(lambda_v_, G_V_, Scalar(1), V);
  }
  void bracket(const Algebra& a, const Algebra& b, Algebra& c) const {
    SoN<Scalar>::bracket(b, a, c);
  }

  /// Computes e^a Q e^{−b} − Q = AQ + (Q + AQ)B with A = e^a − I and B = e^{−b} − I.
  void displacement(const State& x, const Algebra& theta, State& dx) {
    exponential_(theta, D_);
    for (const Eigen::Index top : {Eigen::Index(0), 2 * p_}) {
      product_.noalias() = a(D_) * x.middleRows(top, 2 * p_);
      complex_as_real(x.middleRows(top, 2 * p_) + product_, Q_);
      dx.middleRows(top, 2 * p_) = product_;
      dx.middleRows(top, 2 * p_).noalias() += Q_ * b(D_).topRows(q_).transpose();
    }
  }

 private:
  auto a(const Algebra& xi) const { return xi.topLeftCorner(2 * p_, 2 * p_); }
  auto b(const Algebra& xi) const { return xi.bottomRightCorner(2 * q_, 2 * q_); }

  Eigen::Index p_, q_;
  Vector<Scalar> lambda_u_, lambda_v_;
  Exponential<Scalar> exponential_;
  Algebra theta_, D_;
  Matrix<Scalar> Q_, P_, G_U_, G_V_, product_;
};

/// Returns the Hamiltonian of the coupled double bracket, ¼⟨U, J_U U⟩ + ¼⟨V, J_V V⟩ with ⟨A, B⟩ = ½
/// tr(A†B), [RB] (5.6): the sum of ⅛ Σ |X_ij|²/(λ_i + λ_j) for X = PQ† − QP† with Λ_U and for X =
/// P†Q − Q†P with Λ_V. In the limits Λ_U → ∞ and Λ_V → ∞ it is half the rigid body's energy.
template <class Scalar>
Scalar double_bracket_hamiltonian(const Vector<Scalar>& lambda_u, const Vector<Scalar>& lambda_v,
                                  const Matrix<std::complex<Scalar>>& Q,
                                  const Matrix<std::complex<Scalar>>& P) {
  const auto term = [](const Vector<Scalar>& lambda, const Matrix<std::complex<Scalar>>& G) {
    Scalar sum = 0;
    for (Eigen::Index j = 0; j < G.cols(); ++j)
      for (Eigen::Index i = 0; i < G.rows(); ++i)
        sum += std::norm(G(i, j) - std::conj(G(j, i))) / (lambda(i) + lambda(j));
    return sum / 8;
  };
  return term(lambda_u, P * Q.adjoint()) + term(lambda_v, P.adjoint() * Q);
}

/// Returns the singular values of aQ + bP, p × q, in descending order, to an error of rounding
/// times the largest. They are constant for every a and b, because U(p) × U(q) acts on Q and P in
/// the same way. (a, b) = (1, 0) gives those of Q, (0, 1) those of P.
Vector<double> singular_values(const Matrix<std::complex<double>>& Q,
                               const Matrix<std::complex<double>>& P, std::complex<double> a,
                               std::complex<double> b);

}  // namespace stiefel
