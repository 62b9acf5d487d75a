#pragma once

#include <array>
#include <cmath>

#include "engine/body/exact/sorted_top.h"
#include "engine/dense/carlson.h"
#include "engine/dense/jacobi_elliptic.h"
#include "engine/dense/so_3.h"

namespace stiefel {

/// The free rigid body in three dimensions in closed form: (q; m) at any time from the state at
/// time 0, for every body and every motion. Euler's and Jacobi's solution as in Celledoni, Fassò,
/// Säfström and Zanna 2008, rearranged so that it loses no digits next to symmetric bodies, the
/// separatrix and rotations about an axis:
///
///     q(t) = q(0)∘P(m(0))*∘(cos ψ/2, sin ψ/2 e)∘P(m(t)),   ψ = (2E/G) t + σ[α(u) − α(u₀)],
///
/// where e is the principal axis that m circles, P(m) the shortest rotation of m/|m| to e, and
/// u = λt + u₀. ψ is continuous, so the quaternion is, too. With (i, j, k) of SortedTop,
///
///     Δ₂ ≠ 0:  m_i = B_i dn u,  m_j = −B_j sn u,  m_k = B_k cn u,  σ = −1 for i = 1, +1 for i = 3,
///              α = θ − T, θ the angle of (sn, ρ cn), T an integral of the third kind by R_J;
///     Δ₂ = 0:  m = (B₁ sech u, G tanh u, B₃ sech u),  σ = 2,  α = atan2(B₃ tanh(u/2), G + B₁);
///     m × ω = 0:  a steady rotation by ω.
///
/// The constants of the motion are computed once.
template <class Scalar>
class EulerTop {
 public:
  using Point = typename So3<Scalar, true>::State;
  using Vec = Vector3<Scalar>;

  EulerTop(const PrincipalMoments3<Scalar>& body, const Point& start) : start_(start) {
    const Vec m = start.template tail<3>();
    const auto& [I, differences] = body;
    bool steady = true;
    for (int a = 0; a < 3; ++a)
      steady = steady && (m((a + 1) % 3) == 0 || m((a + 2) % 3) == 0 || differences(a) == 0);
    if (steady) {
      omega_ = m.cwiseQuotient(I);
      return;
    }
    SortedTop<Scalar> top(body, m);
    axis_ = top.axis;
    // The signed permutation of the axes has det +1.
    if (!top.even) sign_(1) = -1;
    top.m = top.m.cwiseProduct(sign_);
    flip(top);
    set_constants(top);
    e_ = sign_(i_) * Vec::Unit(axis_[i_]);
    Quaternion P = to_e(m);
    P.template tail<3>() *= -1;
    before_ = product(start.template head<4>(), P);
  }
  Point at(Scalar t) const {
    using std::cos, std::sin;
    if (formula_ == Formula::steady) return turned(t);
    Point x;
    const Value now = value(lambda_ * t + u_0_);
    for (int a = 0; a < 3; ++a) x(4 + axis_[a]) = sign_(a) * now.m(a);
    const Scalar half = (two_E_over_G_ * t + sigma_ * (now.alpha - alpha_0_)) / 2;
    Quaternion turn;
    turn << cos(half), sin(half) * e_;
    x.template head<4>() = product(product(before_, turn), to_e(x.template tail<3>()));
    return x;
  }

 private:
  using Quaternion = Eigen::Matrix<Scalar, 4, 1>;
  enum class Formula { steady, hyperbolic, elliptic };

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

