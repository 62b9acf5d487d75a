#pragma once

#include "server/access/callers.h"
#include "server/calls/service.h"

namespace stiefel::server {

/// The service as it is registered: every call passes here. One whose caller is not let in ends
/// with UNAUTHENTICATED, one whose request is no such message with INVALID_ARGUMENT, one that
/// cannot be made for an exception with its status; each has its line in the log. A call that is
/// not forwarded here is UNIMPLEMENTED, so that no RPC can miss the checks.
class Gate final : public ServiceInBytes {
 public:
  /// `callers`: null where every caller is let in.
  Gate(Host& host, server::Service& service, Callers* callers);

  using Context = grpc::CallbackServerContext;
  grpc::ServerUnaryReactor* Describe(Context*, const grpc::ByteBuffer*, grpc::ByteBuffer*) override;
  grpc::ServerBidiReactor<v1::DriveRequest, v1::DriveResponse>* Drive(Context*) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Stream(Context*, const grpc::ByteBuffer*) override;

 private:
  template <class Request, class Response>
  using Unary = grpc::ServerUnaryReactor* (server::Service::*)(Context*, const Request*, Response*);
  template <class Request, class Response>
  using Writing = grpc::ServerWriteReactor<Response>* (server::Service::*)(Context*,
                                                                           const Request*);

  /// Registers the RPC of that name, whose request is read here, in the place of the generated
  /// code, which would end a call that it cannot read in silence.
  template <class Request, class Response>
  void take(const char* name, Unary<Request, Response> call);
  template <class Request, class Response>
  void take(const char* name, Writing<Request, Response> call);
  /// Forwards the call of that name, or ends it; what it asks for is in `fault` if it is none.
  template <class Reactor, class Forward>
  Reactor* pass(const char* name, Context* context, const grpc::Status& fault,
                const Forward& forward);

  Host& host_;
  server::Service& service_;
  Callers* const callers_;
};

}  // namespace stiefel::server
