#pragma once

#include <grpcpp/support/sync_stream.h>

#include "server/calls/server_call.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::server {

inline constexpr const char* service_name = "stiefel.v1.SimulationService";

/// What a call with many replies sends: bytes, so that it holds a reply only once while it waits
/// for its reader.
using Writer = grpc::ServerWriter<grpc::ByteBuffer>;
using ReaderWriter = grpc::ServerReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>;
/// A handler: `Out` is the reply, or a Writer.
template <class Request, class Out>
using Handler = void(ServerCall&, const Request&, Out);

/// Returns the reply of Describe.
v1::DescribeResponse description(const Host& host);

// The RPCs of simulation.proto, each in its own file. Gate (gate.h) calls one on a thread of its
// own, with a request that was read, and ends the call with the status of what it throws.
#define UNARY(Name) Handler<v1::Name##Request, v1::Name##Response*> Name;
#define STREAM(Name) Handler<v1::Name##Request, Writer&> Name;
#define DUPLEX(Name) void Name(ServerCall&, ReaderWriter&);
#include "stiefel/v1/rpcs.inc"
#undef UNARY
#undef STREAM
#undef DUPLEX

}  // namespace stiefel::server
