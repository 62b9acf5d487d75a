#include "engine/body/exact/theta_top.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/body/exact/sorted_top.h"
#include "engine/body/exact/theta_constants.h"
#include "engine/dense/carlson.h"
#include "engine/dense/so_3.h"
#include "engine/numbers/number_128.h"
#include "engine/numbers/pack.h"

namespace stiefel {
namespace {

using namespace theta;
using Wide = long double;
using Number = Number128;

constexpr double far = 0x1p300;  ///< products of two words within this range are exact
constexpr double most_turns = 0x1p90;
constexpr double most_K = 130;  ///< over K′, where e^{−πK/2K′} is still within this range
constexpr double most_nome = 0.15;  ///< above it, the series next to the separatrix converge faster

constexpr Wide wide_pi = 3.14159265358979323846264338327950288L;
constexpr Number pi = pi_128;

bool within(Wide x) { return std::abs(x) > 1 / far && std::abs(x) < far; }

/// Returns the complete integral of the first kind for the parameter 1 − k².
Number complete_integral(Number k) {
  Number a = 1, b = k;
  while (a - b > two_to<Number>(-56) * a) {
    const Number next = ldexp(a + b, -1);
    b = sqrt(a * b);
    a = next;
  }
  return pi / (a + b);
}

/// Where `integrals` keeps its bits: the largest error found is 5 units in the last place.
constexpr double least_modulus = 0x1p-10;

/// The integrals of dv/√((v² + 1)(v² + k²)) from 0 and from v, to ∞, k ≤ 1.
struct Integrals {
  Number complete, rest;
};

/// Computes both by Gauss' transformation, which doubles the angle atan(1/v) up to its limit
/// (Bulirsch 1965). m and g are the arithmetic and geometric means times the power of 2.
Integrals integrals(Number k, Number v) {
  Number m = 1, g = k;
  for (int power = 1, turns = 0;; power *= 2) {  // half turns of the angle
    const Number product = m * g, sum = m + g;
    const bool last = !(m - g > two_to<Number>(-56) * m);
    v -= product / v;
    if (v == 0) v = two_to<Number>(-113) * sqrt(product);
    turns = (last ? turns : 2 * turns) + (v < 0);
    if (last) return {power * pi / sum, (atan(Number(sum / v)) + turns * pi) / sum};
    m = sum;
    g = 2 * sqrt(product);
  }
}

/// Returns Δ₂ as SortedTop<Quad> has it: next to the separatrix, where it cancels, its rounding
/// decides the state after 10⁹ turns, and EulerTop in quadruple precision is the reference there.
Number middle_delta(const SortedTop<Number>& top) {
  const auto quad = [](const Number& x) { return x.rounded(113); };
  const auto times = [&](const Number& a, const Number& b) { return quad(quad(a) * quad(b)); };
  const auto &I = top.I, &m = top.m;
  const Number third = times(times(m(2), m(2)), times(top.difference(2, 1), I(0))),
               first = times(times(m(0), m(0)), times(top.difference(1, 0), I(2)));
  return quad(quad(third - first) / times(I(0), I(2)));
}

/// Returns the incomplete integral of the first kind of the angle with sine s and cosine c.
template <class Scalar>
Scalar incomplete_integral(Scalar s, Scalar c, const Scalar& mc, const Scalar& K) {
  const Scalar size = s < 0 ? Scalar(-s) : s;
  const Scalar first = size * carlson::R_F<Scalar>(c * c, c * c + mc * s * s, 1);
  const Scalar whole = c < 0 ? Scalar(2 * K - first) : first;
  return s < 0 ? Scalar(-whole) : whole;
}

template <class Scalar>
Scalar power(Scalar x, int n) {
  Scalar product = 1;
  for (; n > 0; n /= 2, x *= x)
    if (n % 2 == 1) product *= x;
  return product;
}

/// Writes constants into their places. Those too small for exact products become 0.
class Places {
 public:
  explicit Places(std::array<double, ThetaTop::constants>& to) : to_(to) { to_.fill(0); }

