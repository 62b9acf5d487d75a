#pragma once

#include <cmath>

#include "engine/body/exact/sorted_top.h"
#include "engine/dense/carlson.h"
#include "engine/dense/jacobi_elliptic.h"

namespace stiefel {

/// The motion on either side of the separatrix, Δ₂ ≠ 0, by Jacobi's elliptic functions: around the
/// first axis, (i,j,k) = (1,2,3), σ = −1, if Δ₂ < 0; else around the third, (3,2,1), σ = +1:
///
///     m_i = B_i dn u,  m_j = −B_j sn u,  m_k = B_k cn u,   u = λt − ν,
///     ψ = (2E/G) t + σ[(θ − T)(u) − (θ − T)(−ν)],
///
/// where θ is the angle of (sn, ρ cn), and T is an integral of the third kind, computed by
/// Carlson's R_J. Both are continuous across the half periods.
template <class Scalar>
class EllipticTop {
 public:
  using Vec = Vector3<Scalar>;

  explicit EllipticTop(const SortedTop<Scalar>& top)
      : i_(top.circled()),
        functions_(top.complementary_parameter()),
        two_E_over_G_(top.two_E / top.G) {
    using std::sqrt;
    const int i = i_, k = 2 - i;
    const Vec &I = top.I, &m = top.m, &Delta = top.Delta;
    B_i_ = sqrt(I(i) * Delta(k) / top.difference(i, k));
    B_j_ = sqrt(I(j) * Delta(i) / top.difference(j, i));
    B_k_ = sqrt(I(k) * Delta(i) / top.difference(k, i));
    lambda_ = -sqrt(Delta(k) * top.difference(i, j) / (I(0) * I(1) * I(2)));
    const Scalar s = m(j) * B_k_, c = m(k) * B_j_, size = sqrt(s * s + c * c);
    nu_ = functions_.F(s / size, c / size);

    const Scalar mc = functions_.mc();
    rho_ = sqrt(I(k) * top.difference(j, i) / (I(j) * top.difference(k, i)));
    p_ = mc * rho_ * rho_;
    c_ = B_i_ * rho_ * mc / top.G;
    R_0_ = carlson::R_J<Scalar>(0, mc, 1, p_);
    start_ = theta_minus_T(-nu_);
  }

  /// Returns the axis i, counted from 0.
  int axis() const { return i_; }

  Vec m(Scalar t) const {
    const auto [u, turns] = reduced(lambda_ * t - nu_);
    const auto f = functions_(u);
    const Scalar sign = odd(turns) ? -1 : 1;
    Vec m;
    m(i_) = B_i_ * f.dn;
    m(j) = -sign * B_j_ * f.sn;
    m(2 - i_) = sign * B_k_ * f.cn;
    return m;
  }

  Scalar psi(Scalar t) const {
    const Scalar sigma = i_ == 0 ? -1 : 1;
    return two_E_over_G_ * t + sigma * (theta_minus_T(lambda_ * t - nu_) - start_);
  }

 private:
  static constexpr int j = 1;

  struct Reduced {
    Scalar u;      ///< |u| ≤ K
    Scalar turns;  ///< number of half periods 2K subtracted
  };
  Reduced reduced(Scalar u) const {
    using std::floor;
    const Scalar period = 2 * functions_.K(), turns = floor(u / period + Scalar(1) / 2);
    return {u - turns * period, turns};
  }
  static bool odd(Scalar n) {
    using std::floor;
    return 2 * floor(n / 2) != n;
  }

  Scalar theta_minus_T(Scalar whole) const {
    using std::atan, std::atan2;
    const auto [u, turns] = reduced(whole);
    const auto f = functions_(u);
    const Scalar sn2 = f.sn * f.sn, cn2 = f.cn * f.cn, mc = functions_.mc();
    const Scalar third = (1 - p_) / 3;
    const Scalar R =
        cn2 * f.cn * carlson::R_J<Scalar>(mc * sn2, mc, f.dn * f.dn, mc * sn2 + p_ * cn2);
    const Scalar sign = u < 0 ? -1 : 1;
    const Scalar T = c_ * (u + sign * third * (R_0_ - R));
    const Scalar T_turn = 2 * c_ * (functions_.K() + third * R_0_), pi = 4 * atan(Scalar(1));
    return (atan2(f.sn, rho_ * f.cn) - T) + turns * (pi - T_turn);
  }

  int i_;
  JacobiElliptic<Scalar> functions_;
  Scalar two_E_over_G_, B_i_, B_j_, B_k_, lambda_, nu_;
  Scalar rho_, p_, c_, R_0_, start_;
};

}  // namespace stiefel
