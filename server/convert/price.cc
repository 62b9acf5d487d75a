#include "server/convert/price.h"

namespace stiefel::server {

v1::PriceBound bound_of_steps(const Session& session) {
  const auto& method = session.scene().description().method;
  return method && method->tolerance ? v1::PRICE_BOUND_AT_LEAST : v1::PRICE_BOUND_EXPECTED;
}

void to_proto(double work, std::uint64_t bytes, v1::PriceBound bound, v1::Price* out) {
  out->set_work(work);
  out->set_bytes(bytes);
  out->set_bound(bound);
}

}  // namespace stiefel::server
