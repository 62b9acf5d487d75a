#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace stiefel::cli {

/// That of UTF-8, with which editors of other systems begin a file.
inline constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

/// Reads a message from a file in JSON form. Throws BadInput that names the file and the fault:
/// syntax with line and column, unknown fields, fields given twice, wrong types.
void read_message(const std::string& path, google::protobuf::Message* message);
/// Reads a message from a text in JSON form. Throws BadInput that calls the text `name`.
void parse_message(const std::string& name, const std::string& text,
                   google::protobuf::Message* message);
/// Reads one JSON object from a text into several messages, whose fields it may have. It may also
/// have the fields of `beside`, which are checked and not read. `rewrite` gets the object before
/// the messages do. Throws BadInput that calls the text `name`.
void parse_messages(const std::string& name, const std::string& text,
                    const std::vector<google::protobuf::Message*>& messages,
                    const google::protobuf::Descriptor* beside = nullptr,
                    const std::function<void(nlohmann::json&)>& rewrite = nullptr);
/// Reads the text of a file. Throws BadInput.
std::string read_text(const std::string& path);
/// Returns the text without a byte order mark of UTF-8. Throws BadInput for UTF-16, which begins
/// with another.
std::string without_mark(const std::string& name, const std::string& text);

/// Returns the JSON form of a message with the proto's field names, in which matrices are lists of
/// their rows. Maps are sorted by key; doubles read back to the same bits.
nlohmann::ordered_json to_json(const google::protobuf::Message& message);

/// Returns indented JSON text; arrays of numbers stay on one line.
std::string to_text(const nlohmann::ordered_json& json, std::size_t indent = 0);

}  // namespace stiefel::cli
