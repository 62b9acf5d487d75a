#pragma once

#include <functional>
#include <optional>

#include "server/calls/read_request.h"
#include "server/calls/service.h"
#include "server/connections/callers.h"

namespace stiefel::server {

/// The service that is registered with gRPC: every call passes through it, and every reply gets the
/// metadata that tells the trace. Ends a call with UNAUTHENTICATED if its caller is
/// not let in, with INVALID_ARGUMENT if its request is not a message of the right type, and with
/// the status that its handler returns or that of an exception; writes a log line for each. No
/// RPC can miss the checks: they all are taken from simulation.proto.
///
/// Reads every request, and counts it against its principal's memory from before it is read to the
/// end of the call: one that does not fit is refused unread. A request of more than
/// `inline_request` bytes is read, and its call begun, by a worker, in the share of its principal.
/// The messages of a call with many requests are read by the call.
class Gate final : public v1::SimulationService::CallbackService {
 public:
  /// `callers` is null where every caller is let in.
  Gate(Host& host, server::Service& service, Callers* callers);

  using Context = grpc::CallbackServerContext;

 private:
  /// A handler of gRPC that lets a worker begin the calls with long requests.
  template <class Handler, class Request>
  class ByWorker;
  /// A handler of the service: of a unary call, of one that answers with a stream, or of one that
  /// reads a stream too.
  template <class Request, class Response>
  using Unary = server::Service::Unary (server::Service::*)(Context&, CallLog&, const Request&,
                                                            Response*);
  template <class Request, class Response>
  using Writing = server::Service::Writing<Response> (server::Service::*)(Context&, CallLog&,
                                                                          const Request&);
  template <class Request, class Response>
  using Driving = server::Service::Driving<Request, Response> (server::Service::*)(Context&,
                                                                                   CallLog&);

  /// Registers the RPC `name` with a ReadRequest, in place of the generated code, which would end a
  /// call with an unreadable request without a log line.
  template <class Request, class Response>
  void take(const char* name, Unary<Request, Response> handler);
  template <class Request, class Response>
  void take(const char* name, Writing<Request, Response> handler);
  template <class Request, class Response>
  void take(const char* name, Driving<Request, Response> handler);
  template <class Handler, class Request, class Pass>
  void take(const char* name, Pass pass);
  /// Lets the handler begin a call of the RPC `name` if its caller is let in and its request can be
  /// read; ends a call that goes no further.
  template <class Reactor, class Handler, class... Message>
  Reactor* pass(const char* name, Handler handler, Context* context, Message*... messages);
  /// Lets a worker call `begin`, which begins a call with a request of that size.
  void begin_later(Context& context, std::size_t bytes, const std::function<void()>& begin);

  Host& host_;
  server::Service& service_;
  Callers* const callers_;
};

}  // namespace stiefel::server
