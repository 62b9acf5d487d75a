#pragma once

#include <grpcpp/grpcpp.h>

namespace stiefel::server {

/// A request as it came. gRPC's callback API ends a call whose bytes are no such message by itself,
/// with UNIMPLEMENTED and without telling anybody; one of this type reaches the service, which
/// refuses, logs and counts it.
template <class Message>
struct ReadRequest {
  Message message;
  bool is_message = false;
};

}  // namespace stiefel::server

template <class Message>
class grpc::SerializationTraits<stiefel::server::ReadRequest<Message>> {
 public:
  static Status Deserialize(ByteBuffer* bytes, stiefel::server::ReadRequest<Message>* request) {
    request->is_message = SerializationTraits<Message>::Deserialize(bytes, &request->message).ok();
    return Status::OK;
  }
};
