#pragma once

#include <cstdint>

#include "server/convert/resolve.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Converts a request. Does not check its numbers, which Summary checks.
OrStatus<SummaryDescription> from_proto(const v1::SummarizeRequest& request);

/// Returns a digest of everything in a request that determines its summary.
std::uint64_t digest_of(v1::SummarizeRequest request);

}  // namespace stiefel::server
