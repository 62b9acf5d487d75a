#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

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

/// Returns the symplectic defect of a map φ at the state x: the largest
///
///     |ω(Tφu, Tφv) − ω(u, v)| / (‖u‖‖v‖)
///
/// over `pairs` pairs of random tangent vectors at x, drawn with `seed`; ω(Tφu, Tφv) is taken at
/// φ(x). `space` is one of tangent_spaces.h. φ is one step of a method and returns nullopt where
/// there is no step. For a symplectic map the result is the error of `derivative`: below 1e-11 in
/// double, 1e-14 in long double. Each block of a tangent vector has the size of the state's block,
/// so the result does not depend on units. Returns nullopt where φ is not defined on the whole
/// neighbourhood that the differences need, which is smaller for a wider scalar.
template <class Scalar, class Space, class Step>
std::optional<double> symplectic_defect(const Space& space, Step&& phi, const Matrix<Scalar>& x,
                                        int pairs = 8, unsigned seed = 1) {
  std::mt19937 engine(seed);
  const Eigen::Index n = x.rows() / 2;
  const auto random_tangent = [&] {
    Matrix<Scalar> G(x.rows(), x.cols());
    // The generator's integers are the same on every platform; a distribution's numbers are not.
    for (Eigen::Index i = 0; i < G.size(); ++i)
      G(i) = Scalar(static_cast<double>(engine()) * 0x1p-31 - 1);
    const Scalar first = x.topRows(n).norm(), second = x.bottomRows(n).norm();
    G.topRows(n) *= first / G.topRows(n).norm();
    G.bottomRows(n) *= (second > 0 ? second : first) / G.bottomRows(n).norm();
    Matrix<Scalar> u = space.tangent(x, G);
    u /= u.norm();
    return u;
  };

  const std::optional<Matrix<Scalar>> y = phi(x);
  if (!y) return std::nullopt;
  double worst = 0;
  for (int k = 0; k < pairs; ++k) {
    const Matrix<Scalar> u = random_tangent(), v = random_tangent();
    const auto Tu = derivative<Scalar>(phi, x, u), Tv = derivative<Scalar>(phi, x, v);
    if (!Tu || !Tv) return std::nullopt;
    const auto defect = static_cast<double>(space.form(*y, *Tu, *Tv) - space.form(x, u, v));
    worst = std::max(worst, std::abs(defect));
  }
  return worst;
}

}  // namespace stiefel
