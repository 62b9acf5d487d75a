#include "server/calls/service.h"

#include <google/protobuf/util/time_util.h>

#include "server/calls/limits.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/limits/memory_limit.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {

CallLog Service::open(Context* context, const char* method, std::string_view session_id) {
  context->AddInitialMetadata("stiefel-numerics-id", numerics_id());
  if (const auto trace = trace_id_of(*context); !trace.empty())
    context->AddTrailingMetadata("stiefel-trace-id", std::string(trace));
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

grpc::ServerUnaryReactor* Service::Describe(Context* context, const v1::DescribeRequest*,
                                            v1::DescribeResponse* response) {
  CallLog log = open(context, "Describe");
  try {
    describe_engine(response);
    response->set_version(STIEFEL_VERSION);
    response->set_durable(host_.registry.durable());
    auto* limits = response->mutable_limits();
    limits->set_max_sessions(host_.registry.max_sessions());
    limits->set_max_message_bytes(largest_message(host_.memory_limit));
    limits->set_memory_bytes(host_.memory_limit);
    *limits->mutable_idle_timeout() = google::protobuf::util::TimeUtil::MillisecondsToDuration(
        host_.registry.idle_timeout().count());
    return finished(context, log, grpc::Status::OK);
  } catch (...) {
    return finished(context, log, errors::from_current_exception());
  }
}

}  // namespace stiefel::server
