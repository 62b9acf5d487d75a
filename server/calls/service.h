#pragma once

#include "server/admission/read_request.h"
#include "server/calls/host.h"
#include "stiefel/v1/simulation.grpc.pb.h"

namespace stiefel::server {

/// The RPCs, each in its own file except for the short ones. Calls that compute for longer than
/// `inline_nanoseconds` do so on the host's pools.
class Service final {
 public:
  explicit Service(Host& host);

  using Context = grpc::CallbackServerContext;
  /// The reply is always the same, and is kept as bytes.
  grpc::ServerUnaryReactor* Describe(Context*, const v1::DescribeRequest*, grpc::ByteBuffer*);
  grpc::ServerUnaryReactor* CreateSession(Context*, const v1::CreateSessionRequest*,
                                          v1::CreateSessionResponse*);
  grpc::ServerUnaryReactor* GetSession(Context*, const v1::GetSessionRequest*,
                                       v1::GetSessionResponse*);
  /// Sends a v1::ListSessionsResponse as bytes, so that not gRPC's thread frees the message.
  grpc::ServerUnaryReactor* ListSessions(Context*, const v1::ListSessionsRequest*,
                                         grpc::ByteBuffer*);
  grpc::ServerUnaryReactor* DeleteSession(Context*, const v1::DeleteSessionRequest*,
                                          v1::DeleteSessionResponse*);
  grpc::ServerUnaryReactor* Step(Context*, const v1::StepRequest*, v1::StepResponse*);
  /// Reads its requests one by one.
  grpc::ServerBidiReactor<ReadRequest<v1::DriveRequest>, v1::DriveResponse>* Drive(Context*);
  /// Sends v1::StreamResponse messages as bytes, so that a stream that waits for its reader holds a
  /// message only once.
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Stream(Context*, const v1::StreamRequest*);
  grpc::ServerUnaryReactor* Diagnose(Context*, const v1::DiagnoseRequest*, v1::DiagnoseResponse*);
  grpc::ServerUnaryReactor* ForkSession(Context*, const v1::ForkSessionRequest*,
                                        v1::ForkSessionResponse*);
  grpc::ServerWriteReactor<v1::ConvertResponse>* Convert(Context*, const v1::ConvertRequest*);
  grpc::ServerWriteReactor<v1::ConnectResponse>* Connect(Context*, const v1::ConnectRequest*);
  grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>* MeasureTradeoff(
      Context*, const v1::MeasureTradeoffRequest*);
  grpc::ServerWriteReactor<v1::SummarizeResponse>* Summarize(Context*, const v1::SummarizeRequest*);

 private:
  /// Begins a call and returns its log.
  CallLog open(Context* context, const char* method, std::string_view session_id = {});
  /// Ends a unary call with `status`.
  static grpc::ServerUnaryReactor* finished(Context* context, CallLog& log,
                                            const grpc::Status& status, std::int64_t steps = 0);
  /// Runs `work` on this thread and answers with its result.
  template <class Response, class Work>
  grpc::ServerUnaryReactor* answer(Context* context, CallLog log, Response* response, Work work);

  Host& host_;
  grpc::ByteBuffer description_;  // the reply of Describe
};

}  // namespace stiefel::server
