#include "client/cli/input/strict_syntax.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>
#include <set>
#include <string_view>
#include <utility>

#include "engine/scene/near_name.h"
#include "stiefel/v1/scene.pb.h"

namespace stiefel::cli {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

std::string name_of(const FieldDescriptor* field) {
  return field->has_json_name() ? field->json_name() : field->name();
}

const FieldDescriptor* find_field(const Types& types, const std::string& name) {
  for (const Descriptor* type : types) {
    for (int i = 0; i < type->field_count(); ++i) {
      const FieldDescriptor* field = type->field(i);
      if (field->name() == name || field->json_name() == name) return field;
    }
  }
  return nullptr;
}

namespace {

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

/// What acts on a body elsewhere, and what an unknown field of such a name is answered.
constexpr std::array<std::string_view, 8> loads = {"torque", "torques", "external_torque",  "force",
                                                   "forces", "gravity", "gravity_gradient", "drag"};
constexpr std::string_view no_loads =
    "there are no torques and no forces: the motion is free (docs/conventions.md)";

constexpr std::size_t max_depth = 16;
constexpr std::size_t longest_shown = 60;

enum class Kind { null, truth, number, text };

/// Whether a text may stand for the object that has it as its name.
bool is_method(const FieldDescriptor* field) {
  return field->message_type() == v1::Method::descriptor();
}

/// Whether protobuf takes a text as a number, as JSON has no other form for these.
bool is_number(const std::string& text) {
  if (text == "NaN" || text == "Infinity" || text == "-Infinity") return true;
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  return error == std::errc() && end == text.data() + text.size();
}

/// Returns what one value of a field must be.
std::string rule_of(const FieldDescriptor* field) {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return (is_method(field) ? "a name, or an object with the fields "
                               : "an object with the fields ") +
             fields_of(field->message_type());
    case FieldDescriptor::CPPTYPE_DOUBLE:
    case FieldDescriptor::CPPTYPE_FLOAT:
      return "a number";
    case FieldDescriptor::CPPTYPE_BOOL:
      return "true or false";
    case FieldDescriptor::CPPTYPE_STRING:
      return "a text";
    case FieldDescriptor::CPPTYPE_ENUM:
      return "one of " + listed(std::views::iota(0, field->enum_type()->value_count()),
                                [&](int i) { return field->enum_type()->value(i)->name(); });
    default:
      return "a whole number of at least 0";
  }
}

/// Whether a field takes one value of a kind. `text`: the value of a text, `number`: of a number.
bool takes(const FieldDescriptor* field, Kind kind, const std::string& text, double number) {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return kind == Kind::text && is_method(field);
    case FieldDescriptor::CPPTYPE_DOUBLE:
    case FieldDescriptor::CPPTYPE_FLOAT:
      return kind == Kind::number || (kind == Kind::text && is_number(text));
    case FieldDescriptor::CPPTYPE_BOOL:
      return kind == Kind::truth;
    case FieldDescriptor::CPPTYPE_STRING:
      return kind == Kind::text;
    case FieldDescriptor::CPPTYPE_ENUM:
      return kind == Kind::number ||
             (kind == Kind::text && field->enum_type()->FindValueByName(text) != nullptr);
    default:
      return (kind == Kind::number && number >= 0 && number == std::floor(number)) ||
             (kind == Kind::text && is_number(text));
  }
}

/// Whether a list of numbers may have an inner list for each member, each row or each axis.
bool may_be_nested(const FieldDescriptor* field) {
  const Descriptor* of = field->containing_type();
  return field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE &&
         (of == v1::Matrix::descriptor() || of == v1::Scene::descriptor() ||
          of == v1::Body::descriptor() || of->file()->name() == beside_file);
}

class StrictSyntax : public nlohmann::json_sax<nlohmann::json> {
 public:
  /// `types`: the messages whose fields the whole object may have.
  explicit StrictSyntax(Types types) : types_(std::move(types)) {}

  Syntax found;

  bool null() override { return value(Kind::null, "null"); }
  bool boolean(bool x) override { return value(Kind::truth, x ? "true" : "false"); }
  bool number_integer(number_integer_t x) override {
    return number(static_cast<double>(x), std::to_string(x));
  }
  bool number_unsigned(number_unsigned_t x) override {
    return number(static_cast<double>(x), std::to_string(x));
  }
  bool number_float(number_float_t x, const string_t& digits) override { return number(x, digits); }
  bool string(string_t& text) override { return value(Kind::text, '"' + text + '"', text); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return enter(false); }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override { return enter(true); }
  bool end_array() override { return leave(); }
  bool key(string_t& name) override {
    Level& here = levels_.back();
    here.at = name;
    if (!here.names.insert(name).second) return refuse("", "given twice");
    if (here.map != nullptr) {
      here.next = here.map->message_type()->map_value();
    } else if (!here.types.empty()) {
      here.next = find_field(here.types, name);
      if (here.next == nullptr)
        return refuse("", "unknown field" + (std::ranges::find(loads, name) != loads.end()
                                                 ? "; " + std::string(no_loads)
                                                 : near_field(here.types, name)));
    }
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& e) override {
    const std::string what =
        e.what();  // "[json.exception.parse_error.101] parse error at line ..."
    found.fault = what.substr(what.find("] ") + 2);
    return false;
  }

