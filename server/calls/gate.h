#pragma once

#include <expected>
#include <functional>

#include "server/admission/read_request.h"
#include "server/calls/service.h"
#include "server/connections/callers.h"

namespace stiefel::server {

/// The service that is registered with gRPC: every call passes through it, and every reply gets the
/// metadata that tells the build and the trace. Ends a call with
/// UNAUTHENTICATED if its caller is not let in, with INVALID_ARGUMENT if its request is not a
/// message of the right type, and with the status of an exception that starting it throws; writes a
/// log line for each. An RPC that is not forwarded here is UNIMPLEMENTED, so none can miss the
/// checks.
///
/// Reads every request, and counts it against its principal's memory from before it is read to the
/// end of the call: one that does not fit is refused unread. A request of more than
/// `inline_request` bytes is read, and its call begun, by a worker, in the share of its principal.
/// The messages of a Drive are read by its call.
class Gate final : public v1::SimulationService::CallbackService {
 public:
  /// `callers` is null where every caller is let in.
  Gate(Host& host, server::Service& service, Callers* callers);

  using Context = grpc::CallbackServerContext;

 private:
  /// A handler of gRPC that lets a worker begin the calls with long requests.
  template <class Handler, class Request>
  class ByWorker;
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
  void take_drive();
  template <class Reactor, class Request, class Forward>
  Reactor* pass(const char* name, Context* context, const ReadRequest<Request>& request,
                const Forward& forward);
  /// Forwards the call of the RPC `name` if its caller is let in and `forward` returns a reactor.
  /// Otherwise ends it with an error.
  template <class Reactor, class Forward>
  Reactor* pass(const char* name, Context* context, const Forward& forward);
  /// Lets a worker call `begin`, which begins a call with a request of that size.
  void begin_later(Context& context, std::size_t bytes, const std::function<void()>& begin);

  Host& host_;
  server::Service& service_;
  Callers* const callers_;
};

}  // namespace stiefel::server