  template <class Scalar>
  void number(int place, Scalar x) {
    const auto rounded = static_cast<double>(x);
    to_[place] = std::abs(rounded) < 1 / far ? 0 : rounded;
  }
  template <class Scalar>
  void word(int place, Scalar x) {
    number(place, x);
    number(place + 1, to_[place] == 0 ? Scalar(0) : Scalar(x - Scalar(to_[place])));
  }
  /// Writes the sum of c_n f_n as a polynomial in S = sin²z, where f_{n+1} = (2 − 4S) f_n − f_{n−1}
  /// from the constants f_0 and f_{−1}, the latter plus `slope` S.
  template <std::size_t count>
  void series(int place, Wide factor, const std::array<Wide, count>& c, int first, int before,
              int slope = 0) {
    std::array<Wide, degree + 1> sum{};
    std::array<int, degree + 1> f{first}, last{before, slope};
    for (int n = 0; n < static_cast<int>(count); ++n) {
      for (int i = 0; i <= n; ++i) sum[i] += factor * c[n] * static_cast<Wide>(f[i]);
      for (int i = degree; i >= 0; --i) last[i] = 2 * f[i] - last[i] - (i > 0 ? 4 * f[i - 1] : 0);
      std::swap(f, last);
    }
    for (int i = 0; i < words; ++i) word(place + 2 * i, sum[i]);
    for (int i = words; i <= degree; ++i) number(place + words + i, sum[i]);
  }

 private:
  std::array<double, ThetaTop::constants>& to_;
};

/// What the series are made of; B along a, b and c.
struct Series {
  Number K, inverse_K, K_dual, y, nome, u_0;
  std::array<Wide, 3> B;
};

/// Z₁ at time 0 up to a positive factor, and d arg Z₁/du at u = 0.
struct Phase {
  Wide re = 0, im = 0;
  Number slope;
};

/// The coefficients of Z₁ and Z₂ away from the separatrix, n = 0, 1, …: of cos 2nz, sin 2nz, sin
/// (2n+1)z and cos (2n+1)z; W = exp(−πy/2K), V = e^{−2β} = nome/W².
struct InSines {
  Wide cosh_even, sinh_even, cosh_odd, sinh_odd;

