#pragma once

#include "engine/body/j_d/deviation_sweeps.h"
#include "engine/numbers/split_product.h"
#include "stiefel/stop.h"

namespace stiefel {

/// The step of the rigid body in N dimensions by U = J_D⁻¹(hM), computed as the deviation X = UΛ −
/// Λ (DeviationSweeps). Since (U + Uᵀ)_ij = 2δ_ij − (XᵀX)_ij/(λ_iλ_j), the momentum changes by
///
///     M_{k+1} − M_k = [Λ, U + Uᵀ]/h = −(λ_i − λ_j)(XᵀX)_ij / (λ_iλ_jh),
///
/// which computes small quantities from small ones. Compensated arithmetic computes XᵀX and the
/// increment to nearly twice the precision.
template <class Scalar>
class DeviationN : public DeviationSweeps<Scalar> {
 public:
  using State = Accumulator<Matrix<Scalar>>;
  using Wide = Extended<Scalar>;

  DeviationN(const Vector<Scalar>& lambda, Scalar h);

  /// Sets M ← UᵀMU, with X accurate to the last bit, and Q ← QU = Q + QXΛ⁻¹ where x has a Q. When
  /// it is stopped, x is unchanged.
  void transport(State& x);

  /// Returns U − I = XΛ⁻¹ of the last transport.
  const Matrix<Scalar>& U_minus_I();

 private:
  using Sweeps = DeviationSweeps<Scalar>;
  using Sweeps::G_, Sweeps::lambda_, Sweeps::N_, Sweeps::R_column, Sweeps::X_;

  /// Computes X and XᵀX from M and its carry to nearly twice the precision.
  void form_carefully(const State& x);
  void move_momentum_plainly(State& x);
  void move_momentum_carefully(State& x);
  /// Adds change_Λ⁻¹ to Q.
  void move_frame(State& x);

  /// Computes X from M and its carry, as a rounded X and its rounding error; then XᵀX = G + low +
  /// lowᵀ.
  void form_product(const State& x);

  /// Makes further sweeps of one product each: when R changes by δ, XᵀX changes by Xᵀδ + δX. The
  /// sweeps end when the error of R is far below its rounding; a larger error would cause a drift
  /// that grows with the number of steps.
  void refine();

  /// A rough time of a pass over one column in wider arithmetic.
  double wide_column_nanoseconds() const { return 10 * static_cast<double>(N_); }
  double product_operations() const { return static_cast<double>(N_ * N_ * N_); }
  Wide wide_XX(Eigen::Index i, Eigen::Index j) const {
    return G_(i, j) + (Wide(low_(i, j)) + low_(j, i));
  }
  Wide wide_R(Eigen::Index i, Eigen::Index j) const {
    return -wide_XX(i, j) / (wide_lambda_(i) + wide_lambda_(j));
  }
  Wide wide_hOmegaLambda(const State& x, Eigen::Index i, Eigen::Index j) const {
    const Eigen::Index top = x.value.rows() - N_;
    return Wide(h_) * x.with_carry(top + i, j) * wide_lambda_(j) /
           (wide_lambda_(i) + wide_lambda_(j));
  }

  Scalar h_;
  Vector<Wide> wide_lambda_;
  SplitProduct<Scalar> split_;
  Matrix<Scalar> low_, change_, step_change_;
};

template <class Scalar>
DeviationN<Scalar>::DeviationN(const Vector<Scalar>& lambda, Scalar h)
    : Sweeps(lambda),
      h_(h),
      wide_lambda_(lambda.template cast<Wide>()),
      split_(N_),
      low_(Matrix<Scalar>::Zero(N_, N_)),
      change_(low_),
      step_change_(low_) {}

template <class Scalar>
void DeviationN<Scalar>::transport(State& x) {
  const bool has_frame = x.value.rows() > N_;
  if (x.compensated) form_carefully(x);
  if (has_frame) {
    stop_point(product_operations());
    change_.noalias() = x.value.topRows(N_) * X_;
  }
  x.compensated ? move_momentum_carefully(x) : move_momentum_plainly(x);
  if (has_frame) move_frame(x);
}

template <class Scalar>
void DeviationN<Scalar>::move_momentum_plainly(State& x) {
  auto M = x.value.bottomRows(N_);
  in_column_ranges(N_, static_cast<double>(N_), [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j) {
      const auto lambda = lambda_.head(j + 1).array();
      M.col(j).head(j + 1).array() += R_column(j).array() * (lambda - lambda_(j)) *
                                      (lambda + lambda_(j)) / (lambda * (lambda_(j) * h_));
    }
    mirror_columns(M, begin, end, -1);
  });
}

