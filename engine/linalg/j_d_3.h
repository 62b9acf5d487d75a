#pragma once

#include <Eigen/LU>
#include <cmath>

#include "engine/linalg/compensated.h"
#include "engine/linalg/so_3.h"

namespace stiefel {

/// U = J_D⁻¹(hM), that is UΛ − ΛUᵀ = hM, in three dimensions, as the Cayley transform
/// U = (I − C)⁻¹(I + C) with C = hat(c):
///
///     ΛC + CΛ = ½ (I − C) hM (I + C)   ⟺   F(c) = I∘c − (h/2)(m + m×c + (c·m) c) = 0,
///
/// I the moments of inertia. It divides by no λ_i, so thin plates are bodies like others. Newton;
/// F′ has the eigenvalues w_i + w_j, w = spec(UΛ), so the branch that starts at the identity lasts
/// as long as their real parts are positive.
template <class Scalar, bool frame, Arithmetic arithmetic>
class JDInverse3 {
 public:
  using Point = typename So3<Scalar, frame>::State;
  using State = Accumulator<Point, arithmetic>;
  using Wide = Extended<Scalar>;

  /// Newton needs no history.
  struct Memory {
    template <class Visitor>
    void each(Visitor&&) {}
  };

  JDInverse3(const Vector<Scalar>& lambda, Scalar h) : h_(h) {
    const Vector3<Wide> l = lambda.template cast<Wide>();
    inertia_ << l(1) + l(2), l(2) + l(0), l(0) + l(1);
    difference_ << l(2) - l(1), l(0) - l(2), l(1) - l(0);  // I_2 − I_3 and cyclic
    inertia_rounded_ = inertia_.template cast<Scalar>();
  }

  Memory memory() const { return {}; }

  bool solve(const State& x, const Memory&) {
    const Vector3<Scalar> m = x.value.template tail<3>();
    c_ = ((h_ / 2) * m).cwiseQuotient(inertia_rounded_);
    c_ -= residual<Scalar>(c_, m, h_, inertia_rounded_).cwiseQuotient(inertia_rounded_);
    return newton(m, h_);
  }

  /// The same for the step t·h, from the solution found last; t = 0 starts anew.
  bool continue_to(const State& x, double t) {
    const Vector3<Scalar> found = c_;
    if (newton(x.value.template tail<3>(), static_cast<Scalar>(t) * h_)) return true;
    c_ = found;
    return false;
  }
  void restart() { c_.setZero(); }

  /// Q ← QU, M ← UᵀMU = M + (4/h)[Λ, C²(I − C²)⁻¹].
  void transport(State& x, Memory&) const {
    using std::sqrt;
    const Vector3<Wide> c = solution(x);
    const Wide c2 = c.squaredNorm(), norm = sqrt(1 + c2);
    const Wide scale = 4 / (h_ * (1 + c2));
    if constexpr (frame) {  // q ← q∘(1, c)/|(1, c)|
      const Wide w = -c2 / (norm * (1 + norm));
      const Vector3<Wide> v = c / norm;
      const Eigen::Matrix<Wide, 7, 1> wide = x.value.template cast<Wide>();
      const auto dq = So3<Wide, true>::quaternion_times(wide, w, v);
      for (int i = 0; i < 4; ++i) x.add(i, 0, dq(i));
    }
    constexpr int m = frame ? 4 : 0;
    x.add(m + 0, 0, scale * difference_(0) * (c(1) * c(2)));
    x.add(m + 1, 0, scale * difference_(1) * (c(2) * c(0)));
    x.add(m + 2, 0, scale * difference_(2) * (c(0) * c(1)));
    if constexpr (frame && arithmetic == Arithmetic::plain)
      x.value.template head<4>() *= (3 - x.value.template head<4>().squaredNorm()) / 2;
  }

 private:
  template <class T>
  static Vector3<T> residual(const Vector3<T>& c, const Vector3<T>& m, T h, const Vector3<T>& I) {
    return I.cwiseProduct(c) - (h / 2) * (m + m.cross(c) + c.dot(m) * c);
  }

  Eigen::Matrix<Scalar, 3, 3> derivative(const Vector3<Scalar>& m, Scalar h) const {
    Eigen::Matrix<Scalar, 3, 3> F = (-h / 2) * (hat(m) + c_ * m.transpose());
    F.diagonal() += inertia_rounded_;
    F.diagonal().array() -= (h / 2) * c_.dot(m);
    return F;
  }

  bool newton(const Vector3<Scalar>& m, Scalar h) {
    // The iteration that follows a correction of relative size ε is left with about ε².
    const Scalar enough = two_to<Scalar>(
        arithmetic == Arithmetic::compensated ? -bits<Scalar> / 3 : -(bits<Scalar> + 1) / 2);
    constexpr int most = 20;
    using std::isfinite;
    for (int k = 0; k < most; ++k) {
      const Vector3<Scalar> delta =
          derivative(m, h).inverse() * residual<Scalar>(c_, m, h, inertia_rounded_);
      c_ -= delta;
      const Scalar size = delta.cwiseAbs().maxCoeff();
      if (!isfinite(size)) return false;
      if (size <= enough * c_.cwiseAbs().maxCoeff())
        return c_.squaredNorm() < Scalar(1) || on_branch(derivative(m, h));
    }
    return false;
  }

  /// Routh–Hurwitz: all eigenvalues of a 3 × 3 matrix have positive real part.
  static bool on_branch(const Eigen::Matrix<Scalar, 3, 3>& F) {
    const Scalar trace = F.trace(), determinant = F.determinant();
    const Scalar minors = (trace * trace - (F * F).trace()) / 2;
    return trace > 0 && determinant > 0 && trace * minors > determinant;
  }

  /// c after a last Newton correction whose residual is formed in wider arithmetic.
  Vector3<Wide> solution(const State& x) const {
    Vector3<Wide> c = c_.template cast<Wide>();
    if constexpr (arithmetic == Arithmetic::compensated) {
      constexpr int start = frame ? 4 : 0;
      const Vector3<Wide> m(x.extended(start), x.extended(start + 1), x.extended(start + 2));
      const Vector3<Scalar> F = residual<Wide>(c, m, h_, inertia_).template cast<Scalar>();
      c -= (derivative(x.value.template tail<3>(), h_).inverse() * F).template cast<Wide>();
    }
    return c;
  }

  Scalar h_;
  Vector3<Wide> inertia_, difference_;
  Vector3<Scalar> inertia_rounded_, c_;
};

}  // namespace stiefel
