#pragma once

#include <algorithm>

#include "engine/dense/anderson.h"
#include "engine/numbers/scalar.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Solves z = g(z) to rounding. Makes plain sweeps while each removes most of the error, and then
/// mixes the last few by Anderson's method. Allocates at construction only.
class FixedPoint {
 public:
  FixedPoint(Eigen::Index rows, Eigen::Index cols) : anderson_(rows, cols, 5) {}

  /// Starts from the given z; `sweep(z, g)` sets g = g(z). Ends when the residual is at rounding
  /// level or stagnates just above it. Returns false, and leaves z undefined, if the iteration does
  /// not converge.
  template <class Sweep>
  bool solve(Matrix<double>& z, Sweep&& sweep) {
    constexpr double unit = std::numeric_limits<double>::epsilon(), swift = 0.25, slow = 0.7;
    constexpr int most = 100;
    double last = 0;
    bool mixing = false;
    anderson_.restart();
    for (int k = 0; k < most; ++k) {
      stop_point(20.0 * static_cast<double>(z.size()));
      Matrix<double>&g = anderson_.g(), &f = anderson_.f();
      sweep(z, g);
      f = g - z;
      if (!((0 * f).sum() == 0)) return false;  // an element is infinite or not a number
      const double error = f.cwiseAbs().maxCoeff(), size = g.cwiseAbs().maxCoeff();
      const double ratio = k == 0 ? slow : error / last;
      const double expected = mixing || ratio > slow ? slow : ratio;
      z = g;
      if (error * expected <= unit / 2 * size || (ratio > slow && error <= 16 * unit * size))
        return true;
      mixing = mixing || (k > 0 && ratio > swift);
      anderson_.keep();
      if (mixing) anderson_.mix(z);
      last = error;
    }
    return false;
  }

 private:
  Anderson anderson_;
};

}  // namespace stiefel
