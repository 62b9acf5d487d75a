#include "server/convert/tradeoff.h"

#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {

grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>* Service::MeasureTradeoff(
    Context* context, const v1::MeasureTradeoffRequest* request) {
  const auto answer = std::make_shared<TradeoffAnswer>(*request);
  const auto memory = std::make_shared<MemoryLease>();
  return new SlicedStream<v1::MeasureTradeoffResponse>(
      host_, host_.searches, open(context, "MeasureTradeoff"),
      [this, answer, memory, request](
          const std::stop_token& stop,
          v1::MeasureTradeoffResponse& response) -> std::expected<bool, grpc::Status> {
        if (!*memory) *memory = MemoryLease(host_.memory, search_memory(request->scene()));
        const auto status = answer->next(stop, response);
        // What was measured up to a stop says nothing.
        if (stop.stop_requested()) return std::unexpected(errors::shutting_down());
        if (!status.ok()) return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
