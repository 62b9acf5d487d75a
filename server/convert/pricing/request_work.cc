#include "server/convert/pricing/request_work.h"

#include <algorithm>
#include <cmath>

#include "server/pricing/work_price.h"
#include "stiefel/connect.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// Returns the largest number of columns of a block.
std::uint64_t columns(const v1::Scene& scene) {
  std::uint64_t largest = 0;
  for (const auto& [name, matrix] : scene.initial())
    largest = std::max<std::uint64_t>(largest, matrix.cols());
  for (const auto& [name, tensor] : scene.initial_tensors())
    if (!tensor.shape().empty()) largest = std::max(largest, *tensor.shape().rbegin());
  return largest;
}

}  // namespace

double recommendation_work(const v1::Scene& scene) {
  if (scene.has_method() || scene.has_tolerance()) return 0;
  return recommendation_work(scene.system(), scene.members(), columns(scene));
}

double tradeoff_work(const v1::MeasureTradeoffRequest& request) {
  const double budget = request.has_budget() ? request.budget() : TradeoffRequest::default_budget;
  return std::isfinite(budget) ? std::max(budget, 0.0) : 0;
}

double connect_work(const v1::ConnectRequest& request) {
  return TwoPointProblem().most_work * request.pairs_size();
}

}  // namespace stiefel::server
