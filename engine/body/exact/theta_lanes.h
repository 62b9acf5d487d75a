#pragma once

#include "engine/body/exact/theta_constants.h"
#include "engine/body/exact/theta_top.h"
#include "engine/numbers/double_word.h"

namespace stiefel::theta {

/// The constants in lanes: those of one body in every lane, or lane after lane of each constant.
template <class P, bool shared>
struct Constants {
  const double* numbers;

  [[gnu::always_inline]] P number(int place) const {
    if constexpr (shared)
      return P(numbers[place]);
    else
      return P::load(numbers + place * P::lanes);
  }
  [[gnu::always_inline]] DoubleWord<P> word(int place) const {
    return {number(place), number(place + 1)};
  }
};

template <class P>
[[gnu::always_inline]] inline P rounded(const P& x) {  // |x| < 2⁵¹: to an integer
  const P shift(0x1.8p52);
  return (x + shift) - shift;
}
template <class P>
[[gnu::always_inline]] inline DoubleWord<P> select(const typename P::Mask& m,
                                                   const DoubleWord<P>& a, const DoubleWord<P>& b) {
  return {select(m, a.high, b.high), select(m, a.low, b.low)};
}
/// Returns x·sign, sign = ±1.
template <class P>
[[gnu::always_inline]] inline DoubleWord<P> turned(const DoubleWord<P>& x, const P& sign) {
  return {x.high * sign, x.low * sign};
}
/// Returns a + b, |a| ≥ |b| or nearly so.
template <class P>
[[gnu::always_inline]] inline DoubleWord<P> plus_small(const DoubleWord<P>& a, const P& b) {
  DoubleWord<P> sum;
  fast_two_sum(a.high, b, sum.high, sum.low);
  sum.low += a.low;
  return sum;
}

/// Returns x minus the nearest integer, for |x| < 2⁹⁹.
template <class P>
[[gnu::always_inline]] inline DoubleWord<P> fraction(const DoubleWord<P>& x) {
  P high = x.high - rounded(x.high);
  high -= rounded(high);
  DoubleWord<P> r;
  two_sum(high, P(x.low - rounded(x.low)), r.high, r.low);
  r.high -= rounded(r.high);
  return r.normalized();
}

/// Returns c_0 + c_1 x + … + c_n x^n.
template <class P, std::size_t count>
[[gnu::always_inline]] inline P polynomial(const P& x, const double (&c)[count]) {
  P sum(c[count - 1]);
  for (std::size_t k = count - 1; k-- > 0;) sum = sum * x + P(c[k]);
  return sum;
}

template <class P>
struct SineCosine {
  DoubleWord<P> sine, cosine;
};
/// Returns the sine and cosine of 2πr, |r| ≤ ½.
template <class P>
[[gnu::always_inline]] inline SineCosine<P> sine_cosine(const DoubleWord<P>& r) {
  using Word = DoubleWord<P>;
  const P quarters = rounded(P(4) * r.high);
  const Word two_pi(P(0x1.921fb54442d18p+2), P(0x1.1a62633145c07p-52));
  const Word x = (two_pi * Word(r.high - P(0.25) * quarters, r.low).normalized()).normalized();
  const Word x2 = (x * x).normalized();
  // the coefficients of sin x/x and cos x, from x⁴ on
  static constexpr double sines[] = {1. / 120,           -1. / 5040,      1. / 362880,
                                     -1. / 39916800,     1. / 6227020800, -1. / 1307674368e3,
                                     1. / 355687428096e3};
  static constexpr double cosines[] = {
      1. / 24,         -1. / 720,          1. / 40320,           -1. / 3628800,
      1. / 479001600., -1. / 87178291200., 1. / 20922789888000., -1. / 6402373705728000.};
  const Word third(P(-0x1.5555555555555p-3), P(-0x1.5555555555555p-57));
  const Word s = x2 * plus_small(third, P(x2.high * polynomial(x2.high, sines)));
  const Word c = x2 * plus_small(Word(P(-0.5)), P(x2.high * polynomial(x2.high, cosines)));
  const Word sine = (x + x * s).normalized(),
             cosine = plus_small(Word(P(1)), c.high) + Word(P(0), c.low);
  const P even = P(1) - select(quarters < P(0), P(-quarters), quarters);  // 0 for odd quarters
  const auto odd = even * even < P(0.5);
  const P sign = select(odd, quarters, even);
  return {turned(select(odd, cosine, sine), sign), turned(select(odd, -sine, cosine), sign)};
}

/// Returns e^{−x}, 0 ≤ x < 700.
template <class P>
[[gnu::always_inline]] inline DoubleWord<P> decay(const DoubleWord<P>& x) {
  using Word = DoubleWord<P>;
  const P n = rounded(P(0x1.71547652b82fep+0) * x.high);
  const Word ln2(P(0x1.62e42fefa39efp-1), P(0x1.abc9e3b39803fp-56));
  const Word w = (n * ln2 - x).normalized();  // |w| ≤ ln 2/2
  static constexpr double tail[] = {
      1. / 6,      1. / 24,      1. / 120,      1. / 720,       1. / 5040,       1. / 40320,
      1. / 362880, 1. / 3628800, 1. / 39916800, 1. / 479001600, 1. / 6227020800, 1. / 87178291200};
  const Word w2 = w * w;
  const P w3 = w.high * w2.high * polynomial(w.high, tail);
  const Word e = P(1) + (w + plus_small(Word(w2.high * P(0.5), w2.low * P(0.5)), w3));
  using Bits = typename P::Mask::Part;
  const P shifted = P(0x1p52 + 1023) - n;  // its last bits are the exponent of 2⁻ⁿ
  const P power = P::of_parts([&](int p) __attribute__((always_inline)) {
    return (typename P::Part)((Bits)shifted.v[p] << 52);
  });
  return turned(e, power).normalized();
}

/// Returns 1/√x.
template <class P>
[[gnu::always_inline]] inline DoubleWord<P> inverse_root(const DoubleWord<P>& x) {
  const P y = P(1) / sqrt(x.high);
  const DoubleWord<P> rest = x * (y * DoubleWord<P>(y));
  const P e = (P(1) - rest.high) - rest.low;
  return plus_small(DoubleWord<P>(y), P(P(0.5) * y * e));
}

/// Z₁, Z₂, |Z|² and m|Z|².
template <class P>
struct Values {
  DoubleWord<P> Z[4], D, m[3];
};
template <class P>
[[gnu::always_inline]] inline Values<P> select(const typename P::Mask& mask, const Values<P>& a,
                                               const Values<P>& b) {
  Values<P> v;
  for (int i = 0; i < 4; ++i) v.Z[i] = select<P>(mask, a.Z[i], b.Z[i]);
  for (int i = 0; i < 3; ++i) v.m[i] = select<P>(mask, a.m[i], b.m[i]);
  v.D = select<P>(mask, a.D, b.D);
  return v;
}

/// The series away from the separatrix, at u = 4Kr.
template <class P, bool shared>
[[gnu::always_inline]] inline Values<P> series_in_sines(const Constants<P, shared>& c,
                                                        const DoubleWord<P>& r) {
  const auto [s, co] = sine_cosine(r);
  const DoubleWord<P> S = (s * s).normalized();
  const auto of = [&](int at) __attribute__((always_inline)) {
    P tail = c.number(at + words + degree);
    for (int k = degree - 1; k >= words; --k) tail = tail * S.high + c.number(at + words + k);
    const DoubleWord<P> first = c.word(at + 2);
    return c.word(at) + S * plus_small(first, P(tail * S.high));
  };
  Values<P> v;
  v.Z[0] = of(Z_w);
  v.Z[1] = of(Z_a) * (s * co);
  v.Z[2] = of(Z_b) * co;
  v.Z[3] = of(Z_c) * s;
  v.D = of(D);
  v.m[0] = of(m_a);
  v.m[1] = of(m_b) * s;
  v.m[2] = of(m_c) * co;
  return v;
}

/// The series next to the separatrix, at u = 4Kr. Subtracts from `alpha` the phase of the
/// transformation.
template <class P, bool shared>
[[gnu::always_inline]] inline Values<P> series_in_exponentials(const Constants<P, shared>& c,
                                                               DoubleWord<P> r,
                                                               DoubleWord<P>& alpha) {
  using Word = DoubleWord<P>;
  const P one(1), zero(0);
  // a half period back where |r| > ¼
  const P half = P(0.5) * rounded(P(2) * r.high);
  const P turn = one - P(8) * (half * half);
  r = Word(r.high - half, r.low).normalized();
  alpha = alpha - c.word(y_turns) * r;
  const P sign = select(r.high < zero, P(-1), one);
  const Word h = decay<P>(c.word(rate) * turned(r, sign));
  const Word Q_2 = c.word(Q2), w = (Q_2 / h).normalized();
  const P q = Q_2.high, q2 = q * q, q3 = q2 * q, q4 = q2 * q2, q6 = q4 * q2;
  const P H = h.high, H2 = H * H, H3 = H2 * H, H4 = H2 * H2, W2 = w.high * w.high, W3 = W2 * w.high,
          W4 = W2 * W2, W5 = W4 * w.high;
  Values<P> v;
  // E_n = (growing) + (decaying), O_n = (growing) − (decaying), over e^{|x|}
  const Word E_0 = one + h, O_0 = one - h, E_1 = q * H2 + w, O_1 = w - Word(q * H2);
  const P E_2 = q * W2 + q3 * H3, O_2 = q * W2 - q3 * H3;
  const P E_3 = q3 * W3 + q6 * H4, O_3 = q3 * W3 - q6 * H4;
  const auto sum = [&](int at, const Word& f_0, const Word& f_1, const P& f_2, const P& f_3,
                       bool alternate) __attribute__((always_inline)) {
    const P tail = alternate ? c.number(at + 4) * f_2 - c.number(at + 5) * f_3
                             : c.number(at + 4) * f_2 + c.number(at + 5) * f_3;
    const Word first = c.word(at + 2) * f_1;
    return c.word(at) * f_0 + (alternate ? -first : first) + Word(tail);
  };
  v.Z[0] = sum(cosines, E_0, E_1, E_2, E_3, false);
  v.Z[1] = turned(sum(sines, O_0, O_1, O_2, O_3, false), sign);
  v.Z[2] = turned(sum(sines, E_0, E_1, E_2, E_3, true), turn);
  v.Z[3] = turned(sum(cosines, O_0, O_1, O_2, O_3, true), P(-turn * sign));
  const Word h2 = h * h;
  const P a = q2 * H4, b = q2 * W4, d = q6 * H4 * H2;
  v.D = one + (h2 + Word((W2 + a) + (b + d)));
  v.m[1] = turned(c.word(B + 2) * (one + (Word((a - W2) + (b - d)) - h2)), P(sign * turn));
  const Word up = h + Word(q * W3 + q4 * (H4 * H)), down = w + Word(q * H3 + q4 * W5);
  v.m[0] = c.word(B) * (up + down);
  v.m[2] = turned(c.word(B + 4) * (up - down), turn);
  return v;
}

/// Computes the states; see theta_states_of_one.
template <class P, bool shared>
[[gnu::always_inline]] inline void states(const double* numbers, const ThetaTop::Times& times,
                                          double* out) {
  using Word = DoubleWord<P>;
  const Constants<P, shared> c{numbers};
  const Word t = P(times.unit) * Word(P::load(times.high.data()), P::load(times.low.data()));
  const Word r = fraction<P>((t * c.word(turns)).normalized() + c.word(start));
  Word alpha = t * c.word(precession);
  const auto near = P(0.5) < c.number(near_separatrix);
  const unsigned some = near.lanes_set();
  Values<P> v;
  if (some == 0) {
    v = series_in_sines(c, r);
  } else {
    v = series_in_exponentials(c, r, alpha);
    if (some != P::Mask::every_lane) {
      alpha = select<P>(near, alpha, Word(t * c.word(precession)));
      v = select<P>(near, v, series_in_sines(c, r));
    }
  }
  const Word root = inverse_root<P>(v.D.normalized()), inverse = root * root;
  const auto put = [&](int at, const Word& x) __attribute__((always_inline)) {
    const Word n = x.normalized();
    n.high.store(out + at * P::lanes);
    n.low.store(out + (ThetaTop::numbers + at) * P::lanes);
  };
  for (int i = 0; i < 3; ++i) put(4 + i, v.m[i] * inverse);
  const auto [s, co] = sine_cosine<P>(fraction<P>(alpha.normalized()));
  const auto product = [](const Word* x, const Word* y, Word* z) __attribute__((always_inline)) {
    z[0] = (x[0] * y[0] - x[1] * y[1]) - (x[2] * y[2] + x[3] * y[3]);
    z[1] = (x[0] * y[1] + x[1] * y[0]) + (x[2] * y[3] - x[3] * y[2]);
    z[2] = (x[0] * y[2] + x[2] * y[0]) + (x[3] * y[1] - x[1] * y[3]);
    z[3] = (x[0] * y[3] + x[3] * y[0]) + (x[1] * y[2] - x[2] * y[1]);
  };
  const Word A0 = c.word(A), A1 = c.word(A + 2), A2 = c.word(A + 4), A3 = c.word(A + 6);
  const Word turned_by[4] = {A0 * co - A1 * s, A1 * co + A0 * s, A2 * co + A3 * s,
                             A3 * co - A2 * s};
  Word q[4];
  product(turned_by, v.Z, q);
  for (int i = 0; i < 4; ++i) put(i, q[i] * root);
}

}  // namespace stiefel::theta
