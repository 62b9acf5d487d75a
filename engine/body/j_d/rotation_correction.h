#pragma once

#include <algorithm>
#include <cmath>

#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

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
template <class Scalar>
class RotationCorrection {
 public:
  explicit RotationCorrection(const Matrix<Scalar>& weight)
      : weight_(weight.template cast<float>()),
        X_(weight_),
        f_(weight_),
        delta_(weight_),
        before_(weight_),
        E_(weight_),
        A_(weight_),
        P_(weight_) {}

  /// Solves until what is left of the residual is `enough` or, at the limit of single precision,
  /// 2^-20 of its largest element, `size` > 0; returns what is left. `sine` < 1 is h‖Ω‖. If the
  /// sweeps diverge, sets δ = 0 and returns `size`.
  Scalar solve(const Matrix<Scalar>& X, const Matrix<Scalar>& f, Scalar size, Scalar sine,
               Scalar enough);

  void set_zero() { delta_.setZero(); }

  Scalar operator()(Eigen::Index i, Eigen::Index j) const { return unit_ * Scalar(delta_(i, j)); }
  auto delta() const { return unit_ * delta_.template cast<Scalar>(); }

 private:
  static constexpr Eigen::Index tile = 16;
  using Tile = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, 0, tile, tile>;

  /// Sets δ ← δ + a·r + b·(δ − the δ before), r = f − ½(P + Pᵀ) − δ. Returns the largest |r_ij|.
  float advance(float a, float b);

  Scalar unit_ = 1;  ///< f and δ are kept in this unit
  Matrix<float> weight_, X_, f_, delta_, before_, E_, A_, P_;
};

template <class Scalar>
Scalar RotationCorrection<Scalar>::solve(const Matrix<Scalar>& X, const Matrix<Scalar>& f,
                                         Scalar size, Scalar sine, Scalar enough) {
  constexpr int most = 64;
  const auto s = static_cast<float>(sine), c = (1 + std::sqrt(1 - s * s)) / 2;
  unit_ = binary_unit(size);
  const float limit = std::max(two_to<float>(-20), static_cast<float>(enough / unit_));
  X_ = X.template cast<float>();
  f_ = (f / unit_).template cast<float>();
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
  return unit_ * Scalar(left);
}

template <class Scalar>
float RotationCorrection<Scalar>::advance(float a, float b) {
  const Eigen::Index N = f_.rows();
  float largest = 0;
  for (Eigen::Index j = 0; j < N; j += tile)
    for (Eigen::Index i = 0; i <= j; i += tile) {
      const Eigen::Index rows = std::min(tile, N - i), columns = std::min(tile, N - j);
      const auto at = [&](Matrix<float>& A) { return A.block(i, j, rows, columns); };
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

}  // namespace stiefel
