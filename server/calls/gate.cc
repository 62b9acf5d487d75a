#include "server/calls/gate.h"

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/method_handler.h>

#include <type_traits>
#include <utility>

#include "server/convert/errors.h"

namespace stiefel::server {

/// gRPC's handler of an RPC, beside the call that it serves: the call, and with it its memory,
/// lives until its reply and its status are sent.
class Gate::OfCall final : public grpc::internal::MethodHandler {
 public:
  explicit OfCall(std::unique_ptr<grpc::internal::MethodHandler> of_grpc)
      : of_grpc_(std::move(of_grpc)) {}

  void* Deserialize(grpc_call* call, grpc_byte_buffer* bytes, grpc::Status* status,
                    void** data) override {
    return of_grpc_->Deserialize(call, bytes, status, data);
  }
  void RunHandler(const HandlerParameter& parameter) override {
    std::optional<ServerCall> call;
    of_this_thread = &call;
    of_grpc_->RunHandler(parameter);
  }

  static inline thread_local std::optional<ServerCall>* of_this_thread = nullptr;

 private:
  const std::unique_ptr<grpc::internal::MethodHandler> of_grpc_;
};

template <class Body>
grpc::Status Gate::serve(grpc::ServerContext& context, const char* name, const Body& body) {
  std::optional<ServerCall>& call = *OfCall::of_this_thread;
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

template <class Request, class Out>
std::unique_ptr<grpc::internal::MethodHandler> Gate::take(const char* name,
                                                          Handler<Request, Out>* handler) {
  using Reply = std::remove_pointer_t<std::remove_reference_t<Out>>;
  const auto answer = [name, handler](Gate* gate, grpc::ServerContext* context,
                                      const grpc::ByteBuffer* bytes, Reply* reply) {
    return gate->serve(*context, name, [&](ServerCall& call) {
      call.run([&] {
        // gRPC hands the bytes of a request out as a constant and does not use them again.
        const auto& request = call.read<Request>(const_cast<grpc::ByteBuffer&>(*bytes));
        if constexpr (std::is_pointer_v<Out>)
          handler(call, request, reply);
        else
          handler(call, request, *reply);
        if constexpr (requires { reply->set_work(0); }) reply->set_work(call.work());
      });
    });
  };
  using namespace grpc::internal;
  using Bytes = grpc::ByteBuffer;
  if constexpr (std::is_pointer_v<Out>)
    return std::make_unique<RpcMethodHandler<Gate, Bytes, Reply>>(answer, this);
  else
    return std::make_unique<ServerStreamingHandler<Gate, Bytes, Bytes>>(answer, this);
}

std::unique_ptr<grpc::internal::MethodHandler> Gate::take(const char* name,
                                                          void (*handler)(ServerCall&,
                                                                          ReaderWriter&)) {
  return std::make_unique<grpc::internal::TemplatedBidiStreamingHandler<ReaderWriter, false>>(
      [this, name, handler](grpc::ServerContext* context, ReaderWriter* stream) {
        return serve(*context, name, [&](ServerCall& call) { handler(call, *stream); });
      });
}

Gate::Gate(Host& host, Callers* callers) : host_(host), callers_(callers) {
  using grpc::internal::RpcMethod;
  const auto add = [&](const char* name, RpcMethod::RpcType type, auto* handler) {
    const auto& path = paths_.emplace_back("/" + std::string(service_name) + "/" + name);
    AddMethod(
        new grpc::internal::RpcServiceMethod(path.c_str(), type, new OfCall(take(name, handler))));
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
