#pragma once

#include <array>

#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_3.h"

namespace stiefel {

/// The leading coefficients of a power series, at most 40, a_0 first. They are on the stack,
/// because each member of an ensemble has its own.
template <class Scalar>
using PowerSeries = Eigen::Matrix<Scalar, Eigen::Dynamic, 1, Eigen::ColMajor, 40, 1>;

/// Returns coefficient k of ab.
template <class Scalar>
Scalar product_at(const PowerSeries<Scalar>& a, const PowerSeries<Scalar>& b, Eigen::Index k) {
  Scalar sum = a[0] * b[k];
  for (Eigen::Index l = 1; l <= k; ++l) sum += a[l] * b[k - l];
  return sum;
}

template <class Scalar>
PowerSeries<Scalar> product(const PowerSeries<Scalar>& a, const PowerSeries<Scalar>& b) {
  PowerSeries<Scalar> ab(a.size());
  for (Eigen::Index k = 0; k < a.size(); ++k) ab[k] = product_at(a, b, k);
  return ab;
}

/// Returns a/b, b₀ = 1.
template <class Scalar>
PowerSeries<Scalar> quotient(const PowerSeries<Scalar>& a, const PowerSeries<Scalar>& b) {
  PowerSeries<Scalar> q = PowerSeries<Scalar>::Zero(a.size());
  for (Eigen::Index k = 0; k < a.size(); ++k) q[k] = a[k] - product_at(b, q, k);
  return q;
}

/// Returns Σ a_k xᵏ.
template <class Scalar>
Scalar polynomial(const PowerSeries<Scalar>& a, const Scalar& x) {
  Scalar sum = 0;
  for (Eigen::Index k = a.size(); k-- > 0;) sum = a[k] + x * sum;
  return sum;
}

/// A body in units of the sum of its moments, with what the series of all its motions share.
template <class Scalar>
struct BodyOfSeries {
  Scalar unit;
  Vector3<Scalar> moments, differences;
  Vector3<Scalar> over_I, products, a;  ///< 1/I_1, I_2I_3, a_1 = 1/I_3 − 1/I_2, and cyclic

  explicit BodyOfSeries(const PrincipalMoments3<Scalar>& body)
      : unit(body.moments.sum()),
        moments(body.moments / unit),
        differences(body.differences / unit),
        over_I(moments.cwiseInverse()),
        products(cyclic_product<Scalar>(moments, moments)),
        a(differences.cwiseQuotient(products)) {}
};

/// The free motion of a body in three dimensions as power series in time about the state at t = 0.
/// With τ = t², p_i = m_i(0)² and a_1 = 1/I_3 − 1/I_2, cyclic,
///
///     m_1(t) = m_1(0) f_1(τ) + m_2(0)m_3(0) t a_1b_1(τ)   and cyclic,
///     2f_1′ = a_1 (p_2 f_2a_3b_3 + p_3 f_3a_2b_2),   b_1 + 2τb_1′ = f_2f_3 + τp_1 a_2b_2a_3b_3,
///
/// and the quaternion of the rotation from −t to t is (e, t m_1(0)c_1(τ), …),
///
///     2e′ = −Σ p_ic_if_i/I_i,   c_1 + 2τc_1′ = ef_1/I_1 + τ(p_2c_2a_3b_3/I_3 − p_3c_3a_2b_2/I_2):
///
/// Factors that are odd in a momentum or in t are split off, so that no coefficient needs a
/// division by them.
template <class Scalar>
struct MotionSeries {
  using Series = PowerSeries<Scalar>;
  using Vec = Vector3<Scalar>;

  std::array<Series, 3> f, b, c;
  Series e;

  /// Computes the first `terms` coefficients from the squares p of the momenta.
  MotionSeries(const BodyOfSeries<Scalar>& body, const Vec& p, Eigen::Index terms) {
    const Vec &I = body.moments, &a = body.a;
    const Vec p_over_I = p.cwiseQuotient(I);
    // p_j a_l/I_l and p_l a_j/I_j for (i, j, l) = (1, 2, 3) and cyclic
    const Vec of_j = cyclic_product<Scalar>(p, a).cwiseQuotient(Vec(I(2), I(0), I(1))),
              of_l = cyclic_product<Scalar>(a, p).cwiseQuotient(Vec(I(1), I(2), I(0)));
    for (Series* series : {&f[0], &f[1], &f[2], &b[0], &b[1], &b[2], &c[0], &c[1], &c[2], &e})
      series->setZero(terms);
    e[0] = f[0][0] = f[1][0] = f[2][0] = 1;
    for (Eigen::Index k = 0; k < terms; ++k) {
      const Scalar odd = static_cast<Scalar>(2 * k + 1), even = static_cast<Scalar>(2 * k + 2);
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        b[i][k] = product_at(f[j], f[l], k);
        c[i][k] = product_at(e, f[i], k) / I(i);
        if (k == 0) continue;
        b[i][k] += p(i) * a(j) * a(l) * product_at(b[j], b[l], k - 1);
        c[i][k] +=
            of_j(i) * product_at(c[j], b[l], k - 1) - of_l(i) * product_at(c[l], b[j], k - 1);
        b[i][k] /= odd;
        c[i][k] /= odd;
      }
      if (k + 1 == terms) break;
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        f[i][k + 1] =
            a(i) *
            (p(j) * a(l) * product_at(f[j], b[l], k) + p(l) * a(j) * product_at(f[l], b[j], k)) /
            even;
        e[k + 1] -= p_over_I(i) * product_at(c[i], f[i], k) / even;
      }
    }
  }
};

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

  /// Computes the series for the motion through m. The body must outlive them.
  ModifiedSeries(const BodyOfSeries<Wide>& body, const Vec& m, int order)
      : momentum_(m.cwiseAbs().maxCoeff()), body_(body) {
    const Vec p = momentum_ > Wide(0) ? Vec((m / momentum_).cwiseAbs2()) : Vec(Vec::Zero());
    const auto [f, b, c, e] = MotionSeries<Wide>(body_, p, static_cast<Eigen::Index>(order / 2));
    int i = 0;  // the axis with the smallest 1/I_i, for which d has the least cancellation
    body_.moments.maxCoeff(&i);
    s_ = quotient(product(product(e, e), b[i]), product(f[(i + 1) % 3], f[(i + 2) % 3]));
    d_ = quotient(product(e, c[i]), f[i]);
    d_[0] = 0;
    for (Eigen::Index k = 1; k < d_.size(); ++k) d_[k] -= s_[k] / body_.moments(i);
  }

  /// Returns J for the step h.
  PrincipalMoments3<Wide> operator()(const Wide& h) const {
    const Wide t = h * momentum_ / (2 * body_.unit);
    const Wide s = polynomial(s_, Wide(t * t)), d = polynomial(d_, Wide(t * t));
    const Vec J = (s * body_.over_I.array() + d).inverse(), JJ = cyclic_product<Wide>(J, J);
    // J₂ − J₃ = J₂J₃(1/J₃ − 1/J₂) without cancellation
    const Vec dJ = s * body_.differences.cwiseProduct(JJ).cwiseQuotient(body_.products);
    return {body_.unit * J, body_.unit * dJ};
  }

 private:
  Wide momentum_;  ///< unit of m
  const BodyOfSeries<Wide>& body_;
  PowerSeries<Wide> s_, d_;  ///< power series in t²
};

}  // namespace stiefel
