#pragma once

#include "server/access/callers.h"
#include "server/calls/service.h"

namespace stiefel::server {

/// The service as it is registered: every call passes here, and one whose caller is not let in ends
/// with UNAUTHENTICATED. A call that is not forwarded here is UNIMPLEMENTED, so that no RPC can
/// miss the check.
class Gate final : public ServiceInBytes {
 public:
  /// `callers`: null where every caller is let in.
  Gate(Host& host, server::Service& service, Callers* callers)
      : host_(host), service_(service), callers_(callers) {}

  using Context = grpc::CallbackServerContext;
  grpc::ServerUnaryReactor* Describe(Context*, const grpc::ByteBuffer*, grpc::ByteBuffer*) override;
  grpc::ServerUnaryReactor* CreateSession(Context*, const v1::CreateSessionRequest*,
                                          v1::CreateSessionResponse*) override;
  grpc::ServerUnaryReactor* GetSession(Context*, const v1::GetSessionRequest*,
                                       v1::GetSessionResponse*) override;
  grpc::ServerUnaryReactor* ListSessions(Context*, const v1::ListSessionsRequest*,
                                         v1::ListSessionsResponse*) override;
  grpc::ServerUnaryReactor* DeleteSession(Context*, const v1::DeleteSessionRequest*,
                                          v1::DeleteSessionResponse*) override;
  grpc::ServerUnaryReactor* Step(Context*, const v1::StepRequest*, v1::StepResponse*) override;
  grpc::ServerBidiReactor<v1::DriveRequest, v1::DriveResponse>* Drive(Context*) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Stream(Context*, const grpc::ByteBuffer*) override;
  grpc::ServerWriteReactor<v1::SummarizeResponse>* Summarize(Context*,
                                                             const v1::SummarizeRequest*) override;
  grpc::ServerUnaryReactor* Diagnose(Context*, const v1::DiagnoseRequest*,
                                     v1::DiagnoseResponse*) override;
  grpc::ServerUnaryReactor* ForkSession(Context*, const v1::ForkSessionRequest*,
                                        v1::ForkSessionResponse*) override;
  grpc::ServerWriteReactor<v1::ConvertResponse>* Convert(Context*,
                                                         const v1::ConvertRequest*) override;
  grpc::ServerWriteReactor<v1::ConnectResponse>* Connect(Context*,
                                                         const v1::ConnectRequest*) override;
  grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>* MeasureTradeoff(
      Context*, const v1::MeasureTradeoffRequest*) override;

 private:
  /// Forwards the call of that name, or refuses it.
  template <class Reactor, class... Messages>
  Reactor* pass(const char* name, Reactor* (server::Service::*call)(Context*, Messages...),
                Context* context, Messages... messages);

  Host& host_;
  server::Service& service_;
  Callers* const callers_;
};

}  // namespace stiefel::server