template <class Scalar>
void DeviationN<Scalar>::form_carefully(const State& x) {
  stop_point(product_operations());
  form_product(x);
  refine();
  in_column_ranges(N_, wide_column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {
        const Wide R = wide_R(i, j);
        R_column(j)(i) = static_cast<Scalar>(R);
        X_(i, j) = static_cast<Scalar>(R + wide_hOmegaLambda(x, i, j));
        X_(j, i) = static_cast<Scalar>(R + wide_hOmegaLambda(x, j, i));
      }
  });
}

template <class Scalar>
void DeviationN<Scalar>::move_momentum_carefully(State& x) {
  const Eigen::Index top = x.value.rows() - N_;
  in_column_ranges(N_, wide_column_nanoseconds() / 2, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        x.add_with_carry(top + i, j,
                         -(wide_lambda_(i) - wide_lambda_(j)) * wide_XX(i, j) /
                             (wide_lambda_(i) * wide_lambda_(j) * h_));
        x.mirror(top + i, j, top + j, i);
      }
  });
}

template <class Scalar>
const Matrix<Scalar>& DeviationN<Scalar>::U_minus_I() {
  for (Eigen::Index j = 0; j < N_; ++j) change_.col(j) = X_.col(j) / lambda_(j);
  return change_;
}

template <class Scalar>
void DeviationN<Scalar>::move_frame(State& x) {
  in_column_ranges(N_, static_cast<double>(N_), [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j)
      if (!x.compensated)
        x.value.col(j).head(N_) += change_.col(j) / lambda_(j);
      else
        for (Eigen::Index i = 0; i < N_; ++i)
          x.add_scalar_with_carry(i, j, change_(i, j) / lambda_(j));
  });
}

template <class Scalar>
void DeviationN<Scalar>::form_product(const State& x) {
  in_column_ranges(N_, wide_column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j)
      for (Eigen::Index i = 0; i < N_; ++i) {
        const Scalar R = i <= j ? R_column(j)(i) : R_column(i)(j);
        const Wide exact = R + wide_hOmegaLambda(x, i, j);
        X_(i, j) = static_cast<Scalar>(exact);
        change_(i, j) = static_cast<Scalar>(exact - X_(i, j));
      }
  });
  split_(X_, change_, G_, low_);
}

template <class Scalar>
void DeviationN<Scalar>::refine() {
  const Scalar negligible = two_to<Scalar>(-bits<Scalar> - 13);
  using std::abs;
  constexpr int most = 4;
  const Scalar size = X_.cwiseAbs().maxCoeff();
  change_.setZero();
  for (int k = 0; k < most; ++k) {
    const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
      Scalar largest = 0;
      for (Eigen::Index j = begin; j < end; ++j)
        for (Eigen::Index i = 0; i <= j; ++i) {
          const Scalar change = static_cast<Scalar>(wide_R(i, j) - R_column(j)(i));
          step_change_(i, j) = step_change_(j, i) = change - change_(i, j);
          change_(i, j) = change;
          largest = std::max<Scalar>(largest, abs(step_change_(i, j)));
        }
      return largest;
    };
    const Scalar largest = largest_in_column_ranges<Scalar>(N_, wide_column_nanoseconds(), columns);
    if (largest <= negligible * size) return;
    stop_point(product_operations());
    low_.noalias() += X_.transpose() * step_change_;
  }
}

// Compiled once, in j_d_n.cc.
extern template class DeviationN<double>;

}  // namespace stiefel
