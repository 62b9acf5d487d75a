#pragma once

#include <grpcpp/grpcpp.h>

#include <new>

#include "server/scheduling/failpoint.h"

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

}  // namespace stiefel::server
