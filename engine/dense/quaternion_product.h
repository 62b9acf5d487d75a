#pragma once

#include "engine/dense/so_3.h"
#include "engine/numbers/double_word.h"

namespace stiefel {

/// Returns the product (q + ε)∘(w, v) with an error of about 2^(−3/2 bits). |q|, |(w, v)| ≤ 1, ε is
/// the rounding error of q, and w and v are double words. The high halves q₁ of q and p₁ of p = (w,
/// v) are multiples of 2^−r with 2r < bits, so the sums of q₁∘p₁ are exact, and the rest, (q − q₁ +
/// ε)∘p₁ + q∘(p − p₁), is small.
template <class X, class Wide>
Eigen::Matrix<Wide, 4, 1> quaternion_product(const X& q, const X& epsilon, const Wide& w,
                                             const Vector3<Wide>& v) {
  using T = typename X::Scalar;
  if constexpr (std::is_same_v<T, Wide>) {
    return So3<T, true>::quaternion_times(q + epsilon, w, v);
  } else {
    using Space = So3<T, true>;
    using Quaternion = Eigen::Matrix<T, 4, 1>;
    constexpr int r = (bits<T> - 1) / 2;
    const T shift = T(3) * two_to<T>(bits<T> - 2 - r);
    const auto rounded = [&](const T& x) { return (x + shift) - shift; };
    Quaternion q1, q2;
    for (int i = 0; i < 4; ++i) {
      q1(i) = rounded(q(i));
      q2(i) = (q(i) - q1(i)) + epsilon(i);
    }
    const T w1 = rounded(w.high), w2 = (w.high - w1) + w.low;
    Vector3<T> v1, v2;
    for (int i = 0; i < 3; ++i) {
      v1(i) = rounded(v(i).high);
      v2(i) = (v(i).high - v1(i)) + v(i).low;
    }
    const Quaternion high = Space::quaternion_times(q1, w1, v1);
    const Quaternion low = Space::quaternion_times(q2, w1, v1) + Space::quaternion_times(q, w2, v2);
    Eigen::Matrix<Wide, 4, 1> product;
    for (int i = 0; i < 4; ++i) product(i) = Wide(high(i), low(i));
    return product;
  }
}

}  // namespace stiefel
