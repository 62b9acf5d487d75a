#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Returns Dφ(x)·u of a map φ: Matrix → optional<Matrix> that is smooth near x, by the central
/// difference of eighth order,
///
///     Dφ·u = Σ_j c_j (φ(x + jδu) − φ(x − jδu))/δ,   c = 4/5, −1/5, 4/105, −1/280.
///
/// δ is ε^{1/9}/8 over the largest entry of u, ε the rounding unit: 2e-3 in double, 1e-3 in long
/// double, 3e-5 in quadruple precision. The error is ε/δ + 600 (δ/r)⁸/r where φ is analytic along
/// u/|u| up to the distance r: for r = ½, relative to φ, 1e-13, 1e-16 and 1e-29. On a manifold u
/// must be tangent; the result then does not depend on φ off the manifold. Returns nullopt where φ
/// is not defined.
template <class Scalar, class Map>
std::optional<Matrix<Scalar>> derivative(Map&& phi, const Matrix<Scalar>& x,
                                         const Matrix<Scalar>& u) {
  using std::pow;
  const Scalar size = u.cwiseAbs().maxCoeff();
  if (!(size > 0)) return Matrix<Scalar>(u);
  const Scalar delta = pow(std::numeric_limits<Scalar>::epsilon(), Scalar(1) / 9) / (8 * size);
  const std::array<Scalar, 4> c = {Scalar(4) / 5, Scalar(-1) / 5, Scalar(4) / 105,
                                   Scalar(-1) / 280};
  Matrix<Scalar> sum;
  for (int j = 1; j <= 4; ++j) {
    const std::optional<Matrix<Scalar>> ahead = phi(Matrix<Scalar>(x + Scalar(j) * delta * u));
    const std::optional<Matrix<Scalar>> behind = phi(Matrix<Scalar>(x - Scalar(j) * delta * u));
    if (!ahead || !behind) return std::nullopt;
    const Matrix<Scalar> term = (c[static_cast<std::size_t>(j - 1)] / delta) * (*ahead - *behind);
    if (j == 1)
      sum = term;
    else
      sum += term;
  }
  return sum;
}

}  // namespace stiefel
