#pragma once

#include <algorithm>
#include <type_traits>
#include <vector>

#include "engine/dense/so_3.h"
#include "engine/dense/so_n.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::testing {

/// Returns (Q, M) of a random body as a state of the space.
template <class Space>
typename Space::State state_of(const RandomBody& body) {
  using Scalar = typename Space::Scalar;
  typename Space::State x;
  if constexpr (std::is_same_v<Space, SoN<Scalar>>) {
    x.resize(2 * body.M.rows(), body.M.cols());
    x << body.Q.cast<Scalar>(), body.M.cast<Scalar>();
  } else {
    x << quaternion_of(body.Q).template cast<Scalar>(), vee(body.M).template cast<Scalar>();
  }
  return x;
}

template <class State>
auto frame_of(const State& x) {
  using Scalar = typename State::Scalar;
  if constexpr (State::ColsAtCompileTime == 1)
    return Matrix<Scalar>(rotation_matrix<Scalar>(x.template head<4>()));
  else
    return Matrix<Scalar>(x.topRows(x.cols()));
}

template <class State>
auto momentum_of(const State& x) {
  using Scalar = typename State::Scalar;
  if constexpr (State::ColsAtCompileTime == 1)
    return Matrix<Scalar>(hat(x.template tail<3>()));
  else
    return Matrix<Scalar>(x.bottomRows(x.cols()));
}

/// Returns every number of a map's state.
template <class State>
std::vector<double> numbers_of(State& state) {
  std::vector<double> all;
  state.each(
      [&](auto& block) { all.insert(all.end(), block.data(), block.data() + block.size()); });
  return all;
}

template <class State>
void put_back(const std::vector<double>& all, State& state) {
  auto from = all.begin();
  state.each([&](auto& block) {
    std::copy_n(from, block.size(), block.data());
    from += block.size();
  });
}

}  // namespace stiefel::testing
