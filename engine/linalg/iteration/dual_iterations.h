#pragma once

#include <Eigen/LU>
#include <algorithm>

#include "engine/linalg/iteration/fixed_point.h"
#include "engine/linalg/iteration/newton_krylov.h"
#include "engine/numbers/dual.h"

namespace stiefel {

/// z = g(z) in dual numbers. The derivatives solve the linear equation z′ = g_z z′ + g′; the sweeps
/// go on until values and derivatives both have residuals at rounding level, so the derivatives are
/// those of the solution.
template <class Real, int lanes>
class FixedPoint<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  FixedPoint(Eigen::Index rows, Eigen::Index cols) : g_(rows, cols) {}

  /// Returns false, and leaves z undefined, if the sweeps converge slowly or not at all.
  template <class Sweep>
  bool solve(Matrix<Scalar>& z, Sweep&& sweep) {
    const Real unit = two_to<Real>(1 - bits<Real>), slow = Real(0.7);
    constexpr int most = 100;
    Real last[1 + lanes] = {};
    for (int k = 0; k < most; ++k) {
      stop_point(20.0 * static_cast<double>(z.size()));
      sweep(z, g_);
      if (!g_.allFinite()) return false;
      bool all = true;
      for (int part = 0; part <= lanes; ++part) {
        Real error = 0, size = 0;
        for (Eigen::Index i = 0; i < z.size(); ++i) {
          const Real g = at(g_(i), part);
          error = std::max(error, std::abs(g - at(z(i), part)));
          size = std::max(size, std::abs(g));
        }
        const Real ratio = k == 0 ? slow : error / last[part];
        if (k > 8 && error > 0 && ratio > slow && error > 64 * unit * size) return false;
        all = all && (error * std::min(ratio, slow) <= unit / 2 * size ||
                      (ratio > slow && error <= 16 * unit * size) || error == 0);
        last[part] = error;
      }
      z = g_;
      if (all) return true;
    }
    return false;
  }

 private:
  static Real at(const Scalar& x, int part) { return part == 0 ? x.value : x.d[part - 1]; }

  Matrix<Scalar> g_;
};

/// z = g(z) in dual numbers by Newton's method with the dense matrix I − g_z, whose columns are the
/// derivatives of sweeps along the unit vectors: δ for the values until they no longer change, then
/// (I − g_z) z′ = g′ once.
template <class Real, int lanes>
class NewtonKrylov<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  template <class Sweep>
  bool solve(Matrix<Scalar>& z, Sweep&& sweep) {
    const Real unit = two_to<Real>(1 - bits<Real>);
    constexpr int most = 30;
    const Eigen::Index size = z.size();
    Real last = std::numeric_limits<Real>::infinity();
    Matrix<Scalar> g = z;
    for (int k = 0; k < most; ++k) {
      z = values_of(z).template cast<Scalar>();
      sweep(z, g);
      if (!g.allFinite()) return false;
      const Matrix<Scalar> base = g;
      Matrix<Real> I_minus_J = Matrix<Real>::Identity(size, size);
      for (Eigen::Index first = 0; first < size; first += lanes) {
        Matrix<Scalar> moved = z;
        const Eigen::Index count = std::min<Eigen::Index>(lanes, size - first);
        for (Eigen::Index c = 0; c < count; ++c) moved(first + c).d[c] = 1;
        sweep(moved, g);
        for (Eigen::Index c = 0; c < count; ++c)
          for (Eigen::Index i = 0; i < size; ++i)
            I_minus_J(i, first + c) -= g(i).d[c] - base(i).d[c];
      }
      stop_point(static_cast<double>(size * size * size) / 3);
      const Eigen::PartialPivLU<Matrix<Real>> lu(I_minus_J);
      const Vector<Real> delta = lu.solve((values_of(base) - values_of(z)).reshaped());
      const Real change = delta.norm(), scale = values_of(z).norm();
      if (!(change < last / 2) && !(last <= 64 * unit * scale)) return false;
      for (Eigen::Index i = 0; i < size; ++i) z(i).value += delta(i);
      if (change <= unit * scale || last <= 64 * unit * scale) {
        for (int lane = 0; lane < lanes; ++lane) {
          const Vector<Real> part = lu.solve(lane_of(base, lane).reshaped());
          for (Eigen::Index i = 0; i < size; ++i) z(i).d[lane] = part(i);
        }
        return true;
      }
      last = change;
    }
    return false;
  }
};

}  // namespace stiefel
