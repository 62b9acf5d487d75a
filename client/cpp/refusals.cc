#include "stiefel/client/refusals.h"

#include <algorithm>
#include <random>

#include "stiefel/client/error.h"

namespace stiefel::client {

std::optional<std::chrono::milliseconds> Refusals::next(const grpc::Status& status) {
  using std::chrono::milliseconds;
  if (status.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED || count_ == most)
    return std::nullopt;
  const auto delay = Error(status).retry_delay();
  if (!delay || *delay > longest) return std::nullopt;
  constexpr int least = 10, most_random = 1000;
  const int bound = std::min(least << std::min(count_++, 7), most_random);
  thread_local std::mt19937 random(std::random_device{}());
  return std::chrono::ceil<milliseconds>(*delay) +
         milliseconds(std::uniform_int_distribution(0, bound)(random));
}

}  // namespace stiefel::client
