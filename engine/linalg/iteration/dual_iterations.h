#pragma once

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

/// z = g(z) in dual numbers by Newton's method for the values, then for each derivative, which
/// solves the linear equation z′ = g_z z′ + g′.
template <class Real, int lanes>
class NewtonKrylov<Dual<Real, lanes>> {
 public:
  using Scalar = Dual<Real, lanes>;

  template <class Sweep>
  bool solve(Matrix<Scalar>& z, Sweep&& sweep) {
    Matrix<Scalar> g = z;
    const Matrix<Scalar> start = z;
    z = values_of(z).template cast<Scalar>();
    for (int part = 0; part <= lanes; ++part) {
      Matrix<Real> x = get(start, part);
      const auto sweep_part = [&](const Matrix<Real>& y, Matrix<Real>& out) {
        set(z, part, y);
        sweep(z, g);
        out = get(g, part);
      };
      if (!newton_.solve(x, sweep_part)) return false;
      set(z, part, x);
    }
    return true;
  }

 private:
  static void set(Matrix<Scalar>& z, int part, const Matrix<Real>& x) {
    part == 0 ? set_values(z, x) : set_lane(z, part - 1, x);
  }
  static Matrix<Real> get(const Matrix<Scalar>& z, int part) {
    return part == 0 ? values_of(z) : lane_of(z, part - 1);
  }

  NewtonKrylov<Real> newton_;
};

}  // namespace stiefel
