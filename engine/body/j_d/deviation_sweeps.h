#pragma once

#include <algorithm>
#include <cmath>

#include "engine/dense/lagged_anderson.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/parallel.h"
#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Sets the elements below the diagonal of a square block to `sign` times those above it, for those
/// above it in columns begin ... end - 1: tile by tile, so that columns and rows stay in the cache.
/// `begin` is a multiple of the tile's 16 columns.
template <class Block>
void mirror_columns(Block& A, Eigen::Index begin, Eigen::Index end, int sign) {
  using Scalar = typename Block::Scalar;
  constexpr Eigen::Index tile = 16;
  for (Eigen::Index j = begin; j < end; j += tile) {
    const Eigen::Index width = std::min(tile, end - j);
    for (Eigen::Index i = 0; i < j; i += tile)
      A.block(j, i, width, tile) = Scalar(sign) * A.block(i, j, tile, width).transpose();
    for (Eigen::Index l = j; l < j + width; ++l)
      for (Eigen::Index k = j; k < l; ++k) A(l, k) = Scalar(sign) * A(k, l);
  }
}
/// Sets all elements below the diagonal of a square block to `sign` times those above it.
template <class Block>
void mirror_upper(Block&& A, int sign = 1) {
  mirror_columns(A, 0, A.cols(), sign);
}

/// Finds U = J_D⁻¹(hM) in N dimensions as the deviation X = UΛ − Λ = hΩΛ + R, Ω = J⁻¹(M), R
/// symmetric ([RB] (7.13), (7.14) with S = Λ + R + the symmetric part of hΩΛ), by the fixed-point
/// iteration of
///
///     (Λ + X)ᵀ(Λ + X) = Λ²   ⟺   R_ij = −(XᵀX)_ij / (λ_i + λ_j),
///
/// with one symmetric product in each sweep. At Λ = I the derivative of the iteration is a
/// commutator with hΩ, whose eigenvalues are imaginary; LaggedAnderson accelerates it. Small
/// quantities stay relatively accurate. Every symmetric R satisfies UΛ − ΛUᵀ = hM, so the stopping
/// test is Λ⁻¹(WᵀW − Λ²)Λ⁻¹ = UᵀU − I, W = Λ + X. For λ_i > 0 of moderate spread.
template <class Scalar>
class DeviationSweeps {
 public:
  explicit DeviationSweeps(const Vector<Scalar>& lambda);

  /// Returns R on and above the diagonal, column after column.
  Vector<Scalar>& R() { return R_; }

  /// Sweeps from the current R until UᵀU − I is at rounding level or, with `to_its_last_bit`, until
  /// R, which is of the size of X², is accurate to rounding. Returns false if the sweeps converge
  /// slowly. K = hM.
  bool sweep(const Matrix<Scalar>& K, bool to_its_last_bit);

  /// Sets X to a solution found by another method.
  void set(const Matrix<Scalar>& X, const Matrix<Scalar>& K);

 protected:
  auto R_column(Eigen::Index j) { return R_.segment(j * (j + 1) / 2, j + 1); }

  Vector<Scalar> lambda_;
  Eigen::Index N_;
  Vector<Scalar> R_;
  Matrix<Scalar> X_, G_;  ///< G_ is XᵀX on and above the diagonal

 private:
  /// Computes hΩΛ, with the elements K_ijλ_j/(λ_i + λ_j).
  void form_hOmegaLambda(const Matrix<Scalar>& K);
  void form_X();

  /// Sets R ← −XᵀX/(λ_i + λ_j), accelerated. Returns the largest change of UᵀU − I.
  Scalar correct();

  /// Returns the largest |X_ij| / min(λ_i, λ_j), which bounds the elements of U − I = XΛ⁻¹.
  Scalar size() const;

  /// A rough time of a pass over one column.
  double column_nanoseconds() const { return static_cast<double>(N_); }

  Vector<Scalar> inverse_, next_;
  LaggedAnderson<Scalar> accelerate_;
  Matrix<Scalar> hOmegaLambda_;
};

