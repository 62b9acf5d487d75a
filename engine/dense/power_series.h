#pragma once

#include <cstddef>
#include <vector>

namespace stiefel {

/// The leading coefficients of a power series, a_0 first.
template <class Scalar>
using PowerSeries = std::vector<Scalar>;

/// Returns coefficient k of ab.
template <class Scalar>
Scalar product_at(const PowerSeries<Scalar>& a, const PowerSeries<Scalar>& b, std::size_t k) {
  Scalar sum = 0;
  for (std::size_t l = 0; l <= k; ++l) sum += a[l] * b[k - l];
  return sum;
}

template <class Scalar>
PowerSeries<Scalar> product(const PowerSeries<Scalar>& a, const PowerSeries<Scalar>& b) {
  PowerSeries<Scalar> ab(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) ab[k] = product_at(a, b, k);
  return ab;
}

/// Returns a/b, b₀ ≠ 0.
template <class Scalar>
PowerSeries<Scalar> quotient(const PowerSeries<Scalar>& a, const PowerSeries<Scalar>& b) {
  PowerSeries<Scalar> q(a.size(), Scalar(0));
  for (std::size_t k = 0; k < a.size(); ++k) q[k] = (a[k] - product_at(b, q, k)) / b[0];
  return q;
}

/// Returns Σ a_k xᵏ.
template <class Scalar>
Scalar polynomial(const PowerSeries<Scalar>& a, const Scalar& x) {
  Scalar sum = 0;
  for (std::size_t k = a.size(); k-- > 0;) sum = a[k] + x * sum;
  return sum;
}

}  // namespace stiefel
