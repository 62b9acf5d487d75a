#pragma once

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

#include <cstdint>
#include <optional>
#include <span>

#include "server/scheduling/memory_budget.h"

namespace stiefel::server {

/// What a message takes when it is parsed.
struct ParsedBytes {
  std::uint64_t memory = 0;   ///< a bound on all of it
  std::uint64_t strings = 0;  ///< the part of strings, which protobuf keeps outside an arena
  std::uint64_t unknown = 0;  ///< that of fields of a later version, without their contents
};

/// Returns what a message of that type takes when it is parsed from the bytes, without parsing it.
/// Two bytes of an empty submessage become an object of 100 bytes, so that a request may take fifty
/// times its size. Returns what was counted so far where the bytes are not such a message.
ParsedBytes parsed_bytes(std::span<const char> bytes, const google::protobuf::Descriptor& type);

/// A request that was read. gRPC itself would read it before anybody knows who pays for its memory,
/// and end a call whose bytes are not a message of the right type with UNIMPLEMENTED, unseen by the
/// service.
class ReadRequest {
 public:
  using Message = google::protobuf::Message;

  /// Reads a message of the type of `prototype` from the bytes, which are freed. Returns null if
  /// they are no such message. Its memory comes from the budget, before it is allocated. Throws
  /// MemoryExhausted; a small request is never refused, so that a caller beyond the limits can
  /// still delete its sessions.
  const Message* read(grpc::ByteBuffer& bytes, const Message& prototype, MemoryBudget& budget);
  /// Frees the message.
  void drop() {
    arena_.reset();
    memory_ = {};
  }

 private:
  void hold(MemoryBudget& budget, std::uint64_t bytes);

  std::optional<google::protobuf::Arena> arena_;
  MemoryLease memory_;
};

}  // namespace stiefel::server
