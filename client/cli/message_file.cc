#include "client/cli/message_file.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>
#include <set>
#include <stdexcept>
#include <vector>

#include "client/cli/exit_status.h"
#include "engine/simulation/scene/near_name.h"

namespace stiefel::cli {
namespace {

constexpr std::size_t max_bytes = std::size_t{256} << 20;
constexpr std::size_t max_depth = 16;

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

/// Returns the name of a field in files: the proto's json_name if it has one, else the field's
/// name.
std::string name_of(const FieldDescriptor* field) {
  return field->has_json_name() ? field->json_name() : field->name();
}

using Types = std::vector<const Descriptor*>;

/// Returns the field with a name or a lowerCamelCase name, which protobuf reads too; null if the
/// messages do not have it.
const FieldDescriptor* find_field(const Types& types, const std::string& name) {
  for (const Descriptor* type : types) {
    for (int i = 0; i < type->field_count(); ++i) {
      const FieldDescriptor* field = type->field(i);
      if (field->name() == name || field->json_name() == name) return field;
    }
  }
  return nullptr;
}

/// Returns a suggestion such as "; did you mean body.inertia_tensor?", a field of the messages or
/// of a message inside them; empty if no name is near.
std::string near_field(const Types& types, const std::string& name) {
  // Field name to path. A field of `types` comes before a field of the same name inside them.
  std::map<std::string, std::string> paths;
  const auto add = [&](const Descriptor* type, const std::string& parent) {
    for (int i = 0; i < type->field_count(); ++i)
      paths.try_emplace(name_of(type->field(i)), parent + name_of(type->field(i)));
  };
  for (const Descriptor* type : types) add(type, "");
  for (const Descriptor* type : types)
    for (int i = 0; i < type->field_count(); ++i) {
      const FieldDescriptor* field = type->field(i);
      if (field->message_type() != nullptr && !field->is_repeated())
        add(field->message_type(), name_of(field) + ".");
    }
  const auto near = near_name(name, paths | std::views::keys);
  return near ? "; did you mean " + paths.at(*near) + "?" : "";
}

/// Returns the names of a message's fields: "rows, cols, values".
std::string fields_of(const Descriptor* type) {
  return listed(std::views::iota(0, type->field_count()),
                [&](int i) { return name_of(type->field(i)); });
}

/// Finds faults that protobuf's parser accepts or reports without their place: syntax errors,
/// unknown names, names given twice (protobuf would join the two arrays), and an array in place of
/// a message, such as a matrix given as rows. Other wrong types are left to protobuf.
class StrictSyntax : public nlohmann::json_sax<nlohmann::json> {
 public:
  /// `types`: the messages whose fields the whole object may have.
  explicit StrictSyntax(Types types) : types_(std::move(types)) {}

  std::string fault;  ///< the first fault; empty if there is none

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return enter(false); }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override { return enter(true); }
  bool end_array() override { return leave(); }
  bool key(string_t& name) override {
    Level& here = levels_.back();
    here.at = name;
    if (!here.names.insert(name).second) return refuse("given twice");
    if (here.map != nullptr) {
      here.next = here.map->message_type()->map_value();
    } else if (!here.types.empty()) {
      here.next = find_field(here.types, name);
      if (here.next == nullptr) return refuse("unknown field" + near_field(here.types, name));
    }
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& e) override {
    const std::string what =
        e.what();  // "[json.exception.parse_error.101] parse error at line ..."
    fault = what.substr(what.find("] ") + 2);
    return false;
  }

 private:
  /// An open object or array. A level without types, map and next stands where protobuf expects
  /// something else, and is left to protobuf.
  struct Level {
    Types types = {};                       ///< the messages that an object may be
    const FieldDescriptor* map = nullptr;   ///< the field of an object that is a map
    const FieldDescriptor* next = nullptr;  ///< the field to which the next value belongs
    bool array = false;
    std::size_t index = 0;  ///< the index of an array's next element
    std::string at;         ///< the last name read in an object
    std::set<std::string> names = {};
  };

  bool value() {
    if (!levels_.empty()) ++levels_.back().index;
    return true;
  }
  bool enter(bool array) {
    Level inner;
    inner.array = array;
    if (levels_.empty()) {
      if (!array) inner.types = types_;
    } else if (const FieldDescriptor* field = levels_.back().next) {
      const bool element = levels_.back().array;
      const bool one =
          field->message_type() != nullptr && !field->is_map() && field->is_repeated() == element;
      if (array && one)
        return refuse("must be an object with the fields " + fields_of(field->message_type()));
      if (array)
        inner.next = field->is_repeated() && !field->is_map() && !element ? field : nullptr;
      else if (field->is_map())
        inner.map = field;
      else if (one)
        inner.types = {field->message_type()};
    }
    levels_.push_back(std::move(inner));
    if (levels_.size() <= max_depth) return true;
    fault = "nested deeper than " + std::to_string(max_depth) + " levels";
    return false;
  }
  bool leave() {
    levels_.pop_back();
    return value();
  }
  /// Sets `fault` to the rule at the path of the last name, such as "forms[0].first.Q", and returns
  /// false, which ends the parse.
  bool refuse(const std::string& rule) {
    for (const Level& level : levels_)
      if (level.array)
        fault.append("[").append(std::to_string(level.index)).append("]");
      else
        fault += (fault.empty() ? "" : ".") + level.at;
    fault += ": " + rule;
    return false;
  }

  Types types_;
  std::vector<Level> levels_;
};

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

std::string read(const std::string& path) {
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

}  // namespace

void read_message(const std::string& path, google::protobuf::Message* message) {
  parse_message(path, read(path), message);
}

void read_messages(const std::string& path,
                   const std::vector<google::protobuf::Message*>& messages) {
  parse_messages(path, read(path), messages);
}

void parse_message(const std::string& name, const std::string& text,
                   google::protobuf::Message* message) {
  parse_messages(name, text, {message});
}

void parse_messages(const std::string& name, const std::string& text,
                    const std::vector<google::protobuf::Message*>& messages) {
  Types types;
  for (const auto* message : messages) types.push_back(message->GetDescriptor());
  StrictSyntax syntax(types);
  if (!nlohmann::json::sax_parse(text, &syntax)) throw BadInput(name + ": " + syntax.fault);
  google::protobuf::util::JsonParseOptions options;
  // Fields of the other messages are ignored here; `syntax` has checked that all names are known.
  options.ignore_unknown_fields = messages.size() > 1;
  for (auto* message : messages) {
    const auto status = google::protobuf::util::JsonStringToMessage(text, message, options);
    if (status.ok()) continue;
    std::string fault(status.message());
    if (fault.starts_with(": ")) fault = fault.substr(2);  // protobuf's empty path: the root
    throw BadInput(name + ": " + fault);
  }
}

v1::Scene read_scene(const std::string& path) {
  v1::Scene scene;
  read_message(path, &scene);
  return scene;
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
