#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/body/j_d/deviation_n.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"

namespace stiefel {

/// Solves S = −½XᵀX, X = hΩ + w∘S (RotationN) in single precision for the correction δ of an S with
/// the residual f = −½XᵀX − S:
///
///     δ = f − ½ (P + Pᵀ),   P = (X + ½E)ᵀE,   E = w∘δ,
///
/// with one product in each sweep. Let α be the largest angle of the rotation U. The derivative of
/// the right side has eigenvalues close to 1 − ½(e^{iα_k} + e^{iα_l}), which it has exactly at
/// Λ = I; they lie in [0, 1 − cos α] × i[−sin α, sin α], sin α ≤ h‖Ω‖, however wide Λ is spread.
/// Chebyshev's semi-iteration (Manteuffel 1977) for the vertical segment through the middle of this
/// rectangle reduces the error by sin α/(c + √(c² + sin² α)), c = ½(1 + cos α), in each sweep: 1/20
/// at h‖Ω‖ = 0.1, 1/4 at 0.5. Allocates at construction only.
class RotationCorrection {
 public:
  using Dense = Eigen::MatrixXd;

  explicit RotationCorrection(const Dense& weight) : weight_(weight.cast<float>()) {
    for (Single* A : {&X_, &f_, &delta_, &before_, &E_, &A_, &P_}) *A = weight_;
  }

  /// Solves until what is left of the residual is `enough` or, at the limit of single precision,
  /// 2^-20 of its largest element, `size` > 0; returns what is left. `sine` < 1 is h‖Ω‖. If the
  /// sweeps diverge, sets δ = 0 and returns `size`.
  double solve(const Dense& X, const Dense& f, double size, double sine, double enough) {
    constexpr int most = 64;
    const auto s = static_cast<float>(sine), c = (1 + std::sqrt(1 - s * s)) / 2;
    unit_ = binary_unit(size);
    const float limit = std::max(0x1p-20f, static_cast<float>(enough / unit_));
    X_ = X.cast<float>();
    f_ = (f / unit_).cast<float>();
    delta_ = f_;
    before_ = f_;
    const auto half_unit = static_cast<float>(unit_ / 2);
    float a = 1 / c, b = 0, left = 0;
    for (int k = 0; k < most; ++k) {
      stop_point(static_cast<double>(X_.rows() * X_.size()));
      E_ = weight_.cwiseProduct(delta_);
      A_ = X_ + half_unit * E_;
      P_.noalias() = A_.transpose() * E_;
      left = advance(a, b);
      if (left <= limit) break;
      if (!(left < 8)) {  // at the start it is at most 2 sine (1 + size)
        set_zero();
        return size;
      }
      a = k == 0 ? 2 * c / (2 * c * c + s * s) : 1 / (c + s * s / 4 * a);
      b = c * a - 1;
    }
    return unit_ * double(left);
  }

  void set_zero() { delta_.setZero(); }

  double operator()(Eigen::Index i, Eigen::Index j) const { return unit_ * double(delta_(i, j)); }
  auto delta() const { return unit_ * delta_.cast<double>(); }

 private:
  using Single = Matrix<float>;
  static constexpr Eigen::Index tile = 16;
  using Tile = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, 0, tile, tile>;

  /// Sets δ ← δ + a·r + b·(δ − the δ before), r = f − ½(P + Pᵀ) − δ. Returns the largest |r_ij|.
  float advance(float a, float b) {
    const Eigen::Index N = f_.rows();
    float largest = 0;
    for (Eigen::Index j = 0; j < N; j += tile)
      for (Eigen::Index i = 0; i <= j; i += tile) {
        const Eigen::Index rows = std::min(tile, N - i), columns = std::min(tile, N - j);
        const auto at = [&](Single& A) { return A.block(i, j, rows, columns); };
        const Tile now = at(delta_);
        const Tile r = at(f_) - now - (at(P_) + P_.block(j, i, columns, rows).transpose()) / 2;
        const Tile next = now + a * r + b * (now - at(before_));
        largest = std::max(largest, r.cwiseAbs().maxCoeff());
        at(before_) = now;
        at(delta_) = next;
        delta_.block(j, i, columns, rows) = next.transpose();
      }
    return largest;
  }

  double unit_ = 1;  ///< f and δ are kept in this unit
  Single weight_, X_, f_, delta_, before_, E_, A_, P_;
};

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
class RotationN {
 public:
  using Dense = Eigen::MatrixXd;
  using State = Accumulator<Dense>;

  RotationN(const Eigen::VectorXd& lambda, double h)
      : h_(h),
        N_(lambda.size()),
        lambda_(lambda),
        packed_(Eigen::VectorXd::Zero(N_ * (N_ + 1) / 2)),
        v_(lambda),
        Av_(lambda),
        wide_lambda_(lambda.cast<Wide>()),
        weight_(rotation_weights(lambda)),
        split_(N_),
        correction_(weight_) {
    for (Dense* A : {&hOmega_, &S_, &X_, &G_, &epsilon_, &low_}) A->setZero(N_, N_);
  }

  /// Returns S on and above the diagonal, column after column.
  Eigen::VectorXd& S() { return packed_; }

