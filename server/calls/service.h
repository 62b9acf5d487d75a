#pragma once

#include <new>

#include "server/calls/call.h"
#include "server/calls/read_request.h"
#include "stiefel/v1/simulation.grpc.pb.h"

namespace stiefel::server {

/// Writes a message to `bytes`; copies of the buffer share its memory.
template <class Message>
void serialize(const Message& message, grpc::ByteBuffer& bytes) {
  bytes.Clear();
  bool own = false;
  if (!grpc::SerializationTraits<Message>::Serialize(message, &bytes, &own).ok())
    throw std::bad_alloc();
}

/// What a handler gives to gRPC: its reply, or the bytes of its reply. Those of Describe are always
/// the same; of a list of sessions, not gRPC's thread frees the message; and a stream that waits
/// for its reader holds a message only once.
template <class Response>
struct SentAs {
  using Type = Response;
};
template <>
struct SentAs<v1::DescribeResponse> {
  using Type = grpc::ByteBuffer;
};
template <>
struct SentAs<v1::ListSessionsResponse> {
  using Type = grpc::ByteBuffer;
};
template <>
struct SentAs<v1::StreamResponse> {
  using Type = grpc::ByteBuffer;
};
template <class Response>
using Sent = typename SentAs<Response>::Type;

/// The RPCs of simulation.proto, each in its own file except for the short ones. The gate (gate.h)
/// calls them with a request that was read and a log that knows who pays, and ends the call where
/// one returns a status or throws. Calls that compute for longer than `inline_nanoseconds` do so on
/// the scheduler's threads.
class Service final {
 public:
  explicit Service(Host& host);

  using Context = grpc::CallbackServerContext;
  using Unary = Begun<grpc::ServerUnaryReactor>;
  template <class Message>
  using Writing = Begun<grpc::ServerWriteReactor<Message>>;
  /// The handler reads its requests one by one.
  template <class Request, class Response>
  using Driving = Begun<grpc::ServerBidiReactor<ReadRequest<Request>, Response>>;

#define UNARY(Name) \
  Unary Name(Context&, CallLog&, const v1::Name##Request&, Sent<v1::Name##Response>*);
#define STREAM(Name) \
  Writing<Sent<v1::Name##Response>> Name(Context&, CallLog&, const v1::Name##Request&);
#define DUPLEX(Name) Driving<v1::Name##Request, v1::Name##Response> Name(Context&, CallLog&);
#include "stiefel/v1/rpcs.inc"
#undef UNARY
#undef STREAM
#undef DUPLEX

 private:
  Host& host_;
  grpc::ByteBuffer description_;  // the reply of Describe
};

}  // namespace stiefel::server
