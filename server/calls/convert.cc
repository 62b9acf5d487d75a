#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"
#include "server/convert/work_price.h"

namespace stiefel::server {

Service::Writing<v1::ConvertResponse> Service::Convert(Context&, CallLog& log,
                                                       const v1::ConvertRequest& request) {
  const auto memory = std::make_shared<const MemoryLease>(
      log.account().memory(),
      memory_price({held_by(request), conversion_workspace(request.scene())}));
  const auto answer = std::make_shared<ConversionAnswer>(request, memory->bytes());
  const double work = conversion_work(request);
  const JobKind kind =
      wants_choice(request.scene()) ? JobKind::unsliced : kind_of_piece(work);
  return message_a_slice<v1::ConvertResponse>(
      host_, std::move(log), kind, work,
      [memory, answer](const std::stop_token&,
                       v1::ConvertResponse& response) -> std::expected<bool, grpc::Status> {
        if (const auto status = answer->next(response); !status.ok())
          return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
