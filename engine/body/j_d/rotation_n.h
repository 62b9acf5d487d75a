#pragma once

#include <cmath>

#include "engine/body/j_d/deviation_sweeps.h"
#include "engine/body/j_d/rotation_correction.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/split_product.h"

namespace stiefel {

/// Returns ‖A‖ of a skew matrix from six steps of the power method, times 1.1, since they stay
/// below it.
template <class Scalar>
Scalar norm_of_skew(const Matrix<Scalar>& A, Vector<Scalar>& v, Vector<Scalar>& Av) {
  constexpr int steps = 6;
  Eigen::Index longest;
  A.cwiseAbs().colwise().maxCoeff().maxCoeff(&longest);
  v = A.col(longest);
  Scalar norm = v.stableNorm();
  for (int k = 0; k < steps && norm > 0; ++k) {
    v /= norm;
    Av.noalias() = A * v;
    norm = Av.stableNorm();
    v.swap(Av);
  }
  return Scalar(1.1) * norm;
}

/// The step of the rigid body in N dimensions by U = J_D⁻¹(hM) for Λ of any spread, λ_i ≥ 0, as the
/// deviation X = U − I = hΩ + w∘S with a symmetric S, of which each element obeys UΛ − ΛUᵀ = hM.
/// S is the symmetric part of X, and UᵀU = I says that
///
///     S = −½XᵀX,   X_ij = hΩ_ij + w_ij S_ij,   w_ij = 2λ_i/(λ_i + λ_j),
///     M_{k+1} − M_k = [Λ, U + Uᵀ]/h = 2 (λ_i − λ_j) S_ij/h.
///
/// Λ enters only through Ω and weights between 0 and 2, so its spread costs neither digits nor
/// sweeps. The residual is computed in working precision, in compensated arithmetic the last one
/// to nearly twice that, and corrections in single precision (RotationCorrection).
template <class Scalar>
class RotationN {
 public:
  using State = Accumulator<Matrix<Scalar>>;
  using Wide = Extended<Scalar>;

  RotationN(const Vector<Scalar>& lambda, Scalar h);

  /// Returns S on and above the diagonal, column after column.
  Vector<Scalar>& S() { return packed_; }

  /// Finds S from an approximate one, near which `transport` finds the rest of its digits
  /// if the arithmetic is compensated. Returns false where h‖Ω‖ is near 1 or more, or the
  /// corrections converge slowly, or an angle of U is not below π/2. K = hM.
  bool solve(const Matrix<Scalar>& K, bool compensated);

  /// Sets S to that of a U found by another method.
  void set(const Matrix<Scalar>& U_minus_I);

  /// Sets M ← UᵀMU, and Q ← QU = Q + Q(U − I) where x has a Q. When it is stopped, x is unchanged.
  void transport(State& x);

  /// Returns U − I of the last transport.
  const Matrix<Scalar>& U_minus_I() const { return X_; }

 private:
  /// Computes X and G = f = −½XᵀX − S from S. Returns the largest |f_ij|.
  Scalar residual();
  /// Computes G = f from S and M with its carry. X becomes the rounded U − I, `epsilon_` its
  /// rounding error. Returns the largest |f_ij|.
  Scalar careful_residual(const State& x);
  /// The angles of U are below π/2 where its symmetric part I + S is positive definite. Then
  /// spec(UΛ) is in Re > 0: U is on the branch that starts at the identity.
  bool on_branch();
  /// Computes U − I, and what is to be added to S, from M and its carry to nearly twice the
  /// precision.
  void form_carefully(const State& x);
  void move_momentum_plainly(State& x);
  void move_momentum_carefully(State& x);
  void pack();

