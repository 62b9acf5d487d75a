#pragma once

#include <google/protobuf/message.h>

#include <memory>
#include <string>
#include <string_view>

/// Functions that all fuzz targets share. Each target reads a message, and fails by aborting.
namespace stiefel::fuzz {

/// An empty message of the type that the target reads; each target defines it.
std::unique_ptr<google::protobuf::Message> input();
/// Runs the target on a message.
void run(const google::protobuf::Message& message);

/// Reads the text form if the first byte is #, the JSON form if it is {, or else the wire format.
/// False when it is none of them.
bool read(std::string_view bytes, google::protobuf::Message* message);
std::string to_json_text(const google::protobuf::Message& message);

/// The wire format, the same for the same message.
std::string to_bytes(const google::protobuf::Message& message);

/// Prints what is wrong, and aborts.
void require(bool holds, const std::string& what);

/// Aborts if a number in the message is NaN, bytes of tensors included.
void require_no_nan(const google::protobuf::Message& message);

}  // namespace stiefel::fuzz
