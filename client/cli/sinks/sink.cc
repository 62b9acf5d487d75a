#include "client/cli/sinks/sink.h"

#include <filesystem>
#include <map>

#include "client/cli/exit_status.h"
#include "engine/numbers/to_text.h"

namespace stiefel::cli {

std::unique_ptr<Sink> make_sink(const std::string& path) {
  if (path.empty()) return make_json_sink(path);
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".json") return make_json_sink(path);
  if (extension == ".csv") return make_csv_sink(path);
  if (extension == ".npz") return make_npz_sink(path);
  throw BadInput("--output: " + path + " must end in .json, .csv or .npz");
}

const FieldKind& kind_of(std::string_view field) {
  static const std::map<std::string_view, FieldKind> kinds = {
      {"quaternion", {1, {"q_w", "q_x", "q_y", "q_z"}, "1"}},
      {"angular_velocity", {1, {"omega_x", "omega_y", "omega_z"}, "rad/s"}},
      {"angular_velocity_space",
       {1, {"omega_space_x", "omega_space_y", "omega_space_z"}, "rad/s"}},
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

void append_number(std::string& text, double number) {
  const std::string written = stiefel::to_text(number);
  text += written;
  if (written.find_first_of(".en") == std::string::npos) text += ".0";
}

}  // namespace stiefel::cli
