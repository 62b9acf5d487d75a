#pragma once

#include <google/protobuf/message.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stiefel/v1/scene.pb.h"

namespace stiefel::cli {

/// Reads a message in its JSON form. Throws BadInput that names the file and what is wrong in it:
/// syntax with line and column, unknown fields, fields given twice, wrong types.
void read_message(const std::string& path, google::protobuf::Message* message);
/// Reads an object whose fields are those of several messages into all of them. Throws BadInput as
/// `read_message` does.
void read_messages(const std::string& path,
                   const std::vector<google::protobuf::Message*>& messages);
/// Reads a message from a text; `name` is what an error calls it.
void parse_message(const std::string& name, const std::string& text,
                   google::protobuf::Message* message);
/// Reads an object whose fields are those of several messages into all of them.
void parse_messages(const std::string& name, const std::string& text,
                    const std::vector<google::protobuf::Message*>& messages);
v1::Scene read_scene(const std::string& path);

/// The JSON form with the proto's field names, maps in the order of their names; doubles read back
/// the same.
nlohmann::ordered_json to_json(const google::protobuf::Message& message);

/// Indented, but for arrays of numbers, which stay on one line.
std::string to_text(const nlohmann::ordered_json& json, std::size_t indent = 0);

}  // namespace stiefel::cli
