#pragma once

#include <cstdint>

#include "server/sessions/session.h"
#include "stiefel/v1/price.pb.h"

namespace stiefel::server {

/// Returns how well `Session::most_work` is known before the steps are computed: EXPECTED, or
/// AT_MOST where the method chooses its own steps and the call ends when it has taken that much.
v1::PriceBound bound_of_steps(const Session& session);

/// Writes the price of `work` instructions, `bytes` of arrays and `memory` bytes that the call
/// holds.
void to_proto(double work, std::uint64_t bytes, v1::PriceBound bound, std::uint64_t memory,
              v1::Price* out);

}  // namespace stiefel::server
