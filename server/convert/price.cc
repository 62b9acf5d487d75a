#include "server/convert/price.h"

namespace stiefel::server {

v1::PriceBound bound_of_steps(const Session& session) {
  return session.attempt_limit() ? v1::PRICE_BOUND_AT_MOST : v1::PRICE_BOUND_EXPECTED;
}

void to_proto(double work, std::uint64_t bytes, v1::PriceBound bound, std::uint64_t memory,
              v1::Price* out) {
  out->set_work(work);
  out->set_bytes(bytes);
  out->set_bound(bound);
  out->set_memory_bytes(memory);
}

}  // namespace stiefel::server
