#pragma once

#include <algorithm>
#include <random>

#include "engine/invariants/derivative.h"

namespace stiefel {

/// How far a map φ is from symplectic at the state x: the largest
///
///     |ω(Tφu, Tφv) − ω(u, v)| / (‖u‖‖v‖)
///
/// over `pairs` seeded pairs of random tangent vectors at x, ω at φ(x) on the left. `space` is one
/// of tangent_spaces.h; φ, one step of a method, takes a state to the next or to nothing where it
/// has none. A symplectic map yields the error of `derivative`: below 1e-11 in double, 1e-14 in
/// long double; one that is not, its own number. Each block of a tangent vector is of the size of
/// the state's block, so that the number does not depend on units. Nothing where φ is not defined
/// on all of the neighbourhood that the differences need: then ask in a wider scalar.
template <class Scalar, class Space, class Step>
std::optional<double> symplectic_defect(const Space& space, Step&& phi, const Matrix<Scalar>& x,
                                        int pairs = 8, unsigned seed = 1) {
  std::mt19937 engine(seed);
  const Eigen::Index n = x.rows() / 2;
  const auto random_tangent = [&] {
    Matrix<Scalar> G(x.rows(), x.cols());
    for (Eigen::Index i = 0; i < G.size(); ++i)  // the engine's own integers: the same everywhere
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

/// The map of one step of a Map for the above: from a fresh start each time.
template <class Map>
auto one_step(Map& map) {
  return [&map](const typename Map::Point& x) -> std::optional<typename Map::Point> {
    auto state = map.start(x);
    if (!map.step(state).reached()) return std::nullopt;
    return state.x.value;
  };
}

}  // namespace stiefel
