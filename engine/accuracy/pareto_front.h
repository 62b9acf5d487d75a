#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace stiefel {

struct CostAndError {
  double cost;
  double error;
};

/// Returns the indices of the points that no other point beats in both cost and error, the cheapest
/// first. Of equal points only the first is on the front; a point whose error is NaN never is.
inline std::vector<std::size_t> pareto_front(const std::vector<CostAndError>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](std::size_t i, std::size_t j) {
    const auto &a = points[i], &b = points[j];
    return a.cost < b.cost || (a.cost == b.cost && a.error < b.error);
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() ? !std::isnan(points[i].error) : points[i].error < points[front.back()].error)
      front.push_back(i);
  return front;
}

}  // namespace stiefel
