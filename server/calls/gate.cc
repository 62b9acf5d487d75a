#include "server/calls/gate.h"

#include <memory>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {

/// gRPC's handler of an RPC, beside the call that it serves: the call, and with it its memory,
/// lives until its reply and its status are sent.
class Gate::Handler final : public grpc::internal::MethodHandler {
 public:
  explicit Handler(std::unique_ptr<grpc::internal::MethodHandler> of_grpc)
      : of_grpc_(std::move(of_grpc)) {}

  void* Deserialize(grpc_call* call, grpc_byte_buffer* bytes, grpc::Status* status,
                    void** data) override {
    return of_grpc_->Deserialize(call, bytes, status, data);
  }
  void RunHandler(const HandlerParameter& parameter) override {
    std::optional<ServerCall> call;
    call_of_this_thread = &call;
    of_grpc_->RunHandler(parameter);
  }

  static inline thread_local std::optional<ServerCall>* call_of_this_thread = nullptr;

 private:
  const std::unique_ptr<grpc::internal::MethodHandler> of_grpc_;
};

namespace {

/// Returns the bytes of a request, which gRPC hands out as a constant and does not use again.
grpc::ByteBuffer& taken(const grpc::ByteBuffer* bytes) {
  return const_cast<grpc::ByteBuffer&>(*bytes);
}

}  // namespace

template <class Body>
grpc::Status Gate::serve(grpc::ServerContext& context, const char* name, const Body& body) {
  std::optional<ServerCall>& call = *Handler::call_of_this_thread;
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

template <class Request, class Response>
std::unique_ptr<grpc::internal::MethodHandler> Gate::take(const char* name,
                                                          Unary<Request, Response>* handler) {
  return std::make_unique<grpc::internal::RpcMethodHandler<Gate, grpc::ByteBuffer, Response>>(
      [name, handler](Gate* gate, grpc::ServerContext* context, const grpc::ByteBuffer* bytes,
                      Response* response) {
        return gate->serve(*context, name, [&](ServerCall& call) {
          call.run([&] {
            handler(call, call.read<Request>(taken(bytes)), response);
            if constexpr (requires { response->set_work(0); }) response->set_work(call.work());
          });
        });
      },
      this);
}

template <class Request, class Response>
std::unique_ptr<grpc::internal::MethodHandler> Gate::take(const char* name,
                                                          Streaming<Request, Response>* handler) {
  return std::make_unique<grpc::internal::ServerStreamingHandler<Gate, grpc::ByteBuffer, Response>>(
      [name, handler](Gate* gate, grpc::ServerContext* context, const grpc::ByteBuffer* bytes,
                      grpc::ServerWriter<Response>* writer) {
        return gate->serve(*context, name, [&](ServerCall& call) {
          call.run([&] { handler(call, call.read<Request>(taken(bytes)), *writer); });
        });
      },
      this);
}

template <class Response>
std::unique_ptr<grpc::internal::MethodHandler> Gate::take(const char* name,
                                                          Driving<Response>* handler) {
  using Stream = grpc::ServerReaderWriter<Response, grpc::ByteBuffer>;
  return std::make_unique<grpc::internal::TemplatedBidiStreamingHandler<Stream, false>>(
      [this, name, handler](grpc::ServerContext* context, Stream* stream) {
        return serve(*context, name, [&](ServerCall& call) { handler(call, *stream); });
      });
}

Gate::Gate(Host& host, Callers* callers) : host_(host), callers_(callers) {
  using grpc::internal::RpcMethod;
  const auto add = [&](const char* name, RpcMethod::RpcType type, auto* handler) {
    const auto& path = paths_.emplace_back(
        "/" + std::string(v1::SimulationService::service_full_name()) + "/" + name);
    AddMethod(
        new grpc::internal::RpcServiceMethod(path.c_str(), type, new Handler(take(name, handler))));
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
