#pragma once

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

/// The pair (Q, M) in N dimensions as matrices. A state is Q over M, 2N × N, or M alone, N × N. An
/// element of the algebra so(N) is a skew N × N matrix. So3 has the same functions in coordinates.
template <class Scalar_>
struct SoN {
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;
  using Algebra = Matrix<Scalar>;
  using Lambda = Vector<Scalar>;

  explicit SoN(Eigen::Index N)
      : N_(N), exponential_(N, MatrixKind::skew), D_(N, N), product_(N, N) {}

  Algebra zero() const { return Algebra::Zero(N_, N_); }
  static auto M(const State& x) { return x.bottomRows(x.cols()); }

  /// Computes J⁻¹: Ω_ij = M_ij / (λ_i + λ_j).
  class InverseInertia {
   public:
    explicit InverseInertia(Lambda lambda) : lambda_(std::move(lambda)) {}
    void operator()(const State& x, Algebra& Omega) const {
      inverse_inertia(lambda_, M(x), Scalar(2), Omega);
    }

   private:
    Lambda lambda_;
  };

  /// Computes (QΩ, [M, Ω]) for M = J(Ω).
  static void velocity(const Lambda& lambda, const State& x, const Algebra& Omega, State& dx) {
    const Eigen::Index N = x.cols(), top = x.rows() - N;
    dx.topRows(top).noalias() = x.topRows(top) * Omega;
    inertia_bracket(lambda, Omega, dx.bottomRows(N));
  }

  /// Computes [A, B] = AB − BA = AB − (AB)ᵀ.
  static void bracket(const Algebra& A, const Algebra& B, Algebra& C) {
    C.noalias() = A * B;
    subtract_transpose(C);
  }

  /// Computes (Q exp Θ − Q, exp(Θ)ᵀ M exp(Θ) − M): with D = exp Θ − I and Y = MD the lower block is
  /// Y − Yᵀ + DᵀY.
  void displacement(const State& x, const Algebra& Theta, State& dx) {
    exponential_(Theta, D_);
    dx.noalias() = x * D_;
    product_.noalias() = D_.transpose() * dx.bottomRows(N_);
    dx.bottomRows(N_) += product_ / 2;
    subtract_transpose(dx.bottomRows(N_));
  }

 private:
  Eigen::Index N_;
  Exponential<Scalar> exponential_;
  Algebra D_, product_;
};

}  // namespace stiefel
