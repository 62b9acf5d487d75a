#pragma once

#include <Eigen/Jacobi>
#include <cmath>
#include <vector>

#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Solves z = g(z) to rounding by Newton's method, for g where no fixed-point iteration converges,
///
///     (I − g′)δ = g(z) − z,   z ← z + δ,
///
/// with g′v by differences and δ by GMRES (Saad and Schultz 1986; Knoll and Keyes 2004). Each δ
/// must be less than half of the one before, so the method finds a solution near the start or none.
/// Allocates at the first use.
template <class Scalar>
class NewtonKrylov {
 public:
  /// Starts from the given z; `sweep(z, g)` sets g = g(z). Returns false, and leaves z undefined,
  /// if it finds no solution.
  template <class Sweep>
  bool solve(Matrix<Scalar>& z, Sweep&& sweep) {
    const Scalar unit = two_to<Scalar>(1 - bits<Scalar>);
    constexpr int most = 30;
    prepare(z);
    Scalar last = std::numeric_limits<Scalar>::infinity();
    for (int k = 0; k < most; ++k) {
      stop_point(10.0 * static_cast<double>(z.size()));
      sweep(z, g_);
      f_ = g_ - z;
      // The scale of the solution. It is taken from z, because g may be larger by powers of h far
      // from the solution.
      const Scalar scale = z.norm() > Scalar(0) ? z.norm() : g_.norm();
      if (!f_.allFinite()) return false;
      if (f_.norm() == Scalar(0)) return true;
      find_delta(z, scale, sweep);
      const Scalar size = delta_.norm();
      if (!(size < last / 2)) return last <= 64 * unit * scale;
      z += delta_;
      if (size <= unit / 4 * scale) return true;
      last = size;
    }
    return false;
  }

 private:
  static constexpr Eigen::Index most_directions = 120;

  void prepare(const Matrix<Scalar>& z) {
    if (g_.size() == z.size()) return;
    const Eigen::Index directions = std::min(most_directions, z.size());
    g_ = f_ = delta_ = moved_ = z;
    basis_.resize(z.size(), directions + 1);
    hessenberg_.resize(directions + 1, directions);
    rotations_.resize(static_cast<std::size_t>(directions));
    right_.resize(directions + 1);
  }

  /// Computes δ with as many directions of the Krylov space as the tolerance needs.
  template <class Sweep>
  void find_delta(const Matrix<Scalar>& z, Scalar scale, Sweep& sweep) {
    using std::sqrt;
    const Scalar step = sqrt(two_to<Scalar>(-bits<Scalar>)) * scale;
    const Scalar enough = two_to<Scalar>(-bits<Scalar> / 2 - 6);
    const Scalar size = f_.norm();
    basis_.col(0) = f_.reshaped() / size;
    right_.setZero();
    right_(0) = size;
    Eigen::Index used = 0;
    while (used < hessenberg_.cols()) {
      const Eigen::Index k = used++;
      stop_point(4.0 * static_cast<double>((k + 1) * z.size()));
      moved_.reshaped() = z.reshaped() + step * basis_.col(k);
      sweep(moved_, delta_);
      auto next = basis_.col(k + 1);
      next = basis_.col(k) - (delta_.reshaped() - g_.reshaped()) / step;
      orthogonalise(k);
      rotate(k);
      using std::abs;
      if (!(abs(right_(k + 1)) > enough * size)) break;
    }
    const auto R = hessenberg_.topLeftCorner(used, used).template triangularView<Eigen::Upper>();
    auto y = right_.head(used);
    R.solveInPlace(y);
    delta_.reshaped() = basis_.leftCols(used) * y;
  }

  /// Orthogonalises column k + 1 of the basis against the columns before it, twice: one pass leaves
  /// errors above rounding.
  void orthogonalise(Eigen::Index k) {
    auto next = basis_.col(k + 1);
    auto column = hessenberg_.col(k);
    column.setZero();
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index i = 0; i <= k; ++i) {
        stop_point();
        const Scalar along = basis_.col(i).dot(next);
        column(i) += along;
        next -= along * basis_.col(i);
      }
    column(k + 1) = next.norm();
    if (column(k + 1) > Scalar(0)) next /= column(k + 1);
  }

  /// Applies Givens rotations, which make the Hessenberg matrix triangular.
  void rotate(Eigen::Index k) {
    auto column = hessenberg_.col(k);
    for (Eigen::Index i = 0; i < k; ++i)
      column.applyOnTheLeft(i, i + 1, rotations_[std::size_t(i)].adjoint());
    auto& last = rotations_[std::size_t(k)];
    last.makeGivens(column(k), column(k + 1), &column(k));
    column(k + 1) = 0;
    right_.applyOnTheLeft(k, k + 1, last.adjoint());
  }

  Matrix<Scalar> g_, f_, delta_, moved_, basis_, hessenberg_;
  std::vector<Eigen::JacobiRotation<Scalar>> rotations_;
  Vector<Scalar> right_;
};

}  // namespace stiefel
