#pragma once

#include "engine/body/motion_series.h"

namespace stiefel {

/// The modified moments J with which the discrete rigid body of step h follows the continuous one
/// to an even order p (Hairer and Vilmart 2006):
///
///     1/J_i = s/I_i + d,   s and d even polynomials in h of degree p − 2.
///
/// The moments J are constant along a motion and follow from its MotionSeries at every order. One
/// step h = 2t of the discrete body with moments J is the rotation of the motion from −t to t if
///
///     m(−t) + m(t) = (4/h) e J∘(t m_1c_1, …),
///     m_1(t) − m_1(−t) = (4/h)(J_2 − J_3) t²m_2m_3c_2c_3   and cyclic,
///
/// that is, for 1/J_i = ec_i/f_i and s = e²b_1/(f_2f_3). These quotients have no cancellation for
/// any body. J is not positive where h is too long for the order.
template <class Wide>
class ModifiedSeries {
 public:
  using Vec = Vector3<Wide>;

  /// Computes the series for the motion through m.
  ModifiedSeries(const PrincipalMoments3<Wide>& body, const Vec& m, int order)
      : unit_(body.moments.sum()),
        momentum_(m.cwiseAbs().maxCoeff()),
        body_(body.moments / unit_, body.differences / unit_) {
    const bool rests = !(momentum_ > Wide(0));
    const Vec p = rests ? Vec(Vec::Zero()) : Vec((m / momentum_).cwiseAbs2());
    const auto [f, b, c, e] = MotionSeries<Wide>(body_, p, static_cast<std::size_t>(order / 2));
    int i = 0;  // the axis with the smallest 1/I_i, for which d has the least cancellation
    body_.moments.maxCoeff(&i);
    s_ = quotient(product(product(e, e), b[i]), product(f[(i + 1) % 3], f[(i + 2) % 3]));
    d_ = quotient(product(e, c[i]), f[i]);
    d_[0] = 0;
    for (std::size_t k = 1; k < d_.size(); ++k) d_[k] -= s_[k] / body_.moments(i);
  }

  /// Returns J for the step h.
  PrincipalMoments3<Wide> operator()(const Wide& h) const {
    const Vec& I = body_.moments;
    const Wide t = h * momentum_ / (2 * unit_);
    const Wide s = polynomial(s_, Wide(t * t)), d = polynomial(d_, Wide(t * t));
    const Vec J = (s * I.cwiseInverse().array() + d).inverse();
    // J₂ − J₃ = J₂J₃(1/J₃ − 1/J₂) without cancellation
    const Vec dJ = s * body_.differences.cwiseProduct(cyclic_product<Wide>(J, J))
                           .cwiseQuotient(cyclic_product<Wide>(I, I));
    return {unit_ * J, unit_ * dJ};
  }

 private:
  Wide unit_, momentum_;  ///< units of the moments and of m
  PrincipalMoments3<Wide> body_;
  PowerSeries<Wide> s_, d_;  ///< power series in t²
};

}  // namespace stiefel
