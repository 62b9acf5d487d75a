#include <google/protobuf/util/time_util.h>

#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/scheduling/memory_limit.h"

namespace stiefel::server {
v1::DescribeResponse description(const Host& host) {
  v1::DescribeResponse response;
  describe_engine(&response);
  response.set_version(STIEFEL_VERSION);
  response.set_durable(host.registry.durable());
  auto* limits = response.mutable_limits();
  limits->set_max_sessions(host.registry.max_sessions());
  limits->set_max_message_bytes(largest_message(host.memory_limit));
  limits->set_memory_bytes(host.memory_limit);
  *limits->mutable_idle_timeout() = google::protobuf::util::TimeUtil::MillisecondsToDuration(
      host.registry.idle_timeout().count());
  return response;
}

void Describe(ServerCall& call, const v1::DescribeRequest&, v1::DescribeResponse* response) {
  *response = call.host().description;
}

}  // namespace stiefel::server
