#include "client/cli/input/message_file.h"

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
#include "client/cli/input/nested_numbers.h"
#include "client/cli/input/strict_syntax.h"

namespace stiefel::cli {
namespace {

constexpr std::size_t max_bytes = std::size_t{256} << 20;

using google::protobuf::Descriptor;

/// To the parser -0 is the whole number 0, which has no sign.
template <class Json>
void keep_the_sign_of_zero(Json& json) {
  if (json.is_structured())
    for (auto& one : json) keep_the_sign_of_zero(one);
  else if (json.is_number_integer() && !json.is_number_unsigned() && json == 0)
    json = -0.0;
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
                    const google::protobuf::Descriptor* beside,
                    const std::function<void(nlohmann::json&)>& rewrite) {
  Types types;
  for (const auto* message : messages) types.push_back(message->GetDescriptor());
  if (beside != nullptr) types.push_back(beside);
  const std::string plain = without_mark(name, given);
  const Syntax syntax = check_syntax(plain, types);
  if (!syntax.fault.empty()) {
    const bool samples = plain.starts_with("# {") || plain.starts_with("PK\x03\x04");
    throw BadInput(name + ": " + syntax.fault +
                   (samples ? "; a file of samples is for stiefel rerun" : ""));
  }
  std::string text = plain;
  if (syntax.nested || rewrite) {
    auto json = nlohmann::json::parse(plain);
    keep_the_sign_of_zero(json);
    if (rewrite) rewrite(json);
    write_out_numbers(types, name + ": ", json);
    text = json.dump();
  }
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
  keep_the_sign_of_zero(json);
  sort_maps(*message.GetDescriptor(), json);
  write_as_rows(*message.GetDescriptor(), json);
  return json;
}

std::string to_text(const nlohmann::ordered_json& json, std::size_t indent) {
  const bool on_one_line =
      json.is_primitive() || json.empty() || (json.is_array() && json.front().is_primitive());
  if (on_one_line) return json.dump();
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
