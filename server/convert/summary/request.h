#pragma once

#include "server/convert/resolve.h"
#include "stiefel/summary.h"
#include "stiefel/v1/summary.pb.h"

namespace stiefel::server {

/// Converts a request. Does not check its numbers, which Summary checks.
OrStatus<SummaryDescription> from_proto(const v1::SummarizeRequest& request);

}  // namespace stiefel::server
