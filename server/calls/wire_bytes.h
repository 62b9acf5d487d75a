#pragma once

#include <grpcpp/grpcpp.h>

#include <new>

#include "server/limits/failpoint.h"

namespace stiefel::server {

/// The message that the bytes are; false where they are none.
template <class Message>
bool parse(grpc::ByteBuffer bytes, Message& message) {
  failpoint("wire.parse");
  return grpc::SerializationTraits<Message>::Deserialize(&bytes, &message).ok();
}

/// The bytes of a message, which copies of the buffer share.
template <class Message>
void serialize(const Message& message, grpc::ByteBuffer& bytes) {
  failpoint("wire.serialize");
  bytes.Clear();
  bool own = false;
  if (!grpc::SerializationTraits<Message>::Serialize(message, &bytes, &own).ok())
    throw std::bad_alloc();
}

}  // namespace stiefel::server
