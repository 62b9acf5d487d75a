#include "server/calls/gate.h"

#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {

template <class Body>
grpc::Status Gate::serve(std::optional<ServerCall>& call, grpc::ServerContext& context,
                         const char* name, const Body& body) {
  grpc::Status status;
  try {
    call.emplace(host_, context, name);
    call->admit(callers_);
    body(*call);
  } catch (...) {
    status = call ? call->current_error() : errors::from_current_exception();
  }
  if (call) call->end(status);
  return status;
}

/// Serves an RPC with one reply. The call, and with it its memory, lives until the reply is sent.
template <class Request, class Response>
class Gate::UnaryHandler final : public grpc::internal::MethodHandler {
 public:
  UnaryHandler(Gate& gate, const char* name, Unary<Request, Response>* handler)
      : gate_(gate), name_(name), handler_(handler) {}

  void* Deserialize(grpc_call* call, grpc_byte_buffer* bytes, grpc::Status* status,
                    void**) override {
    void* place = grpc_call_arena_alloc(call, sizeof(ReadRequest<Request>));
    return grpc::internal::UnaryDeserializeHelper(bytes, status, new (place) ReadRequest<Request>);
  }
  void RunHandler(const HandlerParameter& parameter) override {
    auto* request = static_cast<ReadRequest<Request>*>(parameter.request);
    auto& context = *static_cast<grpc::ServerContext*>(parameter.server_context);
    std::optional<ServerCall> call;
    Response response;
    grpc::Status status = gate_.serve(call, context, name_, [&](ServerCall& of) {
      of.run([&] {
        handler_(of, of.read(*request), &response);
        if constexpr (requires { response.set_work(0); }) response.set_work(of.work());
      });
    });
    request->~ReadRequest();
    grpc::internal::UnaryRunHandlerHelper(parameter, &response, status);
  }

 private:
  Gate& gate_;
  const char* const name_;
  Unary<Request, Response>* const handler_;
};

/// Serves an RPC with a stream of messages. The call, and with it its memory, lives until its
/// status is sent.
template <class Request, class Response>
class Gate::StreamingHandler final : public grpc::internal::MethodHandler {
 public:
  StreamingHandler(Gate& gate, const char* name, Streaming<Request, Response>* handler)
      : handler_(
            [&gate, name, handler](Gate*, grpc::ServerContext* context,
                                   const ReadRequest<Request>* request,
                                   grpc::ServerWriter<Response>* writer) {
              return gate.serve(*call_of_this_thread, *context, name, [&](ServerCall& of) {
                of.run([&] { handler(of, of.read(*request), *writer); });
              });
            },
            &gate) {}

  void* Deserialize(grpc_call* call, grpc_byte_buffer* bytes, grpc::Status* status,
                    void** data) override {
    return handler_.Deserialize(call, bytes, status, data);
  }
  void RunHandler(const HandlerParameter& parameter) override {
    std::optional<ServerCall> call;
    call_of_this_thread = &call;
    handler_.RunHandler(parameter);
  }

 private:
  static inline thread_local std::optional<ServerCall>* call_of_this_thread = nullptr;

  grpc::internal::ServerStreamingHandler<Gate, ReadRequest<Request>, Response> handler_;
};

template <class Request, class Response>
grpc::internal::MethodHandler* Gate::take(const char* name, Unary<Request, Response>* handler) {
  return new UnaryHandler<Request, Response>(*this, name, handler);
}

template <class Request, class Response>
grpc::internal::MethodHandler* Gate::take(const char* name, Streaming<Request, Response>* handler) {
  return new StreamingHandler<Request, Response>(*this, name, handler);
}

template <class Request, class Response>
grpc::internal::MethodHandler* Gate::take(const char* name, Driving<Request, Response>* handler) {
  using Stream = grpc::ServerReaderWriter<Response, ReadRequest<Request>>;
  return new grpc::internal::TemplatedBidiStreamingHandler<Stream, false>(
      [this, name, handler](grpc::ServerContext* context, Stream* stream) {
        std::optional<ServerCall> call;
        return serve(call, *context, name, [&](ServerCall& of) { handler(of, *stream); });
      });
}

Gate::Gate(Host& host, Callers* callers) : host_(host), callers_(callers) {
  using grpc::internal::RpcMethod;
  const auto add = [&](const char* name, RpcMethod::RpcType type, auto* handler) {
    const auto& path = paths_.emplace_back(
        "/" + std::string(v1::SimulationService::service_full_name()) + "/" + name);
    AddMethod(new grpc::internal::RpcServiceMethod(path.c_str(), type, take(name, handler)));
  };
#define UNARY(Name) add(#Name, RpcMethod::NORMAL_RPC, &Name);
#define STREAM(Name) add(#Name, RpcMethod::SERVER_STREAMING, &Name);
#define DUPLEX(Name) add(#Name, RpcMethod::BIDI_STREAMING, &Name);
#include "stiefel/v1/rpcs.inc"
#undef UNARY
#undef STREAM
#undef DUPLEX
}

}  // namespace stiefel::server
