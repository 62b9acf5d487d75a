#include "server/convert/answers.h"

#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/request_price.h"

namespace stiefel::server {

grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>* Service::MeasureTradeoff(
    Context* context, const v1::MeasureTradeoffRequest* request) {
  CallLog log = open(context, "MeasureTradeoff");
  try {
    const auto memory =
        std::make_shared<const MemoryLease>(log.account().memory(), tradeoff_memory(*request));
    const auto answer = std::make_shared<TradeoffAnswer>(*request, memory->bytes());
    return message_a_slice<v1::MeasureTradeoffResponse>(
        host_, host_.searches, std::move(log), tradeoff_work(*request),
        [memory, answer](const std::stop_token& stop, v1::MeasureTradeoffResponse& response)
            -> std::expected<bool, grpc::Status> {
          const auto status = answer->next(stop, response);
          // A measurement that a stop interrupted is not valid.
          if (stop.stop_requested()) return std::unexpected(errors::shutting_down());
          if (!status.ok()) return std::unexpected(status);
          return answer->done();
        });
  } catch (...) {
    return new RefusedStream<v1::MeasureTradeoffResponse>(log, errors::from_current_exception());
  }
}

}  // namespace stiefel::server
