#pragma once

#include <grpcpp/grpcpp.h>
#include <malloc.h>

#include <cstdint>
#include <exception>
#include <vector>

#include "server/limits/failpoint.h"
#include "server/limits/memory_budget.h"

namespace stiefel::server {

/// A request as it arrived. gRPC's callback API itself ends a call whose bytes are not a message of
/// the right type, with UNIMPLEMENTED and unseen by the service. A request of this type reaches the
/// service instead, which refuses, logs and counts it.
///
/// gRPC keeps the request, and hands it out as a constant, until the call has ended: so does the
/// lease of its memory.
template <class Message>
struct ReadRequest {
  mutable Message message;
  bool is_message = false;
  std::exception_ptr failure;  ///< the exception that ended the reading
  mutable MemoryLease memory;

  /// Counts the bytes of the message as it was parsed. Throws MemoryExhausted; a small request is
  /// never refused, so that a caller beyond the limits can still delete its sessions.
  void hold(MemoryBudget& budget) const {
    const std::uint64_t bytes = message.SpaceUsedLong() + request_object;
    memory = bytes <= never_refused ? MemoryLease::if_it_fits(budget, bytes)
                                    : MemoryLease(budget, bytes);
  }
  /// Frees the message of a call that is refused.
  void drop() const { message = Message(); }

  /// The bytes of a call in gRPC, and those up to which a request is never refused.
  static constexpr std::uint64_t request_object = 4 << 10, never_refused = 64 << 10;
};

/// The bytes above which the memory of a request's pieces goes back to the system before parsing.
constexpr std::size_t large_request = 4 << 20;
/// The bytes up to which a request keeps fields of later versions, which cost less than a search
/// for them.
constexpr std::size_t keeps_unknown = 4 << 10;

/// Drops the fields that this version does not know from a message of `size` bytes.
template <class Message>
void discard_unknown(Message& message, std::size_t size) {
  if (size <= keeps_unknown) return;
  message.DiscardUnknownFields();
  if (message.ByteSizeLong() > size / 2) return;
  // The message still has room for what was discarded; a copy has none.
  Message tight(message);
  message.Swap(&tight);
}

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
    if (!message.ParseFromArray(begin, static_cast<int>(size))) return false;
    discard_unknown(message, size);
    return true;
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