 private:
  enum class Place { object, list, numbers };

  /// An open object or array. A level whose fault was left to protobuf has no types, map or next.
  struct Level {
    Types types = {};                       ///< the messages that an object may be
    const FieldDescriptor* map = nullptr;   ///< the field of an object that is a map
    const FieldDescriptor* next = nullptr;  ///< the field to which the next value belongs
    Place place = Place::object;
    int deeper = 0;         ///< how many lists may stand inside each other in a list of numbers
    std::size_t index = 0;  ///< the index of an array's next element
    std::string at;         ///< the last name read in an object
    std::set<std::string> names = {};
  };

  bool number(double x, const std::string& digits) { return value(Kind::number, digits, {}, x); }

  /// `shown`: the value as errors show it.
  bool value(Kind kind, const std::string& shown, const std::string& text = {}, double x = 0) {
    if (levels_.empty()) return refuse(shown, "must be an object: {...}");
    const Level& here = levels_.back();
    if (here.place == Place::numbers) {
      if (kind != Kind::number) return refuse(shown, "must be a number");
    } else if (const FieldDescriptor* field = here.next; field != nullptr) {
      // null means absent, but it is no element of a list.
      const bool in_list = here.place == Place::list;
      if (kind == Kind::null && !in_list) return done();
      if (field->is_map()) return refuse(shown, "must be an object of names and values");
      if (field->is_repeated() && !in_list) return refuse(shown, "must be a list: [...]");
      if (!takes(field, kind, text, x)) return refuse(shown, "must be " + rule_of(field));
    }
    return done();
  }
  bool done() {
    if (!levels_.empty()) ++levels_.back().index;
    return true;
  }
  bool enter(bool array) {
    const std::string shown = array ? "a list" : "an object";
    Level inner;
    if (array) inner.place = Place::list;
    if (levels_.empty()) {
      if (array) return refuse(shown, "must be an object: {...}");
      inner.types = types_;
    } else if (const Level& here = levels_.back(); here.place == Place::numbers) {
      if (!array || here.deeper == 0)
        return refuse(shown, here.deeper == 2 ? "must be a row of numbers" : "must be a number");
      inner.place = Place::numbers;
      inner.deeper = here.deeper - 1;
    } else if (const FieldDescriptor* field = here.next) {
      const bool one = !field->is_map() && field->is_repeated() == (here.place == Place::list);
      const bool matrix = one && field->message_type() == v1::Matrix::descriptor();
      if (array && matrix) {
        inner.place = Place::numbers;
        inner.deeper = 2;  // rows, or the rows of each member
        found.nested = true;
      } else if (array && one && field->is_repeated() && may_be_nested(field)) {
        inner.place = Place::numbers;
        inner.deeper = 1;
        found.nested = true;
      } else if (one && (array || field->message_type() == nullptr)) {
        return refuse(shown, "must be " + rule_of(field));
      } else if (array && field->is_map()) {
        return refuse(shown, "must be an object of names and values");
      } else if (!array && !one && !field->is_map()) {
        return refuse(shown, "must be a list: [...]");
      } else if (array) {
        inner.next = field;
      } else if (field->is_map()) {
        inner.map = field;
      } else {
        for (const Descriptor* type : here.types)
          if (const FieldDescriptor* same = find_field({type}, here.at))
            if (same->message_type() != nullptr) inner.types.push_back(same->message_type());
        if (inner.types.empty()) inner.types = {field->message_type()};  // of a list or a map
      }
    }
    levels_.push_back(std::move(inner));
    if (levels_.size() <= max_depth) return true;
    found.fault = "nested deeper than " + std::to_string(max_depth) + " levels";
    return false;
  }
  bool leave() {
    levels_.pop_back();
    return done();
  }
  /// Sets the fault to the path of the last name, such as "forms[0].first.Q", the value and the
  /// rule, and returns false, which ends the parse.
  bool refuse(const std::string& shown, const std::string& rule) {
    std::string& fault = found.fault;
    for (const Level& level : levels_)
      if (level.place != Place::object)
        fault.append("[").append(std::to_string(level.index)).append("]");
      else
        fault += (fault.empty() ? "" : ".") + level.at;
    if (!shown.empty())
      fault += (fault.empty() ? "" : ": ") + shown.substr(0, longest_shown) +
               (shown.size() > longest_shown ? "..." : "");
    fault += (fault.empty() ? "" : ": ") + rule;
    return false;
  }

  Types types_;
  std::vector<Level> levels_;
};

}  // namespace

Syntax check_syntax(const std::string& text, const Types& types) {
  StrictSyntax syntax(types);
  nlohmann::json::sax_parse(text, &syntax);
  return std::move(syntax.found);
}

}  // namespace stiefel::cli
