#pragma once

#include <cstdint>

#include "server/convert/resolve.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// The description in a request. Its numbers are Summary's to check.
OrStatus<SummaryDescription> from_proto(const v1::SummarizeRequest& request);

/// A digest of all in a request that decides its summary.
std::uint64_t digest_of(v1::SummarizeRequest request);

}  // namespace stiefel::server
