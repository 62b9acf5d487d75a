#include "server/pricing/work_price.h"

#include <algorithm>

#include "engine/simulation/catalogue/methods/motion_rates.h"
#include "engine/simulation/catalogue/methods/recommendation.h"

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
  if (scene.has_method() || scene.has_tolerance() ||
      std::ranges::none_of(recommended(scene.system()),
                           [](const auto& one) { return one.largest_h_velocity_rate > 0; }))
    return 0;
  return std::max<std::uint32_t>(scene.members(), 1) *
         velocity_rate_work(static_cast<Eigen::Index>(columns(scene)));
}

}  // namespace stiefel::server
