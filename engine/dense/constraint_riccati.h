#pragma once

#include <cmath>
#include <limits>

#include "engine/dense/lyapunov_equation.h"
#include "stiefel/stop.h"

namespace stiefel {

/// Finds the multiplier of a constraint on frames: the symmetric n × n matrix Y for which Q′ = D +
/// YG has orthonormal rows. With A = GDᵀ, P = GGᵀ and E = DDᵀ − I, it solves
///
///     Q′Q′ᵀ − I = E + YA + AᵀY + YPY = 0
///
/// on the branch spec(C) in Re > 0, C = A + PY = GQ′ᵀ; there is at most one such Y. Newton's method
/// is CᵀδY + δY C = −(Q′Q′ᵀ − I). The equation is quadratic, so after a correction Q′Q′ᵀ − I = δY P
/// δY exactly; the iteration stops when δY P δY is at rounding level. n = 1 is solved in closed
/// form. Does not allocate after construction.
template <class Scalar>
class ConstraintRiccati {
 public:
  explicit ConstraintRiccati(Eigen::Index n)
      : lyapunov_(n), C_(n, n), PY_(n, n), delta_(n, n), product_(n, n) {}

  /// Starts from the given Y. Returns false, and leaves Y undefined, if it finds no solution on the
  /// branch.
  bool solve(const Matrix<Scalar>& A, const Matrix<Scalar>& P, const Matrix<Scalar>& E,
             Matrix<Scalar>& Y);

 private:
  /// Solves pY² + 2aY + e = 0 with a + pY > 0.
  static bool closed(Scalar a, Scalar p, Scalar e, Scalar& Y);

  bool newton(const Matrix<Scalar>& A, const Matrix<Scalar>& P, const Matrix<Scalar>& E,
              Matrix<Scalar>& Y);

  Lyapunov<Scalar> lyapunov_;
  Matrix<Scalar> C_, PY_, delta_, product_;
};

template <class Scalar>
bool ConstraintRiccati<Scalar>::solve(const Matrix<Scalar>& A, const Matrix<Scalar>& P,
                                      const Matrix<Scalar>& E, Matrix<Scalar>& Y) {
  return Y.rows() == 1 ? closed(A(0, 0), P(0, 0), E(0, 0), Y(0, 0)) : newton(A, P, E, Y);
}

template <class Scalar>
bool ConstraintRiccati<Scalar>::closed(Scalar a, Scalar p, Scalar e, Scalar& Y) {
  using std::sqrt;
  const Scalar square = a * a - p * e;
  if (!(square > 0)) return false;
  Y = a > 0 ? -e / (a + sqrt(square)) : (sqrt(square) - a) / p;
  return true;
}

template <class Scalar>
bool ConstraintRiccati<Scalar>::newton(const Matrix<Scalar>& A, const Matrix<Scalar>& P,
                                       const Matrix<Scalar>& E, Matrix<Scalar>& Y) {
  const Scalar enough = std::numeric_limits<Scalar>::epsilon() / 4 * E.cwiseAbs().maxCoeff();
  constexpr int most = 30;
  for (int k = 0; k < most; ++k) {
    stop_point(6 * static_cast<double>(Y.rows() * Y.size()));
    PY_.noalias() = P * Y;
    C_ = A + PY_;
    delta_.noalias() = Y * A;
    product_.noalias() = Y * PY_;
    product_ += E + delta_ + delta_.transpose();
    if (!product_.allFinite()) return false;
    lyapunov_.factor(C_);
    lyapunov_.solve(product_, delta_);
    product_ = (delta_ + delta_.transpose()) / 2;
    Y -= product_;
    PY_.noalias() = P * product_;
    delta_.noalias() = product_ * PY_;
    if (delta_.cwiseAbs().maxCoeff() <= enough) return lyapunov_.smallest_real_part() > 0;
  }
  return false;
}

// Compiled once, in lyapunov_equation.cc.
extern template class ConstraintRiccati<double>;

}  // namespace stiefel
