#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/convert/errors.h"
#include "server/convert/resolve.h"
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

/// Answers a MeasureTradeoff in parts: the reference, the points, the front.
class TradeoffAnswer {
 public:
  /// `memory`: of the request; that of the work is taken once the request is checked.
  TradeoffAnswer(const v1::MeasureTradeoffRequest& request, MemoryLease memory)
      : request_(request), memory_(std::move(memory)) {}

  /// Writes the next part over `response`. The part is not valid if a stop was requested.
  void next(const std::stop_token& stop, v1::MeasureTradeoffResponse& response);
  bool done() const { return done_; }

 private:
  void start(const std::stop_token& stop, v1::TradeoffSetup* setup);
  void finish(v1::TradeoffFront* front);

  const v1::MeasureTradeoffRequest& request_;
  MemoryLease memory_;
  std::optional<Tradeoff> tradeoff_;
  bool done_ = false;
};

}  // namespace stiefel::server
