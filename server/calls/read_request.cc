#include "server/calls/read_request.h"

#include <google/protobuf/io/coded_stream.h>
#include <grpcpp/support/slice.h>
#include <malloc.h>

#include <algorithm>
#include <new>
#include <string>
#include <unordered_map>
#include <vector>

namespace stiefel::server {
namespace {

using MessageType = google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::io::CodedInputStream;

enum WireType { varint, fixed64, length_delimited, group_begin, group_end, fixed32 };

/// Bytes, with the unused half of a list that grows by doubling.
constexpr std::uint64_t of_element = 32;   // of a list of pointers, or of numbers given one by one
constexpr std::uint64_t of_string = 64;    // without its characters
constexpr std::uint64_t of_entry = 128;    // of a map, without its value
constexpr std::uint64_t of_unknown = 96;   // a field of a later version
constexpr std::uint64_t small_list = 256;  // a packed list that may be one of many for its field

/// The bytes of a call in gRPC, and those up to which a request is never refused.
constexpr std::uint64_t request_object = 4 << 10, never_refused = 64 << 10;
/// The bytes up to which a request keeps fields of later versions, which cost less than a search
/// for them.
constexpr std::size_t keeps_unknown = 4 << 10;
/// The bytes above which the memory of the pieces of a request goes back to the system at once.
constexpr std::size_t large = 4 << 20;

/// Returns the bytes of an empty message.
std::uint64_t object_bytes(const MessageType& type) {
  thread_local std::unordered_map<const MessageType*, std::uint64_t> known;
  auto [at, is_new] = known.try_emplace(&type, 0);
  if (is_new)
    at->second =
        google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type)->SpaceUsedLong();
  return at->second;
}

/// Returns the bytes of a list of numbers packed into `length` bytes.
std::uint64_t packed_bytes(const FieldDescriptor& field, std::uint64_t length) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
    case FieldDescriptor::CPPTYPE_FLOAT:
      return length + 2 * std::min(length, small_list);
    default:  // of numbers that take one byte each
      return length * of_element;
  }
}

class Walk {
 public:
  explicit Walk(std::span<const char> bytes)
      : in_(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size())) {}

  /// Counts a message of that type up to the limit. Returns false where the bytes are none.
  bool message(const MessageType& type) {
    int groups = 0;  // inside fields of a later version
    while (const std::uint32_t tag = in_.ReadTag()) {
      const FieldDescriptor* field =
          groups > 0 ? nullptr : type.FindFieldByNumber(static_cast<int>(tag >> 3));
      const auto wire_type = static_cast<WireType>(tag & 7);
      if (wire_type == group_begin) {
        ++groups;
        count_unknown(0);
      } else if (wire_type == group_end) {
        if (--groups < 0) return false;
      } else if (wire_type == length_delimited ? !delimited(field) : !number(wire_type, field)) {
        return false;
      }
    }
    return in_.ConsumedEntireMessage();
  }
  const ParsedBytes& found() const { return found_; }

 private:
  void count(std::uint64_t bytes) { found_.memory += bytes; }
  void count_unknown(std::uint64_t bytes) {
    found_.unknown += of_unknown;
    count(of_unknown + bytes);
  }
  bool number(WireType type, const FieldDescriptor* field) {
    if (field == nullptr)
      count_unknown(0);
    else if (field->is_repeated())
      count(of_element);
    std::uint64_t ignored;
    if (type == varint) return in_.ReadVarint64(&ignored);
    return (type == fixed64 || type == fixed32) && in_.Skip(type == fixed64 ? 8 : 4);
  }

  bool delimited(const FieldDescriptor* field) {
    std::uint32_t length = 0;
    if (!in_.ReadVarint32(&length)) return false;
    if (field == nullptr) {
      count_unknown(length);
    } else if (const MessageType* type = field->message_type()) {
      return submessage(*field, *type, length);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      found_.strings += of_string + length;
      count(of_string + length + (field->is_repeated() ? of_element : 0));
    } else {
      count(packed_bytes(*field, length));
    }
    return in_.Skip(static_cast<int>(length));
  }

  bool submessage(const FieldDescriptor& field, const MessageType& type, std::uint32_t length) {
    if (field.is_map()) {
      const MessageType* value = type.map_value()->message_type();
      count(of_entry + (value ? object_bytes(*value) : 0));
    } else {
      count(object_bytes(type) + (field.is_repeated() ? of_element : 0));
    }
    const auto outer = in_.PushLimit(static_cast<int>(length));
    const bool good = message(type);
    in_.PopLimit(outer);
    return good;
  }

  CodedInputStream in_;
  ParsedBytes found_;
};

/// Joins the pieces in which bytes arrived and frees each as it is copied. From many pieces,
/// protobuf would read a packed field of numbers into twice its size. A ByteBuffer frees every
/// piece: where gRPC's memory quota is used up, ~Slice of gRPC 1.51 uses a null pointer.
std::string joined(grpc::ByteBuffer& bytes) {
  std::vector<grpc::ByteBuffer> pieces;
  std::string all;
  all.reserve(bytes.Length());
  {
    std::vector<grpc::Slice> slices;
    if (!bytes.Dump(&slices).ok()) throw std::bad_alloc();
    for (const grpc::Slice& slice : slices) pieces.emplace_back(&slice, std::size_t{1});
  }
  bytes.Clear();
  for (grpc::ByteBuffer& piece : pieces) {
    grpc::Slice slice;
    if (!piece.TrySingleSlice(&slice).ok()) throw std::bad_alloc();
    all.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    slice = {};
    piece.Clear();
  }
  if (all.size() > large) malloc_trim(0);
  return all;
}

}  // namespace

ParsedBytes parsed_bytes(std::span<const char> bytes, const google::protobuf::Descriptor& type) {
  Walk walk(bytes);
  walk.message(type);
  ParsedBytes found = walk.found();
  found.memory += object_bytes(type);
  return found;
}

const ReadRequest::Message* ReadRequest::read(grpc::ByteBuffer& bytes, const Message& prototype,
                                              MemoryBudget& budget) {
  struct Freed {
    grpc::ByteBuffer& bytes;
    ~Freed() { bytes.Clear(); }
  } const freed{bytes};
  drop();
  const std::size_t size = bytes.Length();
  const std::uint64_t itself = size > never_refused ? size : 0;
  if (itself > 0) hold(budget, itself);
  grpc::Slice only;
  std::string copy;
  const bool is_one = bytes.TrySingleSlice(&only).ok();
  if (!is_one) copy = joined(bytes);
  const char* begin = is_one ? reinterpret_cast<const char*>(only.begin()) : copy.data();
  const ParsedBytes found = parsed_bytes({begin, size}, *prototype.GetDescriptor());
  hold(budget, request_object + itself + found.memory);
  Message* message = prototype.New(&arena_.emplace());
  if (!message->ParseFromArray(begin, static_cast<int>(size))) return nullptr;
  if (found.unknown > 0 && size > keeps_unknown) message->DiscardUnknownFields();
  const std::uint64_t used =
      request_object + arena_->SpaceAllocated() + found.strings + found.unknown;
  if (memory_.bytes() > used) memory_.shrink(memory_.bytes() - used);
  return message;
}

void ReadRequest::hold(MemoryBudget& budget, std::uint64_t bytes) {
  if (memory_)
    memory_.grow_to(bytes);
  else if (bytes <= never_refused)
    memory_ = MemoryLease::if_it_fits(budget, bytes);
  else
    memory_ = MemoryLease(budget, bytes);
}

}  // namespace stiefel::server
