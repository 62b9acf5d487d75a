#pragma once

#include <new>

#include "server/calls/server_call.h"
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

/// What a handler gives to gRPC: its reply, or the bytes of its reply. A stream gives bytes so that
/// it holds a message only once while it waits for its reader.
template <class Response>
struct SentAs {
  using Type = Response;
};
template <>
struct SentAs<v1::StreamResponse> {
  using Type = grpc::ByteBuffer;
};
template <class Request, class Response>
using Unary = void(ServerCall&, const Request&, Response*);
template <class Request, class Response>
using Streaming = void(ServerCall&, const Request&, grpc::ServerWriter<Response>&);
template <class Response>
using Driving = void(ServerCall&, grpc::ServerReaderWriter<Response, grpc::ByteBuffer>&);

/// Returns the reply of Describe.
v1::DescribeResponse description(const Host& host);

// The RPCs of simulation.proto, each in its own file. Gate (gate.h) calls one on a thread of its
// own, with a request that was read, and ends the call with the status of what it throws.
#define UNARY(Name) Unary<v1::Name##Request, SentAs<v1::Name##Response>::Type> Name;
#define STREAM(Name) Streaming<v1::Name##Request, SentAs<v1::Name##Response>::Type> Name;
#define DUPLEX(Name) Driving<v1::Name##Response> Name;
#include "stiefel/v1/rpcs.inc"
#undef UNARY
#undef STREAM
#undef DUPLEX

}  // namespace stiefel::server
