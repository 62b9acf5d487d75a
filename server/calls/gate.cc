#include "server/calls/gate.h"

#include <functional>
#include <new>
#include <string>

#include "server/admission/read_request.h"
#include "server/convert/errors.h"
#include "server/observability/log.h"
#include "server/sessions/identity.h"

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

/// Begins one call, on a worker. Deletes itself.
class Beginning final : public Job {
 public:
  Beginning(Host& host, Account& account, std::size_t bytes, const std::function<void()>& begin)
      : host_(host), begin_(begin) {
    const double work = work_of_a_byte * static_cast<double>(bytes);
    bill(account.share(), work);
    host_.lifecycle.enter();
    host_.pool_for_piece(work).submit(this);
  }

 private:
  bool run_slice() noexcept override {
    begin_();
    Lifecycle& lifecycle = host_.lifecycle;
    delete this;
    lifecycle.leave();
    return false;
  }

  Host& host_;
  const std::function<void()> begin_;
};

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
  take_drive();
}

template <class Handler, class Request>
class Gate::ByWorker final : public grpc::internal::MethodHandler {
 public:
  template <class Call>
  ByWorker(Gate& gate, Call call) : gate_(gate), handler_(std::move(call)) {}

  void* Deserialize(grpc_call* call, grpc_byte_buffer* bytes, grpc::Status* status,
                    void** data) override {
    return handler_.Deserialize(call, bytes, status, data);
  }
  void RunHandler(const HandlerParameter& parameter) override {
    const auto* request = static_cast<const ReadRequest<Request>*>(parameter.request);
    if (request == nullptr || request->size() <= inline_request)
      return handler_.RunHandler(parameter);
    std::function<void()> begin;
    try {
      begin = [this, parameter] { handler_.RunHandler(parameter); };
    } catch (const std::bad_alloc&) {
      return handler_.RunHandler(parameter);
    }
    gate_.begin_later(*static_cast<Context*>(parameter.server_context), request->size(), begin);
  }

 private:
  Gate& gate_;
  Handler handler_;
};

void Gate::begin_later(Context& context, std::size_t bytes, const std::function<void()>& begin) {
  try {
    if (!callers_ || !callers_->admit(context)) {
      new Beginning(host_, host_.accounts.of(host_.identify(context)), bytes, begin);
      return;
    }
  } catch (const std::exception&) {  // ends the call below
  }
  begin();
}

template <class Reactor, class Request, class Forward>
Reactor* Gate::pass(const char* name, Context* context, const ReadRequest<Request>& request,
                    const Forward& forward) {
  return pass<Reactor>(name, context, [&]() -> std::expected<Reactor*, grpc::Status> {
    if (request.read(host_.accounts.of(host_.identify(*context)).memory())) return forward();
    return std::unexpected(
        errors::invalid("request", "", "the bytes are not a " + Request::descriptor()->name()));
  });
}

template <class Reactor, class Forward>
Reactor* Gate::pass(const char* name, Context* context, const Forward& forward) {
  grpc::Status status;
  try {
    mark(*context);
    if (const auto refused = callers_ ? callers_->admit(*context) : std::nullopt) {
      status = status_of(*refused);
    } else {
      const std::expected<Reactor*, grpc::Status> reactor = forward();
      if (reactor) return *reactor;
      status = reactor.error();
    }
  } catch (...) {
    status = errors::from_current_exception();
  }
  try {
    CallLog(host_.log, *context, name, {}, host_.metrics.get()).finish(status);
  } catch (const std::exception&) {  // no memory for a log line
  }
  return new Ended<Reactor>(status);
}

template <class Request, class Response>
void Gate::take(const char* name, Unary<Request, Response> call) {
  using Handler = grpc::internal::CallbackUnaryHandler<ReadRequest<Request>, Response>;
  MarkMethodCallback(
      method(name).index(),
      new ByWorker<Handler, Request>(
          *this, [this, name, call](Context* context, const ReadRequest<Request>* request,
                                    Response* response) {
            return pass<grpc::ServerUnaryReactor>(name, context, *request, [&] {
              return (service_.*call)(context, &request->message(), response);
            });
          }));
}

template <class Request, class Response>
void Gate::take(const char* name, Writing<Request, Response> call) {
  using Handler = grpc::internal::CallbackServerStreamingHandler<ReadRequest<Request>, Response>;
  MarkMethodCallback(
      method(name).index(),
      new ByWorker<Handler, Request>(
          *this, [this, name, call](Context* context, const ReadRequest<Request>* request) {
            return pass<grpc::ServerWriteReactor<Response>>(name, context, *request, [&] {
              return (service_.*call)(context, &request->message());
            });
          }));
}

void Gate::take_drive() {
  using Request = ReadRequest<v1::DriveRequest>;
  using Handler = grpc::internal::CallbackBidiHandler<Request, v1::DriveResponse>;
  MarkMethodCallback(method("Drive").index(), new Handler([this](Context* context) {
                       return pass<grpc::ServerBidiReactor<Request, v1::DriveResponse>>(
                           "Drive", context, [&] { return service_.Drive(context); });
                     }));
}

}  // namespace stiefel::server
