#pragma once

#include <optional>

namespace stiefel::testing {

/// Returns φ for one step of a Map, which begins each step without history.
template <class Map>
auto one_step(Map& map) {
  return [&map](const typename Map::Point& x) -> std::optional<typename Map::Point> {
    auto state = map.start(x);
    if (!map.step(state).reached()) return std::nullopt;
    return state.x.value;
  };
}

}  // namespace stiefel::testing
