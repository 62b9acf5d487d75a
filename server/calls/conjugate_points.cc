#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {

Service::Writing<v1::ConjugatePointsResponse> Service::ConjugatePoints(
    Context&, CallLog& log, const v1::ConjugatePointsRequest& request) {
  const auto memory = std::make_shared<const MemoryLease>(
      log.account().memory(),
      memory_price({held_by(request), ConjugateAnswer::workspace(request)}));
  const auto answer = std::make_shared<ConjugateAnswer>(request, memory->bytes());
  return message_a_slice<v1::ConjugatePointsResponse>(
      host_, std::move(log), JobKind::unsliced, ConjugateAnswer::work(),
      [memory, answer](const std::stop_token& stop,
                       v1::ConjugatePointsResponse& response) -> std::expected<bool, grpc::Status> {
        if (const auto status = answer->next(stop, response); !status.ok())
          return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
