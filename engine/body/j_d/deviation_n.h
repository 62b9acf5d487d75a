#pragma once

#include <algorithm>
#include <cmath>

#include "engine/dense/lagged_anderson.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/parallel.h"
#include "engine/numbers/split_product.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Sets the elements below the diagonal of a square block to `sign` times those above it, for those
/// above it in columns begin ... end - 1: tile by tile, so that columns and rows stay in the cache.
/// `begin` is a multiple of the tile's 16 columns.
template <class Block>
void mirror_columns(Block& A, Eigen::Index begin, Eigen::Index end, double sign) {
  constexpr Eigen::Index tile = 16;
  for (Eigen::Index j = begin; j < end; j += tile) {
    const Eigen::Index width = std::min(tile, end - j);
    for (Eigen::Index i = 0; i < j; i += tile)
      A.block(j, i, width, tile) = sign * A.block(i, j, tile, width).transpose();
    for (Eigen::Index l = j; l < j + width; ++l)
      for (Eigen::Index k = j; k < l; ++k) A(l, k) = sign * A(k, l);
  }
}
/// Sets all elements below the diagonal of a square block to `sign` times those above it.
template <class Block>
void mirror_upper(Block&& A, double sign = 1) {
  mirror_columns(A, 0, A.cols(), sign);
}

/// The step of the rigid body in N dimensions by U = J_D⁻¹(hM), computed as the deviation X = UΛ −
/// Λ = hΩΛ + R, Ω = J⁻¹(M), R symmetric ([RB] (7.13), (7.14) with S = Λ + R + the symmetric part of
/// hΩΛ), by the fixed-point iteration of
///
///     (Λ + X)ᵀ(Λ + X) = Λ²   ⟺   R_ij = −(XᵀX)_ij / (λ_i + λ_j),
///
/// with one symmetric product in each sweep. At Λ = I the derivative of the iteration is a
/// commutator with hΩ, whose eigenvalues are imaginary; LaggedAnderson accelerates it. Small
/// quantities stay relatively accurate. Every symmetric R satisfies UΛ − ΛUᵀ = hM, so the stopping
/// test is Λ⁻¹(WᵀW − Λ²)Λ⁻¹ = UᵀU − I, W = Λ + X. For λ_i > 0 of moderate spread.
///
/// Since (U + Uᵀ)_ij = 2δ_ij − (XᵀX)_ij/(λ_iλ_j), the momentum changes by
///
///     M_{k+1} − M_k = [Λ, U + Uᵀ]/h = −(λ_i − λ_j)(XᵀX)_ij / (λ_iλ_jh),
///
/// which computes small quantities from small ones. Compensated arithmetic computes XᵀX and the
/// increment to nearly twice the precision.
class DeviationN {
 public:
  using Dense = Eigen::MatrixXd;
  using State = Accumulator<Dense>;

  DeviationN(const Eigen::VectorXd& lambda, double h)
      : h_(h),
        N_(lambda.size()),
        lambda_(lambda),
        inverse_(lambda.cwiseInverse()),
        R_(Eigen::VectorXd::Zero(N_ * (N_ + 1) / 2)),
        next_(R_),
        wide_lambda_(lambda.cast<Wide>()),
        accelerate_(R_.size()),
        split_(N_) {
    for (Dense* A : {&X_, &G_, &hOmegaLambda_, &low_, &change_, &step_change_}) A->setZero(N_, N_);
  }

  /// Returns R on and above the diagonal, column after column.
  Eigen::VectorXd& R() { return R_; }

