#include "client/cli/sinks/description.h"

#include <map>

#include "client/cli/input/message_file.h"

namespace stiefel::cli {

const FieldKind& kind_of(std::string_view field) {
  static const std::map<std::string_view, FieldKind> kinds = {
      {"quaternion", {1, {"q_w", "q_x", "q_y", "q_z"}, "1"}},
      {"angular_velocity", {1, {"omega_x", "omega_y", "omega_z"}, "rad/s"}},
      {"angular_velocity_space", {1, {"omega_space_x", "omega_space_y", "omega_space_z"}, "rad/s"}},
      {"momentum_space",
       {1, {"momentum_space_x", "momentum_space_y", "momentum_space_z"}, "kg m^2/s"}},
      {"q", {1, {}, ""}},
      {"qdot", {1, {}, ""}},
      {"p", {1, {}, ""}},
      {"epsilon", {0, {}, ""}},
      {"Q", {2, {}, "1"}},
      {"M", {2, {}, "kg m^2/s"}},
      {"Omega", {2, {}, "rad/s"}}};
  static const FieldKind matrix;
  const auto found = kinds.find(field);
  return found == kinds.end() ? matrix : found->second;
}

std::vector<std::size_t> named_shape(std::string_view field, std::vector<std::size_t> shape,
                                     int behind) {
  const auto axes = static_cast<std::ptrdiff_t>(kind_of(field).axes);
  const auto cols = shape.end() - behind;
  if (axes < 2) shape.erase(cols - 2, cols - axes);
  return shape;
}

std::vector<std::size_t> sample_shape(const v1::Field& field) {
  const auto& shape = field.value().shape();
  return named_shape(field.name(), {shape.begin() + 1, shape.end()});
}

std::string numpy_type(v1::DataType type) {
  if (type == v1::DATA_TYPE_COMPLEX128) return "<c16";
  return type == v1::DATA_TYPE_FLOAT32 ? "<f4" : "<f8";
}

Description::Description(const client::Session& session, nlohmann::ordered_json run,
                         const std::string& epoch)
    : scene_(to_json(session.scene())),
      run_(std::move(run)),
      numerics_id_(session.description().numerics_id()),
      in_si_(session.scene().has_body()) {
  if (!epoch.empty()) scene_["epoch"] = epoch;
}

void Description::take(const v1::StreamResponse& batch) {
  if (!fields_.empty()) return;
  for (const v1::Field& field : batch.fields())
    fields_[field.name()] = {{"shape", sample_shape(field)},
                             {"dtype", numpy_type(field.value().data_type())}};
}

std::string Description::unit_of(std::string_view name) const {
  if (name == "time") return "s";
  return std::string(in_si_ ? kind_of(name).unit : "");
}

nlohmann::ordered_json Description::json() const {
  nlohmann::ordered_json run = run_, units = {{"time", "s"}};
  run["fields"] = nlohmann::ordered_json::array();
  for (const auto& [name, field] : fields_.items()) {
    run["fields"].push_back(name);
    if (const std::string unit = unit_of(name); !unit.empty()) units[name] = unit;
  }
  return {
      {"format", trajectory_format}, {"numerics_id", numerics_id_}, {"scene", scene_},
      {"run", std::move(run)},       {"fields", fields_},           {"units", std::move(units)}};
}

}  // namespace stiefel::cli
