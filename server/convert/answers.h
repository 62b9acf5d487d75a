#pragma once

#include "server/convert/errors.h"
#include "server/scheduling/memory_budget.h"
#include "stiefel/conversion.h"
#include "stiefel/tradeoff.h"
#include "stiefel/v1/conversion.pb.h"
#include "stiefel/v1/tradeoff.pb.h"

namespace stiefel::server {

/// Returns a conversion's refusal as an error.
StatusError refused(const ConversionRefusal& refusal);

/// Answers a Convert. `memory` has that of the request; that of the work and the reply is taken
/// once the request is checked.
void convert(const v1::ConvertRequest& request, MemoryLease& memory, v1::ConvertResponse* response);

/// Converts the request, setup and points of a MeasureTradeoff. Throws INVALID_ARGUMENT.
TradeoffRequest read(const v1::MeasureTradeoffRequest& request);
void to_proto(const TradeoffSetup& setup, v1::TradeoffSetup* out);
void to_proto(const TradeoffPoint& point, v1::TradeoffPoint* out);

}  // namespace stiefel::server