  void set_constants(const SortedTop<Scalar>& top) {
    using std::asinh, std::sqrt;
    constexpr int j = 1;
    const Vec &I = top.I, &m = top.m, &Delta = top.Delta;
    const bool separatrix = Delta(j) == 0;
    const int i = i_ = separatrix ? 0 : top.circled(), k = 2 - i;
    two_E_over_G_ = top.two_E / top.G;
    B_(i) = sqrt(I(i) * Delta(k) / top.difference(i, k));
    B_(k) = sqrt(I(k) * Delta(i) / top.difference(k, i));
    if (separatrix) {
      formula_ = Formula::hyperbolic;
      sigma_ = 2;
      B_(j) = top.G;
      lambda_ = sqrt(-Delta(0) * Delta(2) / (I(0) * I(2))) / top.G;
      u_0_ = asinh(m(1) / sqrt(m(0) * m(0) + m(2) * m(2)));
    } else {
      formula_ = Formula::elliptic;
      sigma_ = i == 0 ? -1 : 1;
      B_(j) = sqrt(I(j) * Delta(i) / top.difference(j, i));
      lambda_ = -sqrt(Delta(k) * top.difference(i, j) / (I(0) * I(1) * I(2)));
      functions_ = JacobiElliptic<Scalar>(top.complementary_parameter());
      const Scalar s = m(j) * B_(k), c = m(k) * B_(j), size = sqrt(s * s + c * c);
      u_0_ = -functions_.F(s / size, c / size);
      const Scalar mc = functions_.mc();
      rho_ = sqrt(I(k) * top.difference(j, i) / (I(j) * top.difference(k, i)));
      p_ = mc * rho_ * rho_;
      c_ = B_(i) * rho_ * mc / top.G;
      R_0_ = carlson::R_J<Scalar>(0, mc, 1, p_);
    }
    alpha_0_ = value(u_0_).alpha;
  }

  struct Value {
    Vec m;             ///< along the sorted axes
    Scalar alpha = 0;  ///< continuous across the half periods
  };
  Value value(const Scalar& whole) const {
    using std::atan, std::atan2, std::cosh, std::floor, std::tanh;
    if (formula_ == Formula::hyperbolic)
      return {{B_(0) / cosh(whole), B_(1) * tanh(whole), B_(2) / cosh(whole)},
              atan2(B_(2) * tanh(whole / 2), B_(1) + B_(0))};
    // half periods 2K and |u| ≤ K
    const Scalar period = 2 * functions_.K(), turns = floor(whole / period + Scalar(1) / 2),
                 u = whole - turns * period;
    const auto [sn, cn, dn] = functions_(u);
    const Scalar sign = 2 * floor(turns / 2) != turns ? -1 : 1;
    Value at;
    at.m(i_) = B_(i_) * dn;
    at.m(1) = -sign * B_(1) * sn;
    at.m(2 - i_) = sign * B_(2 - i_) * cn;
    const Scalar sn2 = sn * sn, cn2 = cn * cn, mc = functions_.mc(), third = (1 - p_) / 3;
    const Scalar R = cn2 * cn * carlson::R_J<Scalar>(mc * sn2, mc, dn * dn, mc * sn2 + p_ * cn2);
    const Scalar T = c_ * (u + Scalar(u < 0 ? -1 : 1) * third * (R_0_ - R));
    const Scalar T_turn = 2 * c_ * (functions_.K() + third * R_0_), pi = 4 * atan(Scalar(1));
    at.alpha = (atan2(sn, rho_ * cn) - T) + turns * (pi - T_turn);
    return at;
  }

  Point turned(Scalar t) const {
    using std::cos, std::sin, std::sqrt;
    Point x = start_;
    const Scalar rate = sqrt(omega_.squaredNorm()), half = rate * t / 2;
    if (rate > 0) {
      Quaternion turn;
      turn << cos(half), sin(half) / rate * omega_;
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
  Formula formula_ = Formula::steady;
  std::array<int, 3> axis_;  ///< the axes in the order of their moments
  int i_ = 0;                ///< the axis that m circles, of the sorted ones; k = 2 − i, j = 1
  Vec sign_ = Vec::Ones();
  Vec e_ = Vec::Zero();
  Quaternion before_ = Quaternion::UnitX();  ///< q(0)∘P(m(0))*
  Vec omega_;                                ///< of a steady rotation
  Vec B_;                                    ///< along the sorted axes; B₂ = G on the separatrix
  Scalar two_E_over_G_, sigma_, lambda_, u_0_, alpha_0_;
  JacobiElliptic<Scalar> functions_{Scalar(1)};
  Scalar rho_, p_, c_, R_0_;  ///< of α
};

// Compiled once, in body_references.cc.
extern template class EulerTop<long double>;

}  // namespace stiefel
