#include "server/calls/service.h"

#include "server/scheduling/failpoint.h"

namespace stiefel::server {

CallLog Service::open(Context* context, const char* method, std::string_view session_id) {
  failpoint("call.open");
  CallLog log(host_.log, *context, method, session_id, host_.metrics.get());
  log.bill(host_.accounts.of(host_.identify(*context)), *context);
  return log;
}

grpc::ServerUnaryReactor* Service::finished(Context* context, CallLog& log,
                                            const grpc::Status& status, std::int64_t steps) {
  log.finish(status, steps);
  auto* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

}  // namespace stiefel::server
