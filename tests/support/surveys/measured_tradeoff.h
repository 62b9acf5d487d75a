#pragma once

#include <utility>
#include <vector>

#include "stiefel/tradeoff.h"

namespace stiefel::testing {

/// All points of a trade-off.
struct MeasuredTradeoff {
  TradeoffSetup setup;
  std::vector<TradeoffPoint> points;
  std::vector<std::size_t> front;
};

inline MeasuredTradeoff measured_tradeoff(SceneDescription scene, double horizon,
                                          double budget = 2e9) {
  MeasuredTradeoff all;
  auto tradeoff = Tradeoff::prepare({std::move(scene), horizon, budget, 1}).value();
  all.setup = tradeoff->solve_reference({}).value();
  while (auto point = tradeoff->next({})) all.points.push_back(*std::move(point));
  all.front = tradeoff->front();
  return all;
}

}  // namespace stiefel::testing
