#pragma once

#include "server/access/callers.h"
#include "server/calls/read_request.h"
#include "server/calls/service.h"

namespace stiefel::server {

/// The service that is registered with gRPC: every call passes through it, and every reply gets the
/// metadata that tells the build and the trace. Ends a call with
/// UNAUTHENTICATED if its caller is not let in, with INVALID_ARGUMENT if its request is not a
/// message of the right type, and with the status of an exception that starting it throws; writes a
/// log line for each. An RPC that is not forwarded here is UNIMPLEMENTED, so none can miss the
/// checks.
///
/// Counts every request against its principal's memory from here to the end of the call, and
/// refuses one that does not fit. The messages of a Drive are read one by one and kept by no one.
class Gate final : public v1::SimulationService::CallbackService {
 public:
  /// `callers` is null where every caller is let in.
  Gate(Host& host, server::Service& service, Callers* callers);

  using Context = grpc::CallbackServerContext;
  grpc::ServerBidiReactor<v1::DriveRequest, v1::DriveResponse>* Drive(Context*) override;

 private:
  template <class Request, class Response>
  using Unary = grpc::ServerUnaryReactor* (server::Service::*)(Context*, const Request*, Response*);
  template <class Request, class Response>
  using Writing = grpc::ServerWriteReactor<Response>* (server::Service::*)(Context*,
                                                                           const Request*);

  /// Registers the RPC `name` with a ReadRequest, in place of the generated code, which would end a
  /// call with an unreadable request without a log line.
  template <class Request, class Response>
  void take(const char* name, Unary<Request, Response> call);
  template <class Request, class Response>
  void take(const char* name, Writing<Request, Response> call);
  template <class Reactor, class Request, class Forward>
  Reactor* pass(const char* name, Context* context, const ReadRequest<Request>& request,
                const Forward& forward);
  /// Forwards the call of the RPC `name` unless its caller is refused or `fault` is an error, with
  /// which it ends the call, after `refuse()`.
  template <class Reactor, class Forward, class Refuse>
  Reactor* pass(const char* name, Context* context, const grpc::Status& fault,
                const Forward& forward, const Refuse& refuse);

  Host& host_;
  server::Service& service_;
  Callers* const callers_;
};

}  // namespace stiefel::server
