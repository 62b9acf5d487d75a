#pragma once

#include <grpcpp/grpcpp.h>
#include <malloc.h>

#include <exception>
#include <vector>

#include "server/limits/failpoint.h"

namespace stiefel::server {

/// A request as it arrived. gRPC's callback API itself ends a call whose bytes are not a message of
/// the right type, with UNIMPLEMENTED and unseen by the service. A request of this type reaches the
/// service instead, which refuses, logs and counts it.
template <class Message>
struct ReadRequest {
  Message message;
  bool is_message = false;
  std::exception_ptr failure;  ///< the exception that ended the reading
};

/// The bytes above which the memory of a request's pieces goes back to the system before parsing.
constexpr std::size_t large_request = 4 << 20;

/// Reads a message from `bytes` and empties them: joins the pieces in which they arrived and frees
/// each as it is copied. From many pieces, protobuf would read a packed field of numbers into twice
/// its size.
template <class Message>
bool parse_joined(grpc::ByteBuffer& bytes, Message& message) {
  std::vector<grpc::Slice> pieces;
  const bool dumped = bytes.Dump(&pieces).ok();
  const std::size_t size = bytes.Length();
  bytes.Clear();
  if (!dumped) return false;
  const auto parse = [&](const auto* begin) {
    return message.ParseFromArray(begin, static_cast<int>(size));
  };
  if (pieces.size() == 1) return parse(pieces.front().begin());
  std::vector<char> whole;
  whole.reserve(size);
  for (grpc::Slice& piece : pieces) {
    whole.insert(whole.end(), piece.begin(), piece.end());
    piece = grpc::Slice();
  }
  if (whole.size() > large_request) malloc_trim(0);
  return parse(whole.data());
}

}  // namespace stiefel::server

template <class Message>
class grpc::SerializationTraits<stiefel::server::ReadRequest<Message>> {
 public:
  static Status Deserialize(ByteBuffer* bytes, stiefel::server::ReadRequest<Message>* request) {
    try {
      stiefel::server::failpoint("request.read");
      request->is_message = stiefel::server::parse_joined(*bytes, request->message);
    } catch (...) {
      request->failure = std::current_exception();
    }
    bytes->Clear();  // gRPC releases the buffer without freeing it
    return Status::OK;
  }
};
