// The calls that need no session.
#include <google/protobuf/util/time_util.h>

#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/answers.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/geodesics/geodesic_answers.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"
#include "server/convert/work_price.h"
#include "server/scheduling/memory_limit.h"

namespace stiefel::server {
namespace {

/// Returns the memory of a request until it is checked.
MemoryLease lease_for(CallLog& log, const google::protobuf::Message& request,
                      std::uint64_t workspace = 0) {
  return {log.account().memory(), memory_price({held_by(request), workspace})};
}

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

}  // namespace

Service::Service(Host& host) : host_(host) { serialize(description(host), description_); }

Service::Unary Service::Describe(Context&, CallLog&, const v1::DescribeRequest&,
                                 grpc::ByteBuffer* response) {
  *response = description_;
  return grpc::Status::OK;
}

Service::Writing<v1::ConvertResponse> Service::Convert(Context&, CallLog& log,
                                                       const v1::ConvertRequest& request) {
  const auto answer = std::make_shared<ConversionAnswer>(
      request, lease_for(log, request, 2 * scene_workspace(request.scene())));
  const double work = conversion_work(request);
  const JobKind kind = wants_choice(request.scene()) ? JobKind::unsliced : kind_of_piece(work);
  return message_a_slice<v1::ConvertResponse>(
      host_, std::move(log), kind, work,
      [answer](const std::stop_token&,
               v1::ConvertResponse& response) -> std::expected<bool, grpc::Status> {
        if (const auto status = answer->next(response); !status.ok())
          return std::unexpected(status);
        return answer->done();
      });
}

Service::Writing<v1::ConjugatePointsResponse> Service::ConjugatePoints(
    Context&, CallLog& log, const v1::ConjugatePointsRequest& request) {
  const auto answer = std::make_shared<ConjugateAnswer>(request, lease_for(log, request));
  return message_a_slice<v1::ConjugatePointsResponse>(
      host_, std::move(log), JobKind::unsliced, ConjugateAnswer::work(),
      [answer](const std::stop_token& stop,
               v1::ConjugatePointsResponse& response) -> std::expected<bool, grpc::Status> {
        if (const auto status = answer->next(stop, response); !status.ok())
          return std::unexpected(status);
        return answer->done();
      });
}

Service::Writing<v1::MeasureTradeoffResponse> Service::MeasureTradeoff(
    Context&, CallLog& log, const v1::MeasureTradeoffRequest& request) {
  const auto answer = std::make_shared<TradeoffAnswer>(
      request, lease_for(log, request, 2 * scene_workspace(request.scene())));
  return message_a_slice<v1::MeasureTradeoffResponse>(
      host_, std::move(log), JobKind::unsliced, tradeoff_work(request),
      [answer](const std::stop_token& stop,
               v1::MeasureTradeoffResponse& response) -> std::expected<bool, grpc::Status> {
        const auto status = answer->next(stop, response);
        // A measurement that a stop interrupted is not valid.
        if (stop.stop_requested()) return std::unexpected(errors::cancelled());
        if (!status.ok()) return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
