#pragma once

#include <google/protobuf/message.h>

#include <nlohmann/json.hpp>
#include <string>

#include "stiefel/v1/scene.pb.h"

namespace stiefel::cli {

/// Reads a message in its JSON form. Throws BadInput that names the file and what is wrong in it:
/// syntax with line and column, unknown fields, fields given twice, wrong types.
void read_message(const std::string& path, google::protobuf::Message* message);
/// The same of a text that is there already; `name` is what an error calls it.
void parse_message(const std::string& name, const std::string& text,
                   google::protobuf::Message* message);
v1::Scene read_scene(const std::string& path);

/// The JSON form with the proto's field names, maps in the order of their names; doubles read back
/// the same.
nlohmann::ordered_json to_json(const google::protobuf::Message& message);

/// Indented, but for arrays of numbers, which stay on one line.
std::string to_text(const nlohmann::ordered_json& json, std::size_t indent = 0);

}  // namespace stiefel::cli