  InSines(Wide nome, Wide W, Wide V, int n) {
    const int sign = n % 2 == 0 ? 1 : -1;
    const Wide even = sign * power(nome, 2 * n * n - n) * power(W, 2 * n);
    const Wide odd = sign * power(nome, 2 * n * n + n) * power(W, 2 * n + 1);
    const Wide V_even = power(V, 2 * n), V_odd = V_even * V;
    cosh_even = n == 0 ? 1 : even * (1 + V_even);
    sinh_even = even * (V_even - 1);
    cosh_odd = odd * (1 + V_odd);
    sinh_odd = odd * (1 - V_odd);
  }
};

Phase put_sines(Places& to, const Series& of) {
  const Number W = exp(-ldexp(pi * of.y * of.inverse_K, -1)), W2 = W * W, V = of.nome / W2,
               V2 = V * V;
  const Number nome4 = power(of.nome, 4), least = ldexp(of.nome * W2, -124);
  Number value = 1, slope = 0, size = 1, ratio = -of.nome * W2, V_even = 1;
  for (int n = 1; n < 6; ++n, ratio *= nome4) {  // as in InSines
    size *= ratio;
    if (abs(size) < least) break;
    V_even *= V2;
    value += size * (1 + V_even);
    slope += 2 * n * size * (V_even - 1);
  }
  Phase phase{.slope = ldexp(slope / value * pi * of.inverse_K, -1)};
  const auto q = static_cast<Wide>(of.nome);
  const Wide z = wide_pi * static_cast<Wide>(ldexp(of.u_0 * of.inverse_K, -1));
  const Wide cosine_2z = std::cos(2 * z), sine_2z = std::sin(2 * z);
  Wide cosine = 1, sine = 0;  // of 2nz
  std::array<Wide, 4> cosh_even, sinh_even, cosh_odd, sinh_odd;
  Wide Z_1 = 0, Z_2 = 0;  // at u = 0
  for (int n = 0; n < 4; ++n) {
    const InSines c(q, static_cast<Wide>(W), static_cast<Wide>(V), n);
    Z_1 += cosh_even[n] = c.cosh_even;
    Z_2 += sinh_odd[n] = c.sinh_odd;
    sinh_even[n] = c.sinh_even;
    cosh_odd[n] = c.cosh_odd;
    phase.re += c.cosh_even * cosine;
    phase.im += c.sinh_even * sine;
    const Wide before = cosine;
    cosine = cosine * cosine_2z - sine * sine_2z;
    sine = sine * cosine_2z + before * sine_2z;
  }
  // θ₁ and θ₂ over 2 nome^¼, θ₃ and θ₄, with the nome exp(−πK′/K)
  std::array<Wide, 5> theta_1, theta_2, theta_3, theta_4;
  Wide D_0 = 0, D_K = 0, most = 0;
  for (int n = 0; n < 5; ++n) {
    const int sign = n % 2 == 0 ? 1 : -1;
    D_K += theta_3[n] = (n == 0 ? 1 : 2) * power(q, n * n);
    D_0 += theta_4[n] = sign * theta_3[n];
    most += theta_2[n] = power(q, n * n + n);
    theta_1[n] = sign * theta_2[n];
  }
  const Wide scale = std::sqrt(D_0 / (Z_1 * Z_1 + Z_2 * Z_2));
  to.series(Z_w, scale, cosh_even, 1, 1, -2);
  to.series(Z_a, scale, sinh_even, 0, -2);
  to.series(Z_b, scale, sinh_odd, 1, 1);
  to.series(Z_c, -scale, cosh_odd, 1, -1);
  to.series(D, 1, theta_4, 1, 1, -2);
  to.series(m_a, of.B[0] * D_0 / D_K, theta_3, 1, 1, -2);
  to.series(m_b, of.B[1] * D_K / most, theta_1, 1, -1);
  to.series(m_c, of.B[2] * D_0 / most, theta_2, 1, 1);
  return phase;
}

Phase put_exponentials(Places& to, const Series& of) {
  const Number Q = exp(-pi * of.K / (2 * of.K_dual)), y = pi / 4 * (1 - of.y / of.K_dual);
  auto [C, S] = cosine_sine(y);
  Number C_before = C, S_before = -S, value = 0, slope = 0;
  const Number twice = 2 * (C * C - S * S);
  // as the kernel does: a half period back where |u₀| > K
  const Number u = abs(of.u_0) <= of.K ? of.u_0 : of.u_0 - copysign(2 * of.K, of.u_0);
  const auto q = static_cast<Wide>(Q * Q), sign = std::copysign(Wide(1), static_cast<Wide>(u));
  const Wide h = std::exp(-wide_pi * static_cast<Wide>(abs(u) / (2 * of.K_dual))), w = q / h;
  Wide re = 0, im = 0, Z_1 = 0, Z_2 = 0;
  std::array<Wide, 4> cos_y, sin_y;
  for (int n = 0; n < 6; ++n) {
    const Number size = power(Q, n * n + n);
    value += size * C;
    slope += (2 * n + 1) * size * S;
    if (n < 4) {
      const auto c = cos_y[n] = static_cast<Wide>(C), s = sin_y[n] = static_cast<Wide>(S);
      const Wide growing = power(q, n * (n - 1) / 2) * power(w, n),
                 decaying = power(q, n * (n + 1) / 2) * power(h, n + 1);
      re += c * (growing + decaying);
      im += sign * s * (growing - decaying);
      Z_1 += 2 * static_cast<Wide>(size) * c;
      Z_2 += 2 * static_cast<Wide>(size) * (n % 2 == 0 ? s : -s);
    }
    C_before = std::exchange(C, twice * C - C_before);
    S_before = std::exchange(S, twice * S - S_before);
  }
  const Wide D_0 = 2 * (1 + power(q, 2) + power(q, 6));
  const Wide scale = std::sqrt(D_0 / (Z_1 * Z_1 + Z_2 * Z_2));
  to.word(rate, 2 * pi * of.K / of.K_dual);
  to.word(y_turns, 2 * y / pi);
  to.word(Q2, Q * Q);
  for (const auto& [place, f] : {std::pair(cosines, &cos_y), std::pair(sines, &sin_y)}) {
    to.word(place, scale * (*f)[0]);
    to.word(place + 2, scale * (*f)[1]);
    to.number(place + 4, scale * (*f)[2]);
    to.number(place + 5, scale * (*f)[3]);
  }
  // m at u = 0, and m_b at u = K, where e^{−2|x|} = Q
  const Wide up = 1 + 2 * power(q, 4), down = 2 * q + power(q, 9);
  const Wide D_K = 1 + 2 * q + 2 * power(q, 4) + power(q, 9);
  const Wide most = 1 - 2 * q + 2 * power(q, 4) - power(q, 9);
  to.word(B, of.B[0] * D_0 / (up + down));
  to.word(B + 2, of.B[1] * D_K / most);
  to.word(B + 4, of.B[2] * D_0 / (up - down));
  const Wide turn = static_cast<Wide>(y * u / of.K), c = std::cos(turn), s = std::sin(turn);
  return {re * c + im * s, im * c - re * s, slope / value * pi / (4 * of.K_dual) - y / of.K};
}

template <Isa isa, bool side_by_side>
void compute(const double* constants, const ThetaTop::Times& times, double* out) {
  if constexpr (side_by_side)
    theta_states_side_by_side<isa>(constants, times, out);
  else
    theta_states_of_one<isa>(constants, times, out);
}
template <bool side_by_side>
void on_this_machine(const double* constants, const ThetaTop::Times& times, double* out) {
#ifdef STIEFEL_X86_64
  if (widest_isa() == Isa::avx512) return compute<Isa::avx512, side_by_side>(constants, times, out);
  if (widest_isa() == Isa::avx2) return compute<Isa::avx2, side_by_side>(constants, times, out);
#endif
  compute<Isa::baseline, side_by_side>(constants, times, out);
}

}  // namespace

std::optional<ThetaTop> ThetaTop::of(const PrincipalMoments3<Number>& body,
                                     const Eigen::Matrix<long double, 7, 1>& start) {
  using Vec = Vector3<Number>;
  const Vec m = start.tail<3>().cast<Number>();
  SortedTop<Number> top(body, m);
  top.Delta(1) = middle_delta(top);
  if (top.Delta(1) == 0) return std::nullopt;
  const auto& axes = top.axis;
  const int i = top.circled(), k = 2 - i;
  constexpr int j = 1;

  ThetaTop made;
  made.axis_ = {axes[i], axes[j], axes[k]};
  const bool back = m(axes[i]) < 0, even = (axes[i] + 1) % 3 == axes[j];
  made.sign_ = {back ? -1. : 1., back == even ? -1. : 1., 1.};
  const Number G2 = m.squaredNorm(), G = sqrt(G2);
  const Number B2_a = top.I(i) * top.Delta(k) / top.difference(i, k),
               B2_b = top.I(j) * top.Delta(i) / top.difference(j, i),
               B2_c = top.I(k) * top.Delta(i) / top.difference(k, i), B_a = sqrt(B2_a);
  const Number mc = top.complementary_parameter();
  const Number k2 = top.Delta(i) * top.difference(j, k) / (top.Delta(k) * top.difference(j, i));
  for (const Number* B2 : {&B2_a, &B2_b, &B2_c})
    if (!within(std::sqrt(static_cast<Wide>(*B2) / static_cast<Wide>(G2)))) return std::nullopt;
  if (!within(static_cast<Wide>(G)) || !(mc > 0)) return std::nullopt;

  Series of;
  of.B = {static_cast<Wide>(B_a), static_cast<Wide>(sqrt(B2_b)), static_cast<Wide>(sqrt(B2_c))};
  of.K = complete_integral(sqrt(mc));
  of.inverse_K = 1 / of.K;
  const Number modulus = k2 > 0 ? sqrt(k2) : Number(0);
  if (modulus > least_modulus) {
    const auto [complete, rest] = integrals(modulus, sqrt(B2_c / B2_a));
    of.K_dual = complete;
    of.y = rest;
  } else {
    of.K_dual = modulus > 0 ? complete_integral(modulus) : Number(0);
    of.y = B_a * carlson::R_F<Number>(B2_c, B2_b, G2);
  }
  of.nome = modulus > 0 ? Number(exp(-pi * of.K_dual * of.inverse_K)) : Number(0);
  const bool near = of.nome > most_nome;
  const std::array<Wide, 3> m_0{static_cast<Wide>(made.sign_[0] * m(axes[i])),
                                static_cast<Wide>(made.sign_[1] * m(axes[j])),
                                static_cast<Wide>(m(axes[k]))};
  const Wide s = m_0[1] * of.B[2], c = m_0[2] * of.B[1], norm = std::hypot(s, c);
  of.u_0 = near ? incomplete_integral<Number>(s / norm, c / norm, mc, of.K)
                : Number(incomplete_integral<Wide>(s / norm, c / norm, static_cast<Wide>(mc),
                                                   static_cast<Wide>(of.K)));
  Places to(made.constants_);
  const Phase phase = near ? put_exponentials(to, of) : put_sines(to, of);

  const Number size = sqrt(top.Delta(k) * top.difference(i, j) / (top.I(0) * top.I(1) * top.I(2)));
  const Number u_rate = i == 0 ? size : Number(-size);
  const Number psi_rate = (top.two_E + G * B_a / top.I(i)) / (G + B_a);
  const Number turns = ldexp(u_rate * of.inverse_K, -2);
  const Number precession =
      ldexp((ldexp(psi_rate, -1) - phase.slope * u_rate) * inverse_pi_128, -1);
  if (!within(static_cast<Wide>(turns)) || !within(static_cast<Wide>(precession)) ||
      (near && !(of.K < most_K * of.K_dual)))
    return std::nullopt;
  made.longest_ =
      std::min(far, most_turns / static_cast<double>(std::max(abs(turns), abs(precession))));
  to.number(near_separatrix, Wide(near ? 1 : 0));
  to.word(theta::turns, turns);
  to.word(theta::start, ldexp(of.u_0 * of.inverse_K, -2));
  to.word(theta::precession, precession);

  // A = q(0) ∘ P(m(0))* ∘ e^{−i arg Z₁(0)}, P(m) the shortest rotation of m/|m| to e_a
  using Quaternion = Eigen::Matrix<Wide, 4, 1>;
  const auto product = [](const Quaternion& a, const Quaternion& b) {
    return So3<Wide, true>::quaternion_times(a, b(0), b.tail<3>());
  };
  const Wide reach = static_cast<Wide>(G) + m_0[0];
  const Wide scale = std::hypot(phase.re, phase.im) * std::sqrt(2 * static_cast<Wide>(G) * reach);
  const auto q = [&](int n) { return start(n); };
  const Quaternion q_0(q(0), made.sign_[0] * q(1 + axes[i]), made.sign_[1] * q(1 + axes[j]),
                       q(1 + axes[k]));
  const Quaternion P(reach, 0, -m_0[2], m_0[1]), turn(phase.re, -phase.im, 0, 0);
  const Quaternion A = product(product(q_0, P), turn) / scale;
  for (int n = 0; n < 4; ++n) to.word(theta::A + 2 * n, A(n));
  return made;
}

int ThetaTop::lanes() { return vector_width<double>(widest_isa()); }

void ThetaTop::at(const Times& times, Lanes& states) const {
  on_this_machine<false>(constants_.data(), times, states.words.data());
  states.width = lanes();
}

void ThetaTops::put(int lane, const ThetaTop& body) {
  const int width = ThetaTop::lanes();
  for (int i = 0; i < ThetaTop::constants; ++i) constants_[i * width + lane] = body.constants_[i];
}

void ThetaTops::at(const ThetaTop::Times& times, ThetaTop::Lanes& states) const {
  on_this_machine<true>(constants_.data(), times, states.words.data());
  states.width = ThetaTop::lanes();
}

}  // namespace stiefel
