#pragma once

#include <google/protobuf/arena.h>
#include <google/protobuf/descriptor.h>
#include <grpcpp/grpcpp.h>
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "server/scheduling/memory_budget.h"

namespace stiefel::server {

/// The most bytes of a request that is read on the thread that received it: a message of that size
/// takes less than 50 µs, whatever it consists of. A longer one is read by a worker.
inline constexpr std::size_t inline_request = 2 << 10;
/// The predicted work of reading a request, in instructions a byte.
inline constexpr double work_of_a_byte = 50;

/// What a message takes when it is parsed.
struct ParsedBytes {
  std::uint64_t memory = 0;   ///< a bound on all of it
  std::uint64_t strings = 0;  ///< the part of strings, which protobuf keeps outside an arena
  bool unknown = false;       ///< whether there are fields of a later version
};

/// Returns what a message of that type takes when it is parsed from the bytes, without parsing it.
/// Two bytes of an empty submessage become an object of 100 bytes, so that a request may take fifty
/// times its size. Returns what was counted so far where the bytes are not such a message.
ParsedBytes parsed_bytes(std::span<const char> bytes, const google::protobuf::Descriptor& type);

/// Joins the pieces in which bytes arrived and empties them; frees each piece as it is copied.
/// From many pieces, protobuf would read a packed field of numbers into twice its size.
///
/// A ByteBuffer frees every piece. Where gRPC's memory quota is used up, ~Slice of gRPC 1.51 uses a
/// null pointer if it frees one on a thread that is not gRPC's.
class JoinedBytes {
 public:
  /// The bytes above which the memory of the pieces goes back to the system at once.
  static constexpr std::size_t large = 4 << 20;

  explicit JoinedBytes(grpc::ByteBuffer& bytes) {
    const std::size_t size = bytes.Length();
    if (bytes.TrySingleSlice(&only_).ok()) {
      owner_.Swap(&bytes);
      return;
    }
    std::vector<grpc::ByteBuffer> pieces = pieces_of(bytes);
    bytes.Clear();
    whole_.reserve(size);
    for (grpc::ByteBuffer& piece : pieces) {
      append(piece);
      piece.Clear();
    }
    if (size > large) malloc_trim(0);
  }

  std::span<const char> all() const {
    if (!owner_.Valid()) return whole_;
    return {reinterpret_cast<const char*>(only_.begin()), only_.size()};
  }

 private:
  static std::vector<grpc::ByteBuffer> pieces_of(const grpc::ByteBuffer& bytes) {
    std::vector<grpc::Slice> slices;
    std::vector<grpc::ByteBuffer> pieces;
    if (!bytes.Dump(&slices).ok()) return pieces;
    pieces.reserve(slices.size());
    for (const grpc::Slice& slice : slices) pieces.emplace_back(&slice, std::size_t{1});
    return pieces;
  }
  void append(const grpc::ByteBuffer& piece) {
    grpc::Slice slice;
    if (piece.TrySingleSlice(&slice).ok()) whole_.insert(whole_.end(), slice.begin(), slice.end());
  }

  grpc::ByteBuffer owner_;  // of `only_`, which goes before it
  grpc::Slice only_;
  std::vector<char> whole_;
};

/// A request as it arrived, which `read` makes a message. gRPC itself would read it
/// before anybody knows who pays for its memory, on its own thread, and end a call whose bytes are
/// not a message of the right type with UNIMPLEMENTED, unseen by the service.
///
/// gRPC keeps the request, and hands it out as a constant, until the call has ended: so does the
/// lease of its memory.
template <class Message>
class ReadRequest {
 public:
  void take(grpc::ByteBuffer& bytes) {
    drop();
    bytes_.Swap(&bytes);
  }
  /// Returns the bytes that are not read yet.
  std::size_t size() const { return bytes_.Length(); }

  /// Reads the message; returns false if the bytes are none. Its memory comes from the budget,
  /// before it is allocated. Throws MemoryExhausted; a small request is never refused, so that a
  /// caller beyond the limits can still delete its sessions.
  bool read(MemoryBudget& budget) const {
    try {
      if (parse(budget)) return true;
    } catch (...) {
      drop();
      throw;
    }
    drop();
    return false;
  }
  /// The message that was read.
  const Message& message() const { return *message_; }
  /// Frees the bytes and the message.
  void drop() const {
    bytes_.Clear();
    message_ = nullptr;
    arena_.reset();
    memory_ = {};
  }

 private:
  /// The bytes of a call in gRPC, and those up to which a request is never refused.
  static constexpr std::uint64_t request_object = 4 << 10, never_refused = 64 << 10;
  /// The bytes up to which a request keeps fields of later versions, which cost less than a search
  /// for them.
  static constexpr std::size_t keeps_unknown = 4 << 10;

  bool parse(MemoryBudget& budget) const {
    const std::size_t size = bytes_.Length();
    const bool large = size > never_refused;
    if (large) hold(budget, size);
    const JoinedBytes joined(bytes_);
    const auto bytes = joined.all();
    const ParsedBytes found = parsed_bytes(bytes, *Message::descriptor());
    hold(budget, request_object + (large ? size : 0) + found.memory);
    message_ = new_message(size);
    if (!message_->ParseFromArray(bytes.data(), static_cast<int>(size))) return false;
    if (found.unknown) discard_unknown(size);
    const std::uint64_t used = request_object + arena_->SpaceAllocated() + found.strings;
    if (memory_.bytes() > used) memory_.shrink(memory_.bytes() - used);
    return true;
  }

  void hold(MemoryBudget& budget, std::uint64_t bytes) const {
    if (memory_)
      memory_.grow_to(bytes);
    else if (bytes <= never_refused)
      memory_ = MemoryLease::if_it_fits(budget, bytes);
    else
      memory_ = MemoryLease(budget, bytes);
  }

  /// Makes an arena for a message read from `size` bytes. An arena of many small objects is freed
  /// at once.
  Message* new_message(std::size_t size) const {
    google::protobuf::ArenaOptions options;
    options.max_block_size = size > never_refused ? 256 << 10 : 8 << 10;
    arena_ = std::make_unique<google::protobuf::Arena>(options);
    return google::protobuf::Arena::CreateMessage<Message>(arena_.get());
  }

  /// Drops the fields that this version does not know from the message, read from `size` bytes.
  void discard_unknown(std::size_t size) const {
    if (size <= keeps_unknown) return;
    message_->DiscardUnknownFields();
    const std::size_t known = message_->ByteSizeLong();
    if (known > size / 2) return;
    // The arena still holds what was discarded; that of a copy does not.
    const auto whole = std::exchange(arena_, nullptr);
    const Message& read = *message_;
    message_ = new_message(known);
    *message_ = read;
  }

  mutable grpc::ByteBuffer bytes_;
  mutable std::unique_ptr<google::protobuf::Arena> arena_;
  mutable Message* message_ = nullptr;  // in the arena
  mutable MemoryLease memory_;
};

}  // namespace stiefel::server

template <class Message>
class grpc::SerializationTraits<stiefel::server::ReadRequest<Message>> {
 public:
  static Status Deserialize(ByteBuffer* bytes, stiefel::server::ReadRequest<Message>* request) {
    request->take(*bytes);
    return Status::OK;
  }
};