  Scalar h_, sine_ = 0;
  Vector<Scalar> lambda_, packed_, v_, Av_;
  Vector<Wide> wide_lambda_;
  Matrix<Scalar> weight_, hOmega_, S_, X_, G_, epsilon_, low_;
  SplitProduct<Scalar> split_;
  RotationCorrection<Scalar> correction_;
};

template <class Scalar>
RotationN<Scalar>::RotationN(const Vector<Scalar>& lambda, Scalar h)
    : h_(h),
      lambda_(lambda),
      packed_(Vector<Scalar>::Zero(lambda.size() * (lambda.size() + 1) / 2)),
      v_(lambda),
      Av_(lambda),
      wide_lambda_(lambda.template cast<Wide>()),
      weight_(Matrix<Scalar>::NullaryExpr(
          lambda.size(), lambda.size(),
          [&](Eigen::Index i, Eigen::Index j) {
            return i == j ? Scalar(1) : Scalar(2 * lambda(i) / (lambda(i) + lambda(j)));
          })),
      hOmega_(Matrix<Scalar>::Zero(lambda.size(), lambda.size())),
      S_(hOmega_),
      X_(hOmega_),
      G_(hOmega_),
      epsilon_(hOmega_),
      low_(hOmega_),
      split_(lambda.size()),
      correction_(weight_) {}

template <class Scalar>
bool RotationN<Scalar>::solve(const Matrix<Scalar>& K, bool compensated) {
  inverse_inertia(lambda_, K, hOmega_);
  sine_ = norm_of_skew(hOmega_, v_, Av_);
  if (!(sine_ < 1)) return false;
  for (Eigen::Index j = 0; j < S_.cols(); ++j)
    S_.col(j).head(j + 1) = packed_.segment(j * (j + 1) / 2, j + 1);
  mirror_upper(S_);
  const Scalar unit = two_to<Scalar>(-bits<Scalar>),
               enough = compensated ? 4096 * unit * sine_ * sine_ : unit * sine_;
  Scalar size = residual(), last = std::numeric_limits<Scalar>::infinity();
  while (!(size <= enough)) {
    if (!(size < last / 4)) return false;
    last = size;
    size = correction_.solve(X_, G_, size, sine_, enough);
    S_ += correction_.delta();
    if (!(size <= enough)) size = residual();
  }
  X_ = hOmega_ + weight_.cwiseProduct(S_);
  return on_branch();
}

template <class Scalar>
Scalar RotationN<Scalar>::residual() {
  stop_point(static_cast<double>(S_.rows() * S_.size()));
  X_ = hOmega_ + weight_.cwiseProduct(S_);
  G_.template triangularView<Eigen::Upper>().setZero();
  G_.template selfadjointView<Eigen::Upper>().rankUpdate(X_.transpose());
  Scalar size = 0;
  for (Eigen::Index j = 0; j < S_.cols(); ++j) {
    auto f = G_.col(j).head(j + 1);
    f = -f / 2 - S_.col(j).head(j + 1);
    size = std::max<Scalar>(size, f.cwiseAbs().maxCoeff());
  }
  mirror_upper(G_);
  return size;
}

template <class Scalar>
bool RotationN<Scalar>::on_branch() {
  if (S_.squaredNorm() < 1) return true;
  stop_point(static_cast<double>(S_.rows() * S_.size()));
  G_ = S_;
  G_.diagonal().array() += Scalar(1);
  return factor_positive(G_);
}

template <class Scalar>
void RotationN<Scalar>::set(const Matrix<Scalar>& U_minus_I) {
  S_ = (U_minus_I + U_minus_I.transpose()) / 2;
  pack();
}

template <class Scalar>
void RotationN<Scalar>::transport(State& x) {
  const Eigen::Index N = lambda_.size();
  const bool has_frame = x.value.rows() > N;
  if (x.compensated) form_carefully(x);
  if (has_frame) {
    stop_point(static_cast<double>(N * N * N));
    G_.noalias() = x.value.topRows(N) * X_;
  }
  x.compensated ? move_momentum_carefully(x) : move_momentum_plainly(x);
  if (has_frame)
    for (Eigen::Index j = 0; j < N; ++j)
      for (Eigen::Index i = 0; i < N; ++i) x.add_scalar(i, j, G_(i, j));
  pack();
}

template <class Scalar>
void RotationN<Scalar>::move_momentum_plainly(State& x) {
  auto M = x.value.bottomRows(lambda_.size());
  for (Eigen::Index j = 0; j < S_.cols(); ++j)
    M.col(j).head(j + 1).array() +=
        2 * (lambda_.head(j + 1).array() - lambda_(j)) * S_.col(j).head(j + 1).array() / h_;
  mirror_upper(M, -1);
}

template <class Scalar>
void RotationN<Scalar>::form_carefully(const State& x) {
  const Scalar size = careful_residual(x),
               enough = two_to<Scalar>(-bits<Scalar> - 10) * sine_ * sine_;
  if (size > enough)
    correction_.solve(X_, G_, size, sine_, enough);
  else
    correction_.set_zero();
  X_ += epsilon_ + weight_.cwiseProduct(correction_.delta());
}

template <class Scalar>
void RotationN<Scalar>::move_momentum_carefully(State& x) {
  const Eigen::Index N = lambda_.size(), top = x.value.rows() - N;
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      const Wide S = Wide(S_(i, j)) + correction_(i, j);
      x.add_with_carry(top + i, j, 2 * (wide_lambda_(i) - wide_lambda_(j)) * S / h_);
      x.mirror(top + i, j, top + j, i);
    }
  S_ += correction_.delta();
}

template <class Scalar>
Scalar RotationN<Scalar>::careful_residual(const State& x) {
  const Eigen::Index N = lambda_.size(), top = x.value.rows() - N;
  const auto put = [this](Eigen::Index i, Eigen::Index j, Wide exact) {
    X_(i, j) = static_cast<Scalar>(exact);
    epsilon_(i, j) = static_cast<Scalar>(exact - X_(i, j));
  };
  stop_point(2 * static_cast<double>(N * N * N));
  for (Eigen::Index j = 0; j < N; ++j) {
    for (Eigen::Index i = 0; i < j; ++i) {
      const Wide sum = wide_lambda_(i) + wide_lambda_(j),
                 hOmega = h_ * x.with_carry(top + i, j) / sum, share = 2 * Wide(S_(i, j)) / sum;
      put(i, j, wide_lambda_(i) * share + hOmega);
      put(j, i, wide_lambda_(j) * share - hOmega);
    }
    put(j, j, S_(j, j));
  }
  split_(X_, epsilon_, G_, low_);
  using std::abs;
  Scalar size = 0;
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      G_(i, j) = -G_(i, j) / 2 - S_(i, j) - (low_(i, j) + low_(j, i)) / 2;
      size = std::max<Scalar>(size, abs(G_(i, j)));
    }
  mirror_upper(G_);
  return size;
}

template <class Scalar>
void RotationN<Scalar>::pack() {
  for (Eigen::Index j = 0; j < S_.cols(); ++j)
    packed_.segment(j * (j + 1) / 2, j + 1) = S_.col(j).head(j + 1);
}

// Compiled once, in j_d_n.cc.
extern template class RotationN<double>;

}  // namespace stiefel
