#include "client/cli/input/nested_numbers.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "client/cli/exit_status.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

namespace {

/// Appends the numbers of nested lists of one shape.
void flatten(const std::string& place, const nlohmann::json& given, nlohmann::json& values) {
  for (const auto& one : given) {
    if (one.is_array() != given[0].is_array() || (one.is_array() && one.size() != given[0].size()))
      throw BadInput(place + ": must be rows of one length");
    if (one.is_array())
      flatten(place, one, values);
    else
      values.push_back(one);
  }
}

/// Returns a list of numbers as nested lists.
nlohmann::ordered_json nested(const nlohmann::ordered_json& values,
                              std::span<const std::size_t> lengths) {
  std::size_t count = 1, at = 0;
  for (const std::size_t length : lengths) count *= length;
  if (!values.is_array() || values.size() != count) return nlohmann::ordered_json::array();
  const auto lists = [&](const auto& self, std::span<const std::size_t> left) {
    if (left.empty()) return values[at++];
    auto list = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < left[0]; ++i) list.push_back(self(self, left.subspan(1)));
    return list;
  };
  return lists(lists, lengths);
}

std::span<const std::int64_t> integers(const v1::Tensor& array) {
  return {reinterpret_cast<const std::int64_t*>(array.data().data()),
          array.data().size() / sizeof(std::int64_t)};
}

}  // namespace

nlohmann::json flat(const std::string& place, const nlohmann::json& nested) {
  auto values = nlohmann::json::array();
  flatten(place, nested, values);
  return values;
}

nlohmann::json matrix_of(const std::string& place, const nlohmann::json& given) {
  if (given.is_object()) {
    const bool of_rows = given.contains("values") && given["values"].is_array() &&
                         !given["values"].empty() && given["values"][0].is_array();
    if (!of_rows) return given;
    auto matrix = matrix_of(place + ".values", given["values"]);
    if (given.contains("imaginary"))
      matrix["imaginary"] = flat(place + ".imaginary", given["imaginary"]);
    return matrix;
  }
  auto values = flat(place, given);
  const auto* row = &given;
  while (!row->empty() && row->front().is_array()) row = &row->front();
  const std::size_t cols = row->size(), rows = cols == 0 ? 1 : values.size() / cols;
  return {{"rows", rows}, {"cols", cols}, {"values", std::move(values)}};
}

void write_out_numbers(const Types& types, const std::string& path, nlohmann::json& object) {
  for (auto& [name, value] : object.items()) {
    const FieldDescriptor* field = find_field(types, name);
    const std::string place = path + name;
    if (field->message_type() == nullptr) {
      if (std::ranges::any_of(value, [](const auto& one) { return one.is_array(); }))
        value = flat(place, value);
      continue;
    }
    const FieldDescriptor* of = field->is_map() ? field->message_type()->map_value() : field;
    const auto write_out = [&](const std::string& at, nlohmann::json& one) {
      if (!one.is_structured() || of->message_type() == nullptr) return;
      if (of->message_type() == v1::Matrix::descriptor())
        one = matrix_of(at, one);
      else if (one.is_object())
        write_out_numbers({of->message_type()}, at + ".", one);
    };
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

nlohmann::ordered_json nested_matrix(const nlohmann::ordered_json& matrix,
                                     std::span<const std::size_t> lengths) {
  const auto list = [&](const char* name) {
    return nested(matrix.value(name, nlohmann::ordered_json::array()), lengths);
  };
  if (!matrix.contains("imaginary")) return list("values");
  return {{"values", list("values")}, {"imaginary", list("imaginary")}};
}

nlohmann::ordered_json as_lists(const v1::Tensor& array, std::span<const std::size_t> lengths,
                                std::size_t first) {
  std::size_t count = 1;
  for (const std::size_t length : lengths) count *= length;
  const std::size_t parts = array.data_type() == v1::DATA_TYPE_COMPLEX128 ? 2 : 1;
  const auto part = [&](const auto& numbers, std::size_t at) {
    auto list = nlohmann::ordered_json::array();
    for (const auto x : numbers.subspan(parts * first, parts * count))
      if (at++ % parts == 0) list.push_back(x);
    return list;
  };
  if (array.data_type() == v1::DATA_TYPE_FLOAT32)
    return nested(part(client::floats(array), 0), lengths);
  if (array.data_type() == v1::DATA_TYPE_INT64) return nested(part(integers(array), 0), lengths);
  const auto values = client::values(array);
  if (parts == 1) return nested(part(values, 0), lengths);
  return {{"values", nested(part(values, 0), lengths)},
          {"imaginary", nested(part(values, 1), lengths)}};
}

nlohmann::ordered_json as_lists(const v1::Tensor& array) {
  const std::vector<std::size_t> lengths(array.shape().begin(), array.shape().end());
  return as_lists(array, lengths);
}

void write_as_rows(const Descriptor& type, nlohmann::ordered_json& json) {
  if (&type == v1::Matrix::descriptor()) {
    const std::size_t lengths[] = {json.value("rows", std::size_t{0}),
                                   json.value("cols", std::size_t{0})};
    // A matrix whose numbers do not fill it, or an empty one, has no rows to write.
    const auto fills = [&](const char* name) {
      const auto numbers = json.find(name);
      return numbers != json.end() && numbers->size() == lengths[0] * lengths[1];
    };
    if (lengths[0] > 0 && lengths[1] > 0 && fills("values") &&
        (!json.contains("imaginary") || fills("imaginary")))
      json = nested_matrix(json, lengths);
    return;
  }
  for (int i = 0; i < type.field_count(); ++i) {
    const auto* field = type.field(i);
    const auto found = json.find(field->name());
    if (found == json.end() || field->message_type() == nullptr) continue;
    const auto* of = field->is_map() ? field->message_type()->map_value()->message_type()
                                     : field->message_type();
    if (of == nullptr) continue;
    if (field->is_repeated())
      for (auto& one : *found) write_as_rows(*of, one);
    else
      write_as_rows(*of, *found);
  }
}

}  // namespace stiefel::cli
