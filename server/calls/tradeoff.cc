#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/work_price.h"

namespace stiefel::server {

Service::Writing<v1::MeasureTradeoffResponse> Service::MeasureTradeoff(
    Context&, CallLog& log, const v1::MeasureTradeoffRequest& request) {
  const auto memory = std::make_shared<const MemoryLease>(
      log.account().memory(),
      memory_price({held_by(request), tradeoff_workspace(request.scene())}));
  const auto answer = std::make_shared<TradeoffAnswer>(request, memory->bytes());
  return message_a_slice<v1::MeasureTradeoffResponse>(
      host_, std::move(log), JobKind::unsliced, tradeoff_work(request),
      [memory, answer](const std::stop_token& stop,
                       v1::MeasureTradeoffResponse& response) -> std::expected<bool, grpc::Status> {
        const auto status = answer->next(stop, response);
        // A measurement that a stop interrupted is not valid.
        if (stop.stop_requested()) return std::unexpected(errors::shutting_down());
        if (!status.ok()) return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
