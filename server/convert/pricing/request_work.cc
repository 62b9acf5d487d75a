#include "server/convert/pricing/request_work.h"

#include <algorithm>

#include "server/pricing/work_price.h"

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

}  // namespace stiefel::server