template <class Scalar>
DeviationSweeps<Scalar>::DeviationSweeps(const Vector<Scalar>& lambda)
    : lambda_(lambda),
      N_(lambda.size()),
      R_(Vector<Scalar>::Zero(N_ * (N_ + 1) / 2)),
      X_(Matrix<Scalar>::Zero(N_, N_)),
      G_(X_),
      inverse_(lambda.cwiseInverse()),
      next_(R_),
      accelerate_(R_.size()),
      hOmegaLambda_(X_) {}

template <class Scalar>
bool DeviationSweeps<Scalar>::sweep(const Matrix<Scalar>& K, bool to_its_last_bit) {
  const Scalar unit = two_to<Scalar>(-bits<Scalar>), slow = Scalar(0.7);
  constexpr int most = 40;
  form_hOmegaLambda(K);
  form_X();
  accelerate_.restart();
  const Scalar size = this->size(), enough = unit * (to_its_last_bit ? size * size : size);
  if (!(size <= 1)) return false;
  Scalar last = 0;
  for (int k = 0; k < most; ++k) {
    stop_point(static_cast<double>(N_ * N_ * N_));
    const Scalar defect = correct();
    const Scalar ratio = k == 0 ? slow : defect / last;
    const bool stagnates = k > 0 && !(ratio <= slow);
    const bool reached = defect * ratio <= enough || (stagnates && defect <= 64 * unit * size);
    if (stagnates && !reached) return false;
    form_X();
    if (reached) return true;
    last = defect;
  }
  return false;
}

template <class Scalar>
Scalar DeviationSweeps<Scalar>::size() const {
  return largest_in_column_ranges<Scalar>(N_, column_nanoseconds(), [&](auto begin, auto end) {
    Scalar size = 0;
    for (Eigen::Index j = begin; j < end; ++j)
      size = std::max<Scalar>(
          size, X_.col(j).cwiseAbs().cwiseProduct(inverse_.cwiseMax(inverse_(j))).maxCoeff());
    return size;
  });
}

template <class Scalar>
Scalar DeviationSweeps<Scalar>::correct() {
  upper_gram(X_, G_);
  const auto columns = [&](Eigen::Index begin, Eigen::Index end) {
    Scalar defect = 0;
    for (Eigen::Index j = begin; j < end; ++j) {
      const auto inverse = inverse_.head(j + 1).array() + inverse_(j);
      auto next = next_.segment(j * (j + 1) / 2, j + 1);
      next = -G_.col(j).head(j + 1).array() / (lambda_.head(j + 1).array() + lambda_(j));
      defect = std::max<Scalar>(defect, ((next - R_column(j)).array().abs() * inverse).maxCoeff());
    }
    return defect;
  };
  const Scalar defect = largest_in_column_ranges<Scalar>(N_, column_nanoseconds(), columns);
  accelerate_(R_, next_);
  return defect;
}

template <class Scalar>
void DeviationSweeps<Scalar>::form_hOmegaLambda(const Matrix<Scalar>& K) {
  in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j)
      hOmegaLambda_.col(j) = lambda_(j) * K.col(j).array() / (lambda_.array() + lambda_(j));
  });
}

template <class Scalar>
void DeviationSweeps<Scalar>::form_X() {
  in_column_ranges(N_, column_nanoseconds(), [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j) X_.col(j).head(j + 1) = R_column(j);
    mirror_columns(X_, begin, end, 1);
  });
  in_column_ranges(N_, column_nanoseconds() / 2, [&](Eigen::Index begin, Eigen::Index end) {
    X_.middleCols(begin, end - begin) += hOmegaLambda_.middleCols(begin, end - begin);
  });
}

template <class Scalar>
void DeviationSweeps<Scalar>::set(const Matrix<Scalar>& X, const Matrix<Scalar>& K) {
  form_hOmegaLambda(K);
  X_ = X - hOmegaLambda_;
  for (Eigen::Index j = 0; j < N_; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) R_column(j)(i) = (X_(i, j) + X_(j, i)) / 2;
  form_X();
}

// Compiled once, in j_d_n.cc.
extern template class DeviationSweeps<double>;

}  // namespace stiefel
