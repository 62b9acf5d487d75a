#pragma once

#include <new>

#include "server/calls/call.h"
#include "server/calls/read_request.h"
#include "server/scheduling/failpoint.h"
#include "stiefel/v1/simulation.grpc.pb.h"

namespace stiefel::server {

/// Writes a message to `bytes`; copies of the buffer share its memory.
template <class Message>
void serialize(const Message& message, grpc::ByteBuffer& bytes) {
  failpoint("wire.serialize");
  bytes.Clear();
  bool own = false;
  if (!grpc::SerializationTraits<Message>::Serialize(message, &bytes, &own).ok())
    throw std::bad_alloc();
}

/// The RPCs, each in its own file except for the short ones. The gate (gate.h) calls them with a
/// request that was read and a log that knows who pays, and ends the call where one returns a
/// status or throws. Calls that compute for longer than `inline_nanoseconds` do so on the
/// scheduler's threads.
class Service final {
 public:
  explicit Service(Host& host);

  using Context = grpc::CallbackServerContext;
  using Unary = Begun<grpc::ServerUnaryReactor>;
  template <class Message>
  using Writing = Begun<grpc::ServerWriteReactor<Message>>;

  /// The reply is always the same, and is kept as bytes.
  Unary Describe(Context&, CallLog&, const v1::DescribeRequest&, grpc::ByteBuffer*);
  Unary CreateSession(Context&, CallLog&, const v1::CreateSessionRequest&,
                      v1::CreateSessionResponse*);
  Unary GetSession(Context&, CallLog&, const v1::GetSessionRequest&, v1::GetSessionResponse*);
  /// Sends a v1::ListSessionsResponse as bytes, so that not gRPC's thread frees the message.
  Unary ListSessions(Context&, CallLog&, const v1::ListSessionsRequest&, grpc::ByteBuffer*);
  Unary DeleteSession(Context&, CallLog&, const v1::DeleteSessionRequest&,
                      v1::DeleteSessionResponse*);
  Unary Step(Context&, CallLog&, const v1::StepRequest&, v1::StepResponse*);
  /// Reads its requests one by one.
  Begun<grpc::ServerBidiReactor<ReadRequest<v1::DriveRequest>, v1::DriveResponse>> Drive(Context&,
                                                                                         CallLog&);
  /// Sends v1::StreamResponse messages as bytes, so that a stream that waits for its reader holds a
  /// message only once.
  Writing<grpc::ByteBuffer> Stream(Context&, CallLog&, const v1::StreamRequest&);
  Unary Diagnose(Context&, CallLog&, const v1::DiagnoseRequest&, v1::DiagnoseResponse*);
  Unary ForkSession(Context&, CallLog&, const v1::ForkSessionRequest&, v1::ForkSessionResponse*);
  Writing<v1::ConvertResponse> Convert(Context&, CallLog&, const v1::ConvertRequest&);
  Writing<v1::ConnectResponse> Connect(Context&, CallLog&, const v1::ConnectRequest&);
  Writing<v1::ConjugatePointsResponse> ConjugatePoints(Context&, CallLog&,
                                                       const v1::ConjugatePointsRequest&);
  Writing<v1::MeasureTradeoffResponse> MeasureTradeoff(Context&, CallLog&,
                                                       const v1::MeasureTradeoffRequest&);
  Writing<v1::SummarizeResponse> Summarize(Context&, CallLog&, const v1::SummarizeRequest&);
  Writing<v1::LinearizeResponse> Linearize(Context&, CallLog&, const v1::LinearizeRequest&);
  Writing<v1::LyapunovSpectrumResponse> LyapunovSpectrum(Context&, CallLog&,
                                                         const v1::LyapunovSpectrumRequest&);

 private:
  Host& host_;
  grpc::ByteBuffer description_;  // the reply of Describe
};

}  // namespace stiefel::server
