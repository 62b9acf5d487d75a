#include "server/calls/gate.h"

#include <new>
#include <string>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

/// Sets the trailing metadata `stiefel-trace-id` of a call with a `traceparent`.
void mark(grpc::CallbackServerContext& context) {
  if (const auto trace = trace_id_of(context); !trace.empty())
    context.AddTrailingMetadata("stiefel-trace-id", std::string(trace));
}

/// Ends a call. Deletes itself.
template <class Reactor>
class Ended final : public Reactor {
 public:
  explicit Ended(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

template <class Reactor>
Reactor* ended(grpc::CallbackServerContext&, const grpc::Status& status) {
  return new Ended<Reactor>(status);
}
template <>
grpc::ServerUnaryReactor* ended(grpc::CallbackServerContext& context, const grpc::Status& status) {
  auto* reactor = context.DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

grpc::Status status_of(Refused refused) {
  return refused == Refused::token_missing ? errors::token_missing() : errors::token_unknown();
}

const google::protobuf::MethodDescriptor& method(const char* name) {
  return *google::protobuf::DescriptorPool::generated_pool()
              ->FindServiceByName(v1::SimulationService::service_full_name())
              ->FindMethodByName(name);
}

/// Thrown where the bytes of a request are not a message of its type.
struct Unreadable : std::exception {
  explicit Unreadable(const google::protobuf::Descriptor& type)
      : status(errors::invalid("request", "", "the bytes are not a " + type.name())) {}
  const grpc::Status status;
};

/// Reads the request, tells the log its session and returns the message. Throws Unreadable.
template <class Request>
const Request& argument(const ReadRequest<Request>* request, CallLog& log) {
  if (!request->read(log.account().memory())) throw Unreadable(*Request::descriptor());
  if constexpr (requires { request->message().session_id(); })
    log.name(request->message().session_id());
  return request->message();
}
template <class Response>
Response* argument(Response* response, CallLog&) {
  return response;
}

/// Begins one call, on a worker. Deletes itself.
class Beginning final : public Job {
 public:
  Beginning(Host& host, Account& account, std::size_t bytes, const std::function<void()>& begin)
      : host_(host), begin_(begin) {
    const double work = work_of_a_byte * static_cast<double>(bytes);
    bill(account.share(), work);
    host_.lifecycle.enter();
    host_.scheduler.submit(this, kind_of_piece(work));
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
#define UNARY(Name) take(#Name, &server::Service::Name);
#define STREAM(Name) take(#Name, &server::Service::Name);
#define DUPLEX(Name) take(#Name, &server::Service::Name);
#include "stiefel/v1/rpcs.inc"
#undef UNARY
#undef STREAM
#undef DUPLEX
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

template <class Reactor, class Handler, class... Message>
Reactor* Gate::pass(const char* name, Handler handler, Context* context, Message*... messages) {
  std::optional<CallLog> log;
  Begun<Reactor> begun = grpc::Status::OK;
  try {
    log.emplace(host_.log, *context, name, host_.metrics.get());
    mark(*context);
    if (const auto refused = callers_ ? callers_->admit(*context) : std::nullopt) {
      begun = status_of(*refused);
    } else {
      log->bill(host_.accounts.of(host_.identify(*context)));
      begun = (service_.*handler)(*context, *log, argument(messages, *log)...);
    }
  } catch (const Unreadable& unreadable) {
    begun = unreadable.status;
  } catch (...) {
    begun = errors::from_current_exception();
  }
  if (begun.reactor) return begun.reactor;
  if (log) log->finish(begun.status);
  return ended<Reactor>(*context, begun.status);
}

template <class Request, class Response>
void Gate::take(const char* name, Unary<Request, Response> handler) {
  using Read = const ReadRequest<Request>;
  using Handler = grpc::internal::CallbackUnaryHandler<ReadRequest<Request>, Response>;
  take<Handler, Request>(
      name, std::bind_front(
                &Gate::pass<grpc::ServerUnaryReactor, Unary<Request, Response>, Read, Response>,
                this, name, handler));
}

template <class Request, class Response>
void Gate::take(const char* name, Writing<Request, Response> handler) {
  using Read = const ReadRequest<Request>;
  using Handler = grpc::internal::CallbackServerStreamingHandler<ReadRequest<Request>, Response>;
  take<Handler, Request>(
      name, std::bind_front(
                &Gate::pass<grpc::ServerWriteReactor<Response>, Writing<Request, Response>, Read>,
                this, name, handler));
}

template <class Handler, class Request, class Pass>
void Gate::take(const char* name, Pass pass) {
  MarkMethodCallback(method(name).index(), new ByWorker<Handler, Request>(*this, std::move(pass)));
}

template <class Request, class Response>
void Gate::take(const char* name, Driving<Request, Response> handler) {
  using Reactor = grpc::ServerBidiReactor<ReadRequest<Request>, Response>;
  using Handler = grpc::internal::CallbackBidiHandler<ReadRequest<Request>, Response>;
  MarkMethodCallback(method(name).index(), new Handler([this, name, handler](Context* context) {
                       return pass<Reactor>(name, handler, context);
                     }));
}

}  // namespace stiefel::server
