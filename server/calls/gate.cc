#include "server/calls/gate.h"

#include <string>

#include "server/admission/log.h"
#include "server/calls/read_request.h"
#include "server/convert/errors.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

/// Sets the reply's metadata `stiefel-numerics-id` and, for a call with a `traceparent`, the
/// trailing `stiefel-trace-id`.
void mark(grpc::CallbackServerContext& context) {
  context.AddInitialMetadata("stiefel-numerics-id", numerics_id());
  if (const auto trace = trace_id_of(context); !trace.empty())
    context.AddTrailingMetadata("stiefel-trace-id", std::string(trace));
}

/// Ends a call that was not started. Deletes itself.
template <class Reactor>
class Ended final : public Reactor {
 public:
  explicit Ended(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

grpc::Status status_of(Refused refused) {
  return refused == Refused::token_missing ? errors::token_missing() : errors::token_unknown();
}

const google::protobuf::MethodDescriptor& method(const char* name) {
  return *google::protobuf::DescriptorPool::generated_pool()
              ->FindServiceByName(v1::SimulationService::service_full_name())
              ->FindMethodByName(name);
}

template <class Request>
grpc::Status fault_of(const ReadRequest<Request>& request) {
  if (request.is_message) return grpc::Status::OK;
  try {
    if (request.failure) std::rethrow_exception(request.failure);
  } catch (...) {
    return errors::from_current_exception();
  }
  return errors::invalid("request", "", "the bytes are not a " + Request::descriptor()->name());
}

}  // namespace

Gate::Gate(Host& host, server::Service& service, Callers* callers)
    : host_(host), service_(service), callers_(callers) {
  using server::Service;
  take("CreateSession", &Service::CreateSession);
  take("GetSession", &Service::GetSession);
  take("ListSessions", &Service::ListSessions);
  take("DeleteSession", &Service::DeleteSession);
  take("Step", &Service::Step);
  take("Summarize", &Service::Summarize);
  take("Diagnose", &Service::Diagnose);
  take("ForkSession", &Service::ForkSession);
  take("Describe", &Service::Describe);
  take("Stream", &Service::Stream);
  take("Convert", &Service::Convert);
  take("Connect", &Service::Connect);
  take("MeasureTradeoff", &Service::MeasureTradeoff);
}

template <class Reactor, class Request, class Forward>
Reactor* Gate::pass(const char* name, Context* context, const ReadRequest<Request>& request,
                    const Forward& forward) {
  const auto held = [&] {
    request.hold(host_.accounts.of(host_.identify(*context)).memory());
    return forward();
  };
  const auto refuse = [&] { request.drop(); };
  return pass<Reactor>(name, context, fault_of(request), held, refuse);
}

template <class Reactor, class Forward, class Refuse>
Reactor* Gate::pass(const char* name, Context* context, const grpc::Status& fault,
                    const Forward& forward, const Refuse& refuse) {
  grpc::Status status = fault;
  try {
    mark(*context);
    if (const auto refused = callers_ ? callers_->admit(*context) : std::nullopt)
      status = status_of(*refused);
    if (status.ok()) return forward();
  } catch (...) {
    status = errors::from_current_exception();
  }
  try {
    CallLog(host_.log, *context, name, {}, host_.metrics.get()).finish(status);
  } catch (const std::exception&) {  // no memory for a log line
  }
  refuse();
  return new Ended<Reactor>(status);
}

template <class Request, class Response>
void Gate::take(const char* name, Unary<Request, Response> call) {
  using Handler = grpc::internal::CallbackUnaryHandler<ReadRequest<Request>, Response>;
  MarkMethodCallback(
      method(name).index(),
      new Handler([this, name, call](Context* context, const ReadRequest<Request>* request,
                                     Response* response) {
        return pass<grpc::ServerUnaryReactor>(name, context, *request, [&] {
          return (service_.*call)(context, &request->message, response);
        });
      }));
}

template <class Request, class Response>
void Gate::take(const char* name, Writing<Request, Response> call) {
  using Handler = grpc::internal::CallbackServerStreamingHandler<ReadRequest<Request>, Response>;
  MarkMethodCallback(
      method(name).index(),
      new Handler([this, name, call](Context* context, const ReadRequest<Request>* request) {
        return pass<grpc::ServerWriteReactor<Response>>(
            name, context, *request, [&] { return (service_.*call)(context, &request->message); });
      }));
}

grpc::ServerBidiReactor<v1::DriveRequest, v1::DriveResponse>* Gate::Drive(Context* context) {
  using Reactor = grpc::ServerBidiReactor<v1::DriveRequest, v1::DriveResponse>;
  return pass<Reactor>(
      "Drive", context, grpc::Status::OK, [&] { return service_.Drive(context); }, [] {});
}

}  // namespace stiefel::server
