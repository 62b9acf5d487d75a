#pragma once

#include <google/protobuf/descriptor.h>

#include <cstdint>
#include <span>

namespace stiefel::server {

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

}  // namespace stiefel::server
