#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/work_price.h"

namespace stiefel::server {

Service::Writing<v1::ConnectResponse> Service::Connect(Context&, CallLog& log,
                                                       const v1::ConnectRequest& request) {
  const std::uint64_t workspace = connect_workspace(request);
  const std::size_t at_once = searches_at_once(request, workspace);
  const auto memory = std::make_shared<const MemoryLease>(
      log.account().memory(), memory_price({held_by(request), at_once * workspace}));
  const auto answer = std::make_shared<std::optional<ConnectAnswer>>();
  return message_a_slice<v1::ConnectResponse>(
      host_, std::move(log), JobKind::unsliced, connect_work(request),
      [memory, answer, at_once, &request](const std::stop_token& stop, v1::ConnectResponse& response)
          -> std::expected<bool, grpc::Status> {
        if (!*answer) {
          auto task = read(request);
          if (!task) return std::unexpected(task.error());
          answer->emplace(*std::move(task), memory->bytes(), at_once);
        }
        if (const auto status = (*answer)->next(stop, response); !status.ok())
          return std::unexpected(status);
        return (*answer)->done();
      });
}

}  // namespace stiefel::server