  /// Finds S from an approximate one, near which `transport` finds the rest of its digits
  /// if the arithmetic is compensated. Returns false where h‖Ω‖ is near 1 or more, or the
  /// corrections converge slowly, or an angle of U is not below π/2. K = hM.
  bool solve(const Dense& K, bool compensated) {
    inverse_inertia(lambda_, K, hOmega_);
    sine_ = norm_of_skew(hOmega_, v_, Av_);
    if (!(sine_ < 1)) return false;
    for (Eigen::Index j = 0; j < N_; ++j) S_.col(j).head(j + 1) = column_of(packed_, j);
    mirror_upper(S_);
    const double enough = compensated ? 0x1p-41 * sine_ * sine_ : 0x1p-53 * sine_;
    double size = residual(), last = std::numeric_limits<double>::infinity();
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

  /// Sets S to that of a U found by another method.
  void set(const Dense& U_minus_I) {
    S_ = (U_minus_I + U_minus_I.transpose()) / 2;
    pack();
  }

  /// Sets M ← UᵀMU, and Q ← QU = Q + Q(U − I) where x has a Q. When it is stopped, x is unchanged.
  void transport(State& x) {
    const bool has_frame = x.value.rows() > N_;
    if (x.compensated) form_carefully(x);
    if (has_frame) {
      stop_point(product_operations());
      G_.noalias() = x.value.topRows(N_) * X_;
    }
    x.compensated ? move_momentum_carefully(x) : move_momentum_plainly(x);
    if (has_frame)
      for (Eigen::Index j = 0; j < N_; ++j)
        for (Eigen::Index i = 0; i < N_; ++i) x.add_scalar(i, j, G_(i, j));
    pack();
  }

  /// Returns U − I of the last transport.
  const Dense& U_minus_I() const { return X_; }

 private:
  using Wide = long double;

  static Eigen::VectorXd::SegmentReturnType column_of(Eigen::VectorXd& packed, Eigen::Index j) {
    return packed.segment(j * (j + 1) / 2, j + 1);
  }
  double product_operations() const { return static_cast<double>(N_ * N_ * N_); }

  /// Computes X and G = f = −½XᵀX − S from S. Returns the largest |f_ij|.
  double residual() {
    stop_point(product_operations());
    X_ = hOmega_ + weight_.cwiseProduct(S_);
    G_.triangularView<Eigen::Upper>().setZero();
    G_.selfadjointView<Eigen::Upper>().rankUpdate(X_.transpose());
    double size = 0;
    for (Eigen::Index j = 0; j < N_; ++j) {
      auto f = G_.col(j).head(j + 1);
      f = -f / 2 - S_.col(j).head(j + 1);
      size = std::max(size, f.cwiseAbs().maxCoeff());
    }
    mirror_upper(G_);
    return size;
  }

  /// The angles of U are below π/2 where its symmetric part I + S is positive definite. Then
  /// spec(UΛ) is in Re > 0: U is on the branch that starts at the identity.
  bool on_branch() {
    if (S_.squaredNorm() < 1) return true;
    stop_point(product_operations());
    G_ = S_;
    G_.diagonal().array() += 1;
    return factor_positive(G_);
  }

  /// Computes U − I, and what is to be added to S, from M and its carry to nearly twice the
  /// precision.
  void form_carefully(const State& x) {
    const double size = careful_residual(x), enough = 0x1p-63 * sine_ * sine_;
    if (size > enough)
      correction_.solve(X_, G_, size, sine_, enough);
    else
      correction_.set_zero();
    X_ += epsilon_ + weight_.cwiseProduct(correction_.delta());
  }

  /// Computes G = f from S and M with its carry. X becomes the rounded U − I, `epsilon_` its
  /// rounding error. Returns the largest |f_ij|.
  double careful_residual(const State& x) {
    const Eigen::Index top = x.value.rows() - N_;
    const auto put = [this](Eigen::Index i, Eigen::Index j, Wide exact) {
      X_(i, j) = static_cast<double>(exact);
      epsilon_(i, j) = static_cast<double>(exact - X_(i, j));
    };
    stop_point(2 * product_operations());
    for (Eigen::Index j = 0; j < N_; ++j) {
      for (Eigen::Index i = 0; i < j; ++i) {
        const Wide sum = wide_lambda_(i) + wide_lambda_(j),
                   hOmega = h_ * x.with_carry(top + i, j) / sum, share = 2 * Wide(S_(i, j)) / sum;
        put(i, j, wide_lambda_(i) * share + hOmega);
        put(j, i, wide_lambda_(j) * share - hOmega);
      }
      put(j, j, S_(j, j));
    }
    split_(X_, epsilon_, G_, low_);
    double size = 0;
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {
        G_(i, j) = -G_(i, j) / 2 - S_(i, j) - (low_(i, j) + low_(j, i)) / 2;
        size = std::max(size, std::abs(G_(i, j)));
      }
    mirror_upper(G_);
    return size;
  }

  void move_momentum_plainly(State& x) {
    auto M = x.value.bottomRows(N_);
    for (Eigen::Index j = 0; j < N_; ++j)
      M.col(j).head(j + 1).array() +=
          2 * (lambda_.head(j + 1).array() - lambda_(j)) * S_.col(j).head(j + 1).array() / h_;
    mirror_upper(M, -1);
  }
  void move_momentum_carefully(State& x) {
    const Eigen::Index top = x.value.rows() - N_;
    for (Eigen::Index j = 0; j < N_; ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Wide S = Wide(S_(i, j)) + correction_(i, j);
        x.add_with_carry(top + i, j, 2 * (wide_lambda_(i) - wide_lambda_(j)) * S / h_);
        x.mirror(top + i, j, top + j, i);
      }
    S_ += correction_.delta();
  }
  void pack() {
    for (Eigen::Index j = 0; j < N_; ++j) column_of(packed_, j) = S_.col(j).head(j + 1);
  }

  double h_, sine_ = 0;
  Eigen::Index N_;
  Eigen::VectorXd lambda_, packed_, v_, Av_;
  Vector<Wide> wide_lambda_;
  Dense weight_, hOmega_, S_, X_, G_, epsilon_, low_;
  SplitProduct<double> split_;
  RotationCorrection correction_;
};

}  // namespace stiefel
