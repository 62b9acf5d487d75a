#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/dense/decompositions.h"
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

/// Returns column j of a symmetric matrix packed as its elements on and above the diagonal, column
/// after column.
inline auto packed_column(Eigen::VectorXd& S, Eigen::Index j) {
  return S.segment(j * (j + 1) / 2, j + 1);
}

/// The rotation U = J_D⁻¹(hM) in N dimensions for Λ of any spread, λ_i ≥ 0, as X = U − I = hΩ + w∘S
/// with a symmetric S, the symmetric part of X, and w_ij = 2λ_i/(λ_i + λ_j): each element obeys UΛ
/// − ΛUᵀ = hM, and UᵀU = I says that S = −½XᵀX. Λ enters only through Ω and weights between 0 and
/// 2, so its spread costs neither digits nor sweeps.
///
/// Let α be the largest angle of U. The derivative of S ↦ −½XᵀX has eigenvalues close to 1 −
/// ½(e^{iα_k} + e^{iα_l}), which it has exactly at Λ = I; they lie in [0, 1 − cos α] × i[−sin α,
/// sin α], sin α ≤ s = h‖Ω‖. Chebyshev's semi-iteration (Manteuffel 1977) for the vertical segment
/// through the middle of this rectangle reduces the error by s/(c + √(c² + s²)), c = ½(1 +
/// √(1 − s²)), in each sweep: 1/20 at h‖Ω‖ = 0.1, 1/4 at 0.5.
class RotationEquation {
 public:
  using Packed = Eigen::VectorXd;

  explicit RotationEquation(const Eigen::VectorXd& lambda)
      : N_(lambda.size()),
        weight_(Dense::NullaryExpr(N_, N_,
                                   [&](auto i, auto j) {
                                     return i == j ? 1.0 : 2 * lambda(i) / (lambda(i) + lambda(j));
                                   })),
        before_(Packed::Zero(N_ * (N_ + 1) / 2)),
        v_(lambda),
        Omega_v_(lambda) {}

  /// A rough time of a pass over one column.
  double column_nanoseconds() const { return static_cast<double>(N_); }

  /// Returns ‖Ω‖ of a skew matrix from six steps of the power method, times 1.1, since they stay
  /// below it.
  double norm(const Dense& Omega) {
    constexpr int steps = 6;
    Eigen::Index longest;
    in_column_ranges(N_, column_nanoseconds() / 4, [&](Eigen::Index begin, Eigen::Index end) {
      v_.segment(begin, end - begin) =
          Omega.middleCols(begin, end - begin).cwiseAbs().colwise().maxCoeff();
    });
    v_.maxCoeff(&longest);
    v_ = Omega.col(longest);
    double norm = v_.stableNorm();
    for (int k = 0; k < steps && norm > 0; ++k) {
      v_ /= norm;
      in_column_ranges(N_, column_nanoseconds() / 4, [&](Eigen::Index begin, Eigen::Index end) {
        Omega_v_.segment(begin, end - begin).noalias() = Omega.middleRows(begin, end - begin) * v_;
      });
      norm = Omega_v_.stableNorm();
      v_.swap(Omega_v_);
    }
    return 1.1 * norm;
  }

  /// Sets A = w∘S, or hΩ + w∘S.
  void weighted(Packed& S, Dense& A, const Dense* hOmega = nullptr) const {
    in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j) A.col(j).head(j + 1) = packed_column(S, j);
      mirror_columns(A, begin, end, 1);
    });
    in_column_ranges(N_, column_nanoseconds() / 2, [&](Eigen::Index begin, Eigen::Index end) {
      auto columns = A.middleCols(begin, end - begin);
      columns.array() *= weight_.middleCols(begin, end - begin).array();
      if (hOmega) columns += hOmega->middleCols(begin, end - begin);
    });
  }

  /// Sweeps from S, for h‖Ω‖ = s < 1, where evaluate() prepares residual(j), column j of g(S) − S.
  /// Returns whether the error of S is at most `enough`, or its residual, at most `rounding`, has
  /// not fallen for some sweeps.
  template <class Evaluate, class Residual>
  bool sweep(double s, double enough, double rounding, Packed& S, Evaluate&& evaluate,
             Residual&& residual) {
    constexpr int most = 400, patience = 8;
    const double c = (1 + std::sqrt(1 - s * s)) / 2, rate = s / (c + std::sqrt(c * c + s * s));
    double a = 1 / c, b = 0, least = std::numeric_limits<double>::infinity();
    int since_least = 0;
    before_ = S;
    for (int k = 0; k < most; ++k) {
      stop_point(static_cast<double>(weight_.size() * N_));
      evaluate();
      const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
        double largest = 0;
        for (Eigen::Index j = begin; j < end; ++j) {
          const auto now = packed_column(S, j);
          auto next = packed_column(before_, j);
          const auto r = residual(j);
          largest = std::max(largest, r.cwiseAbs().maxCoeff());
          next = now + a * r + b * (now - next);
        }
        return largest;
      };
      const double left = largest_in_column_ranges<double>(N_, column_nanoseconds(), columns);
      S.swap(before_);
      // what a sweep leaves of the residual, over what I − g′ is at least
      if (left * (k == 0 ? s : rate) / (1 - s * s) <= enough) return true;
      if (!(left < least) && ++since_least == patience) return least <= rounding;
      if (left < least) since_least = 0;
      least = std::min(least, left);
      a = k == 0 ? 2 * c / (2 * c * c + s * s) : 1 / (c + s * s / 4 * a);
      b = c * a - 1;
    }
    return false;
  }

 private:
  Eigen::Index N_;
  Dense weight_;
  Packed before_;
  Eigen::VectorXd v_, Omega_v_;
};

