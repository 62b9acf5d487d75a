#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <optional>
#include <stop_token>

#include "stiefel/tradeoff.h"
#include "stiefel/v1/tradeoff.pb.h"

namespace stiefel::server {

/// Answers a MeasureTradeoff in parts: the reference, the points, the front.
class TradeoffAnswer {
 public:
  /// `memory`: the bytes that the call holds.
  TradeoffAnswer(const v1::MeasureTradeoffRequest& request, std::uint64_t memory)
      : request_(request), memory_(memory) {}

  /// Writes the next part over `response`. The part is not valid if a stop was requested.
  grpc::Status next(const std::stop_token& stop, v1::MeasureTradeoffResponse& response);
  bool done() const { return done_; }

 private:
  grpc::Status start(const std::stop_token& stop, v1::TradeoffSetup* setup);
  void finish(v1::TradeoffFront* front);

  const v1::MeasureTradeoffRequest& request_;
  const std::uint64_t memory_;
  std::optional<Tradeoff> tradeoff_;
  bool done_ = false;
};

}  // namespace stiefel::server
