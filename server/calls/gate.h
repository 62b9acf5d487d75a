#pragma once

#include <grpcpp/impl/service_type.h>

#include <deque>
#include <memory>
#include <string>

#include "server/calls/server_call.h"
#include "server/calls/service.h"
#include "server/connections/callers.h"

namespace stiefel::server {

/// The service that is registered with gRPC: every call passes through `serve`. Ends a call with
/// UNAUTHENTICATED if its caller is not let in, with INVALID_ARGUMENT if its request is not a
/// message of the right type, and with the status of what its handler throws; writes a log line for
/// each. No RPC can miss the checks: they all are taken from simulation.proto.
///
/// A request arrives as bytes, and counts against its principal's memory from before it is read to
/// the end of the call: one that does not fit is refused unread.
class Gate final : public grpc::Service {
 public:
  /// `callers` is null where every caller is let in.
  Gate(Host& host, Callers* callers);

 private:
  class OfCall;

  /// Makes gRPC's handler of an RPC from ours.
  template <class Request, class Out>
  std::unique_ptr<grpc::internal::MethodHandler> take(const char* name,
                                                      Handler<Request, Out>* handler);
  std::unique_ptr<grpc::internal::MethodHandler> take(const char* name,
                                                      void (*handler)(ServerCall&, ReaderWriter&));
  /// Makes the call of this thread, lets `body` answer it if its caller is let in, and returns the
  /// status with which it ends.
  template <class Body>
  grpc::Status serve(grpc::ServerContext& context, const char* name, const Body& body);

  Host& host_;
  Callers* const callers_;
  std::deque<std::string> paths_;  // of the methods
};

}  // namespace stiefel::server
