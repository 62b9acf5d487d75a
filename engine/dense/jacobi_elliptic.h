#pragma once

#include <array>
#include <cmath>

#include "engine/dense/carlson.h"

namespace stiefel {

/// Jacobi's elliptic functions of one complementary parameter mc = 1 − k², 0 < mc ≤ 1, in any real
/// Scalar. sn, cn and dn are each relatively accurate, also next to their zeros and for mc → 0.
///
/// With the arithmetic–geometric mean a_{n+1} = (a_n + b_n)/2, b_{n+1} = √(a_n b_n) from a_0 = 1,
/// b_0 = √mc, and with X_n = a_n cs(a_n u | b_n²/a_n²) and d_n = dn(a_n u | b_n²/a_n²), Gauss's
/// transformation is
///
///     X_n = X_{n+1} d_{n+1},   d_n = (X_{n+1}² + a_{n+1} b_n) / (X_{n+1}² + a_{n+1} a_n),
///
/// and starts from X = a cot(au), d = 1 in the limit (Bulirsch 1965). The recursion is used for
/// |u| ≤ K/2. Beyond, the functions follow from those of K − u: sn = cd, cn = √mc sd, dn = √mc nd.
///
/// Boost.Math's jacobi_elliptic is not used: it takes the modulus k, whose rounding moves mc. Its
/// largest error in ulps, divided by 1 + u, is 8 for mc = ½, 140 for mc = 1e-3 and 10⁶ for mc =
/// 1e-8 in double, where the error here is at most 47 for every mc (special_functions_test.cc).
template <class Scalar>
class JacobiElliptic {
 public:
  struct Values {
    Scalar sn, cn, dn;
  };

  explicit JacobiElliptic(Scalar mc) : mc_(mc) {
    using std::atan, std::sqrt;
    a_[0] = 1;
    b_[0] = sqrt(mc);
    for (bool close = false; !close && levels_ < most; ++levels_) {
      const Scalar a = a_[levels_], b = b_[levels_];
      close = a - b <= two_to<Scalar>(-bits<Scalar> / 2);  // a and b agree after the next round
      a_[levels_ + 1] = (a + b) / 2;
      b_[levels_ + 1] = sqrt(a) * sqrt(b);
    }
    K_ = 2 * atan(Scalar(1)) / a_[levels_];
  }

  Scalar mc() const { return mc_; }
  /// The quarter period K, the complete integral of the first kind.
  Scalar K() const { return K_; }

  /// Returns the incomplete integral F(φ), |φ| ≤ π, with φ given by its sine and cosine.
  Scalar F(Scalar s, Scalar c) const {
    const Scalar up = s < 0 ? -s : s;
    const Scalar first = up * carlson::R_F<Scalar>(c * c, c * c + mc_ * s * s, 1);
    const Scalar F = c < 0 ? 2 * K_ - first : first;
    return s < 0 ? -F : F;
  }

  /// Returns sn, cn and dn of u, |u| ≤ K.
  Values operator()(Scalar u) const {
    if (u < 0) {
      Values v = (*this)(-u);
      v.sn = -v.sn;
      return v;
    }
    if (2 * u <= K_) return small(u);
    const Values v = small(K_ - u);
    return {v.cn / v.dn, b_[0] * v.sn / v.dn, b_[0] / v.dn};
  }

 private:
  Values small(Scalar u) const {
    using std::sqrt, std::tan;
    if (!(u > two_to<Scalar>(-bits<Scalar>))) return {u, 1, 1};
    const Scalar limit = a_[levels_];
    Scalar X = limit / tan(limit * u), d = 1;
    for (int n = levels_ - 1; n >= 0; --n) {
      const Scalar X2 = X * X, next = X * d;
      d = (X2 + a_[n + 1] * b_[n]) / (X2 + a_[n + 1] * a_[n]);
      X = next;
    }
    const Scalar sn = 1 / sqrt(1 + X * X);
    return {sn, X * sn, d};
  }

  // enough: √mc = 1e-2500, about the least in quadruple precision, takes fewer than 20
  static constexpr int most = 24;
  Scalar mc_, K_;
  int levels_ = 0;
  std::array<Scalar, most + 1> a_, b_;
};

}  // namespace stiefel
