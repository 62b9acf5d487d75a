#include "client/cli/message_file.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "client/cli/exit_status.h"
#include "client/cli/input/strict_syntax.h"

namespace stiefel::cli {
namespace {

constexpr std::size_t max_bytes = std::size_t{256} << 20;

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

/// Returns the object of a matrix given as rows, or as the numbers of a single row.
nlohmann::json matrix_of(const std::string& place, const nlohmann::json& given) {
  const bool of_rows =
      std::ranges::any_of(given, [](const nlohmann::json& one) { return one.is_array(); });
  const nlohmann::json rows = of_rows ? given : nlohmann::json::array({given});
  nlohmann::json values = nlohmann::json::array();
  for (const auto& row : rows) {
    if (!row.is_array() || row.size() != rows[0].size())
      throw BadInput(place + ": must be rows of one length");
    values.insert(values.end(), row.begin(), row.end());
  }
  return {{"rows", rows.size()}, {"cols", rows[0].size()}, {"values", std::move(values)}};
}

/// Writes matrices that are given as rows, such as [[1, 0], [0, 1]] or [1, 0, 0], as objects with
/// rows, cols and values. Throws BadInput with the path of a matrix whose rows differ in length.
void write_out_matrices(const Types& types, const std::string& path, nlohmann::json& object) {
  for (auto& [name, value] : object.items()) {
    const FieldDescriptor* field = find_field(types, name);
    if (field->message_type() == nullptr) continue;
    const FieldDescriptor* of = field->is_map() ? field->message_type()->map_value() : field;
    const auto write_out = [&](const std::string& place, nlohmann::json& one) {
      if (one.is_array() && of->message_type() == v1::Matrix::descriptor())
        one = matrix_of(place, one);
      else if (one.is_object() && of->message_type() != nullptr)
        write_out_matrices({of->message_type()}, place + ".", one);
    };
    const std::string place = path + name;
    if (field->is_map()) {
      for (auto& [key, one] : value.items()) write_out(place + "." + key, one);
    } else if (field->is_repeated()) {
      for (std::size_t i = 0; i < value.size(); ++i)
        write_out(place + "[" + std::to_string(i) + "]", value[i]);
    } else {
      write_out(place, value);
    }
  }
}

/// Sorts the entries of maps by key; protobuf prints them in an order that changes from run to run.
void sort_maps(const Descriptor& type, nlohmann::ordered_json& json) {
  for (int i = 0; i < type.field_count(); ++i) {
    const auto* field = type.field(i);
    const auto found = json.find(field->name());
    if (found == json.end()) continue;
    if (field->is_map()) {
      std::map<std::string, nlohmann::ordered_json> sorted;
      for (auto& [name, value] : found->items()) sorted[name] = value;
      *found = nlohmann::ordered_json::object();
      for (auto& [name, value] : sorted) (*found)[name] = std::move(value);
    } else if (field->message_type() != nullptr && found->is_array()) {
      for (auto& element : *found) sort_maps(*field->message_type(), element);
    } else if (field->message_type() != nullptr && found->is_object()) {
      sort_maps(*field->message_type(), *found);
    }
  }
}

std::string with_matrices_as_objects(const std::string& name, const std::string& text,
                                     const Types& types) {
  auto json = nlohmann::json::parse(text);
  write_out_matrices(types, name + ": ", json);
  return json.dump();
}

}  // namespace

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  char block[1 << 16];
  while (file.read(block, sizeof block), file.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > max_bytes) throw BadInput(path + ": larger than 256 MiB");
  }
  if (!file.eof()) throw BadInput(path + ": " + std::strerror(errno));
  return text;
}

std::string without_mark(const std::string& name, const std::string& text) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    throw BadInput(name + ": is UTF-16: must be UTF-8");
  return text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text;
}

void read_message(const std::string& path, google::protobuf::Message* message) {
  parse_message(path, read_text(path), message);
}

void parse_message(const std::string& name, const std::string& text,
                   google::protobuf::Message* message) {
  parse_messages(name, text, {message});
}

void parse_messages(const std::string& name, const std::string& given,
                    const std::vector<google::protobuf::Message*>& messages,
                    const google::protobuf::Descriptor* beside) {
  Types types;
  for (const auto* message : messages) types.push_back(message->GetDescriptor());
  if (beside != nullptr) types.push_back(beside);
  const std::string plain = without_mark(name, given);
  const Syntax syntax = check_syntax(plain, types);
  if (!syntax.fault.empty()) throw BadInput(name + ": " + syntax.fault);
  const std::string text =
      syntax.nested_matrices ? with_matrices_as_objects(name, plain, types) : plain;
  google::protobuf::util::JsonParseOptions options;
  // Fields of the other messages are ignored here; `syntax` has checked that all names are known.
  options.ignore_unknown_fields = types.size() > 1;
  for (auto* message : messages) {
    const auto status = google::protobuf::util::JsonStringToMessage(text, message, options);
    if (status.ok()) continue;
    std::string fault(status.message());
    if (fault.starts_with(": ")) fault = fault.substr(2);  // protobuf's empty path: the root
    throw BadInput(name + ": " + fault);
  }
}

nlohmann::ordered_json to_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  if (!status.ok()) throw std::runtime_error(std::string(status.message()));
  auto json = nlohmann::ordered_json::parse(text);
  sort_maps(*message.GetDescriptor(), json);
  return json;
}

std::string to_text(const nlohmann::ordered_json& json, std::size_t indent) {
  const bool flat =
      json.is_primitive() || json.empty() || (json.is_array() && json.front().is_primitive());
  if (flat) return json.dump();
  std::string margin(indent + 3, ' ');
  margin[0] = '\n';
  std::string text(1, json.is_array() ? '[' : '{');
  for (const auto& [name, value] : json.items()) {
    if (text.size() > 1) text += ",";
    text += margin;
    if (json.is_object()) text += nlohmann::json(name).dump() + ": ";
    text += to_text(value, indent + 2);
  }
  return text + margin.substr(0, indent + 1) + (json.is_array() ? ']' : '}');
}

}  // namespace stiefel::cli