  /// Sweeps from the current R until UᵀU − I is at rounding level or, with `to_its_last_bit`, until
  /// R, which is of the size of X², is accurate to rounding. Returns false if the sweeps converge
  /// slowly. K = hM.
  bool sweep(const Dense& K, bool to_its_last_bit) {
    constexpr double unit = 0x1p-53, slow = 0.7;
    constexpr int most = 40;
    form_hOmegaLambda(K);
    form_X();
    accelerate_.restart();
    const double size = size_of_X(), enough = unit * (to_its_last_bit ? size * size : size);
    if (!(size <= 1)) return false;
    double last = 0;
    for (int k = 0; k < most; ++k) {
      stop_point(product_operations());
      const double defect = correct();
      const double ratio = k == 0 ? slow : defect / last;
      const bool stagnates = k > 0 && !(ratio <= slow);
      const bool reached = defect * ratio <= enough || (stagnates && defect <= 64 * unit * size);
      if (stagnates && !reached) return false;
      form_X();
      if (reached) return true;
      last = defect;
    }
    return false;
  }

  /// Sets X to a solution found by another method.
  void set(const Dense& X, const Dense& K) {
    form_hOmegaLambda(K);
    X_ = X - hOmegaLambda_;
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) R_column(j)(i) = (X_(i, j) + X_(j, i)) / 2;
    form_X();
  }

  /// Sets M ← UᵀMU, with X accurate to the last bit, and Q ← QU = Q + QXΛ⁻¹ where x has a Q. When
  /// it is stopped, x is unchanged.
  void transport(State& x) {
    const bool has_frame = x.value.rows() > N_;
    if (x.compensated) form_carefully(x);
    if (has_frame) {
      stop_point(product_operations());
      change_.noalias() = x.value.topRows(N_) * X_;
    }
    x.compensated ? move_momentum_carefully(x) : move_momentum_plainly(x);
    if (has_frame) move_frame(x);
  }

  /// Returns U − I = XΛ⁻¹ of the last transport.
  const Dense& U_minus_I() {
    for (Eigen::Index j = 0; j < N_; ++j) change_.col(j) = X_.col(j) / lambda_(j);
    return change_;
  }

 private:
  using Wide = long double;

  Eigen::VectorXd::SegmentReturnType R_column(Eigen::Index j) {
    return R_.segment(j * (j + 1) / 2, j + 1);
  }
  /// A rough time of a pass over one column, and of one in wider arithmetic.
  double column_nanoseconds() const { return static_cast<double>(N_); }
  double wide_column_nanoseconds() const { return 10 * column_nanoseconds(); }
  double product_operations() const { return static_cast<double>(N_ * N_ * N_); }

  /// Computes hΩΛ, with the elements K_ijλ_j/(λ_i + λ_j).
  void form_hOmegaLambda(const Dense& K) {
    in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j)
        hOmegaLambda_.col(j) = lambda_(j) * K.col(j).array() / (lambda_.array() + lambda_(j));
    });
  }
  void form_X() {
    in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j) X_.col(j).head(j + 1) = R_column(j);
      mirror_columns(X_, begin, end, 1);
    });
    in_column_ranges(N_, column_nanoseconds() / 2, [&](Eigen::Index begin, Eigen::Index end) {
      X_.middleCols(begin, end - begin) += hOmegaLambda_.middleCols(begin, end - begin);
    });
  }

  /// Returns the largest |X_ij| / min(λ_i, λ_j), which bounds the elements of U − I = XΛ⁻¹.
  double size_of_X() const {
    return largest_in_column_ranges<double>(N_, column_nanoseconds(), [&](auto begin, auto end) {
      double size = 0;
      for (Eigen::Index j = begin; j < end; ++j)
        size = std::max(
            size, X_.col(j).cwiseAbs().cwiseProduct(inverse_.cwiseMax(inverse_(j))).maxCoeff());
      return size;
    });
  }

  /// Sets R ← −XᵀX/(λ_i + λ_j), accelerated. Returns the largest change of UᵀU − I.
  double correct() {
    upper_gram(X_, G_);
    const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
      double defect = 0;
      for (Eigen::Index j = begin; j < end; ++j) {
        const auto inverse = inverse_.head(j + 1).array() + inverse_(j);
        auto next = next_.segment(j * (j + 1) / 2, j + 1);
        next = -G_.col(j).head(j + 1).array() / (lambda_.head(j + 1).array() + lambda_(j));
        defect = std::max(defect, ((next - R_column(j)).array().abs() * inverse).maxCoeff());
      }
      return defect;
    };
    const double defect = largest_in_column_ranges<double>(N_, column_nanoseconds(), columns);
    accelerate_(R_, next_);
    return defect;
  }

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

  /// Computes X and XᵀX from M and its carry to nearly twice the precision.
  void form_carefully(const State& x) {
    stop_point(product_operations());
    form_product(x);
    refine();
    in_column_ranges(N_, wide_column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j)
        for (Eigen::Index i = 0; i <= j; ++i) {
          const Wide R = wide_R(i, j);
          R_column(j)(i) = static_cast<double>(R);
          X_(i, j) = static_cast<double>(R + wide_hOmegaLambda(x, i, j));
          X_(j, i) = static_cast<double>(R + wide_hOmegaLambda(x, j, i));
        }
    });
  }

  /// Computes X from M and its carry, as a rounded X and its rounding error; then XᵀX = G + low +
  /// lowᵀ.
  void form_product(const State& x) {
    in_column_ranges(N_, wide_column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j)
        for (Eigen::Index i = 0; i < N_; ++i) {
          const double R = i <= j ? R_column(j)(i) : R_column(i)(j);
          const Wide exact = R + wide_hOmegaLambda(x, i, j);
          X_(i, j) = static_cast<double>(exact);
          change_(i, j) = static_cast<double>(exact - X_(i, j));
        }
    });
    split_(X_, change_, G_, low_);
  }

  /// Makes further sweeps of one product each: when R changes by δ, XᵀX changes by Xᵀδ + δX. The
  /// sweeps end when the error of R is far below its rounding; a larger error would cause a drift
  /// that grows with the number of steps.
  void refine() {
    constexpr double negligible = 0x1p-66;
    constexpr int most = 4;
    const double size = X_.cwiseAbs().maxCoeff();
    change_.setZero();
    for (int k = 0; k < most; ++k) {
      const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
        double largest = 0;
        for (Eigen::Index j = begin; j < end; ++j)
          for (Eigen::Index i = 0; i <= j; ++i) {
            const auto change = static_cast<double>(wide_R(i, j) - R_column(j)(i));
            step_change_(i, j) = step_change_(j, i) = change - change_(i, j);
            change_(i, j) = change;
            largest = std::max(largest, std::abs(step_change_(i, j)));
          }
        return largest;
      };
      const double largest =
          largest_in_column_ranges<double>(N_, wide_column_nanoseconds(), columns);
      if (largest <= negligible * size) return;
      stop_point(product_operations());
      low_.noalias() += X_.transpose() * step_change_;
    }
  }

  void move_momentum_plainly(State& x) {
    auto M = x.value.bottomRows(N_);
    in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j) {
        const auto lambda = lambda_.head(j + 1).array();
        M.col(j).head(j + 1).array() += R_column(j).array() * (lambda - lambda_(j)) *
                                        (lambda + lambda_(j)) / (lambda * (lambda_(j) * h_));
      }
      mirror_columns(M, begin, end, -1);
    });
  }
  void move_momentum_carefully(State& x) {
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
  /// Adds change_Λ⁻¹ to Q.
  void move_frame(State& x) {
    in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j)
        if (!x.compensated)
          x.value.col(j).head(N_) += change_.col(j) / lambda_(j);
        else
          for (Eigen::Index i = 0; i < N_; ++i)
            x.add_scalar_with_carry(i, j, change_(i, j) / lambda_(j));
    });
  }

  double h_;
  Eigen::Index N_;
  Eigen::VectorXd lambda_, inverse_, R_, next_;
  Vector<Wide> wide_lambda_;
  LaggedAnderson<double> accelerate_;
  SplitProduct<double> split_;
  Dense X_, G_, hOmegaLambda_;  ///< G_ is XᵀX on and above the diagonal
  Dense low_, change_, step_change_;
};

}  // namespace stiefel
