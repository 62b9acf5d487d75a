#pragma once

#include <cmath>
#include <variant>

#include "engine/body/exact/elliptic_top.h"
#include "engine/body/exact/hyperbolic_top.h"
#include "engine/dense/so_3.h"

namespace stiefel {

/// The free rigid body in three dimensions in closed form: (q; m), or m alone, at any time from the
/// state at time 0, for every body and every motion. Euler's and Jacobi's solution as in Celledoni,
/// Fassò, Säfström and Zanna 2008, rearranged so that it loses no digits next to symmetric bodies,
/// the separatrix and rotations about an axis:
///
///     q(t) = q(0)∘P(m(0))*∘(cos ψ/2, sin ψ/2 e)∘P(m(t)),
///
/// where e is the principal axis that m circles and P(m) the shortest rotation of m/|m| to e. The
/// angle ψ(t) has the term 2E/G t explicitly and starts from 0, so the quaternion is continuous.
/// Where m × ω = 0 the rotation is steady. The constants of the motion are computed once.
template <class Scalar, bool frame>
class EulerTop {
 public:
  using Point = typename So3<Scalar, frame>::State;
  using Vec = Vector3<Scalar>;

  EulerTop(const PrincipalMoments3<Scalar>& body, const Point& start);
  Point at(Scalar t) const;

 private:
  using Quaternion = Eigen::Matrix<Scalar, 4, 1>;
  struct Steady {
    Vec omega;
  };

  /// Rotates by π about a principal axis, so that m circles a positive axis; on the separatrix, so
  /// that m₁ and m₃ are positive.
  void flip(SortedTop<Scalar>& top) {
    bool first = top.m(0) < 0, third = top.m(2) < 0;
    if (top.Delta(1) < 0) third = first;
    if (top.Delta(1) > 0) first = third;
    const Vec S(first ? -1 : 1, first != third ? -1 : 1, third ? -1 : 1);
    sign_ = sign_.cwiseProduct(S);
    top.m = top.m.cwiseProduct(S);
  }

  template <class Motion>
  void write(const Motion& motion, Scalar t, Point& x) const {
    using std::cos, std::sin;
    const Vec sorted = motion.m(t);
    for (int a = 0; a < 3; ++a) x(x.size() - 3 + axis_[a]) = sign_(a) * sorted(a);
    if constexpr (frame) {
      const Scalar half = motion.psi(t) / 2;
      Quaternion turn;
      turn << cos(half), sin(half) * e_;
      x.template head<4>() = product(product(before_, turn), to_e(x.template tail<3>()));
    }
  }

  Point turned(const Vec& omega, Scalar t) const {
    using std::cos, std::sin, std::sqrt;
    Point x = start_;
    const Scalar rate = sqrt(omega.squaredNorm()), half = rate * t / 2;
    if constexpr (frame)
      if (rate > 0) {
        Quaternion turn;
        turn << cos(half), sin(half) / rate * omega;
        x.template head<4>() = product(start_.template head<4>(), turn);
      }
    return x;
  }

  /// Returns P(m).
  Quaternion to_e(const Vec& m) const {
    using std::sqrt;
    const Scalar G = sqrt(m.squaredNorm()), along = G + m.dot(e_);
    Quaternion P;
    P << along, m.cross(e_);
    return P / sqrt(2 * G * along);
  }
  static Quaternion product(const Quaternion& a, const Quaternion& b) {
    return So3<Scalar, true>::quaternion_times(a, b(0), b.template tail<3>());
  }

  Point start_;
  std::array<int, 3> axis_;  ///< the axes in the order of their moments
  Vec sign_ = Vec::Ones();
  Vec e_ = Vec::Zero();
  Quaternion before_ = Quaternion::UnitX();  ///< q(0)∘P(m(0))*
  std::variant<Steady, EllipticTop<Scalar>, HyperbolicTop<Scalar>> motion_;
};

template <class Scalar, bool frame>
EulerTop<Scalar, frame>::EulerTop(const PrincipalMoments3<Scalar>& body, const Point& start)
    : start_(start) {
  const Vec m = start.template tail<3>();
  const auto& [I, differences] = body;
  bool steady = true;
  for (int a = 0; a < 3; ++a)
    steady = steady && (m((a + 1) % 3) == 0 || m((a + 2) % 3) == 0 || differences(a) == 0);
  if (steady) {
    motion_ = Steady{m.cwiseQuotient(I)};
    return;
  }
  SortedTop<Scalar> top(body, m);
  axis_ = top.axis;
  // The signed permutation of the axes has det +1.
  if (!top.even) sign_(1) = -1;
  top.m = top.m.cwiseProduct(sign_);
  flip(top);
  const int circled = top.Delta(1) == 0
                          ? motion_.template emplace<HyperbolicTop<Scalar>>(top).axis()
                          : motion_.template emplace<EllipticTop<Scalar>>(top).axis();
  e_ = sign_(circled) * Vec::Unit(axis_[circled]);
  if constexpr (frame) {
    Quaternion P = to_e(m);
    P.template tail<3>() *= -1;
    before_ = product(start.template head<4>(), P);
  }
}

template <class Scalar, bool frame>
typename EulerTop<Scalar, frame>::Point EulerTop<Scalar, frame>::at(Scalar t) const {
  if (const auto* steady = std::get_if<Steady>(&motion_)) return turned(steady->omega, t);
  Point x;
  if (const auto* elliptic = std::get_if<EllipticTop<Scalar>>(&motion_))
    write(*elliptic, t, x);
  else
    write(std::get<HyperbolicTop<Scalar>>(motion_), t, x);
  return x;
}

// Compiled once, in body_references.cc.
extern template class EulerTop<long double, false>;
extern template class EulerTop<long double, true>;

}  // namespace stiefel