/// The step of the rigid body in N dimensions by the rotation of RotationEquation. The momentum
/// changes by
///
///     M_{k+1} − M_k = [Λ, U + Uᵀ]/h = 2 (λ_i − λ_j) S_ij/h,
///
/// which computes small quantities from small ones. Each sweep has one symmetric product, XᵀX. In
/// compensated arithmetic the residual of the last one is computed to nearly twice the precision.
class RotationN {
 public:
  using State = Accumulator<Dense>;

  RotationN(const Eigen::VectorXd& lambda, double h)
      : h_(h),
        N_(lambda.size()),
        lambda_(lambda),
        wide_lambda_(lambda.cast<Wide>()),
        equation_(lambda),
        split_(N_) {
    for (Eigen::VectorXd* S : {&S_, &f_, &delta_}) S->setZero(N_ * (N_ + 1) / 2);
    for (Dense* A : {&hOmega_, &X_, &G_, &epsilon_, &low_}) A->setZero(N_, N_);
  }

  /// Returns S, packed as in RotationEquation.
  Eigen::VectorXd& S() { return S_; }

  /// Finds S from an approximate one, so that U has an error of rounding; in compensated arithmetic
  /// `transport` finds the rest of its digits. Returns false where a λ is negative, h‖Ω‖ is near 1
  /// or more, the sweeps do not converge, or an angle of U is not below π/2. K = hM.
  bool solve(const Dense& K, bool compensated) {
    if (lambda_.minCoeff() < 0) return false;
    const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j) {
        hOmega_.col(j) = K.col(j).array() / (lambda_.array() + lambda_(j));
        hOmega_(j, j) = 0;
      }
      return hOmega_.middleCols(begin, end - begin).cwiseAbs().maxCoeff();
    };
    const double size =
        largest_in_column_ranges<double>(N_, equation_.column_nanoseconds(), columns);
    sine_ = equation_.norm(hOmega_);
    if (!(sine_ < 1)) return false;
    const double rounding = 0x1p-53 * size,
                 enough = compensated ? 0x1p-45 * sine_ * sine_ : rounding;
    f_.setZero();
    if (!find(S_, X_, enough, 64 * rounding)) return false;
    equation_.weighted(S_, X_, &hOmega_);
    return on_branch();
  }

  /// Sets S to that of a U found by another method.
  void set(const Dense& U_minus_I) {
    for (Eigen::Index j = 0; j < N_; ++j)
      packed_column(S_, j) = (U_minus_I.col(j) + U_minus_I.row(j).transpose()).head(j + 1) / 2;
  }

  /// Sets M ← UᵀMU, and Q ← QU = Q + Q(U − I) where x has a Q. When it is stopped, x is unchanged.
  void transport(State& x) {
    const Eigen::Index top = x.value.rows() - N_;
    if (x.compensated) form_carefully(x);
    if (top > 0) {
      stop_point(product_operations());
      G_.noalias() = x.value.topRows(N_) * X_;
    }
    in_column_ranges(N_, wide_column_nanoseconds() / 2, [&](Eigen::Index begin, Eigen::Index end) {
      x.compensated ? move_momentum_carefully(x, begin, end) : move_momentum_plainly(x, begin, end);
      if (top == 0) return;
      if (x.compensated)
        for (Eigen::Index j = begin; j < end; ++j)
          for (Eigen::Index i = 0; i < N_; ++i) x.add_scalar_with_carry(i, j, G_(i, j));
      else
        x.value.topRows(N_).middleCols(begin, end - begin) += G_.middleCols(begin, end - begin);
    });
    if (x.compensated) S_ += delta_;
  }

  /// Returns U − I of the last transport.
  const Dense& U_minus_I() const { return X_; }

 private:
  using Wide = long double;

  double wide_column_nanoseconds() const { return 10 * equation_.column_nanoseconds(); }
  double product_operations() const { return static_cast<double>(N_ * N_ * N_); }

  /// Finds the S of S = f − ½XᵀX near a given one. X is workspace.
  bool find(Eigen::VectorXd& S, Dense& X, double enough, double rounding) {
    return equation_.sweep(
        sine_, enough, rounding, S,
        [&] {
          equation_.weighted(S, X, &hOmega_);
          upper_gram(X, G_);
        },
        [&](Eigen::Index j) {
          return packed_column(f_, j) - packed_column(S, j) - G_.col(j).head(j + 1) / 2;
        });
  }

  /// The angles of U are below π/2 where its symmetric part I + S is positive definite. Then
  /// spec(UΛ) is in Re > 0: U is on the branch that starts at the identity.
  bool on_branch() {
    if (2 * S_.squaredNorm() < 1) return true;
    stop_point(product_operations());
    G_ = (X_ + X_.transpose()) / 2;
    G_.diagonal().array() += 1;
    return factor_positive(G_);
  }

  /// Computes U − I, and the correction δ of S, from M and its carry to nearly twice the precision.
  /// To first order δ is proportional to the residual f, so it follows from the S of a multiple of
  /// f that is far above rounding and far below S.
  void form_carefully(const State& x) {
    stop_point(2 * product_operations());
    const double size = careful_residual(x), enough = 0x1p-63 * sine_ * sine_;
    delta_.setZero();
    if (size > enough) {
      const double multiple = 0x1p-32 * binary_unit(sine_) / binary_unit(size);
      f_ *= multiple;
      delta_ = S_ + f_;
      find(delta_, low_, multiple * enough, multiple * size);
      delta_ = (delta_ - S_) / multiple;
      equation_.weighted(delta_, low_);
      epsilon_ += low_;
    }
    X_ += epsilon_;
  }

  /// Computes f = −½XᵀX − S from S and M with its carry. X becomes the rounded U − I, `epsilon` its
  /// rounding error. Returns the largest |f_ij|.
  double careful_residual(const State& x) {
    const Eigen::Index top = x.value.rows() - N_;
    const auto put = [this](Eigen::Index i, Eigen::Index j, Wide exact) {
      X_(i, j) = static_cast<double>(exact);
      epsilon_(i, j) = static_cast<double>(exact - X_(i, j));
    };
    in_column_ranges(N_, wide_column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j) {
        const auto S = packed_column(S_, j);
        for (Eigen::Index i = 0; i < j; ++i) {
          const Wide sum = wide_lambda_(i) + wide_lambda_(j),
                     hOmega = h_ * x.with_carry(top + i, j) / sum, share = 2 * Wide(S(i)) / sum;
          put(i, j, wide_lambda_(i) * share + hOmega);
          put(j, i, wide_lambda_(j) * share - hOmega);
        }
        put(j, j, S(j));
      }
    });
    split_(X_, epsilon_, G_, low_);
    const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
      double largest = 0;
      for (Eigen::Index j = begin; j < end; ++j) {
        auto f = packed_column(f_, j);
        f = -G_.col(j).head(j + 1) / 2 - packed_column(S_, j) -
            (low_.col(j).head(j + 1) + low_.row(j).head(j + 1).transpose()) / 2;
        largest = std::max(largest, f.cwiseAbs().maxCoeff());
      }
      return largest;
    };
    return largest_in_column_ranges<double>(N_, equation_.column_nanoseconds(), columns);
  }

  void move_momentum_plainly(State& x, Eigen::Index begin, Eigen::Index end) {
    auto M = x.value.bottomRows(N_);
    for (Eigen::Index j = begin; j < end; ++j)
      M.col(j).head(j + 1).array() +=
          2 / h_ * (lambda_.head(j + 1).array() - lambda_(j)) * packed_column(S_, j).array();
    mirror_columns(M, begin, end, -1);
  }
  void move_momentum_carefully(State& x, Eigen::Index begin, Eigen::Index end) {
    const Eigen::Index top = x.value.rows() - N_;
    for (Eigen::Index j = begin; j < end; ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Wide S = Wide(packed_column(S_, j)(i)) + packed_column(delta_, j)(i);
        x.add_with_carry(top + i, j, 2 * (wide_lambda_(i) - wide_lambda_(j)) * S / h_);
        x.mirror(top + i, j, top + j, i);
      }
  }

  double h_, sine_ = 0;  ///< `sine` is h‖Ω‖
  Eigen::Index N_;
  Eigen::VectorXd lambda_;
  Vector<Wide> wide_lambda_;
  RotationEquation equation_;
  SplitProduct split_;
  Eigen::VectorXd S_, f_, delta_;  ///< delta: what is to be added to S
  Dense hOmega_, X_, G_, epsilon_, low_;
};

}  // namespace stiefel
