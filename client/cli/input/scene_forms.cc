#include "client/cli/input/scene_forms.h"

#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <array>
#include <vector>

#include "client/cli/exit_status.h"
#include "client/cli/input/body_forms.h"
#include "client/cli/input/nested_numbers.h"
#include "client/cli/input/strict_syntax.h"

namespace stiefel::cli {
namespace {

using Json = nlohmann::json;

/// The block that says how a frame on V(n, N) moves, by system.
const std::map<std::string, std::string> frames = {
    {"stiefel", "S"}, {"stiefel_costate", "P"}, {"stiefel_momentum", "M"}};
constexpr std::array bodies = {"rigid_body",         "symmetric_rigid_body",
                               "reduced_rigid_body", "mclachlan_scovel",
                               "right_rigid_body",   "right_symmetric_rigid_body"};

std::string system_of(const Json& scene) {
  const auto system = scene.find("system");
  return system != scene.end() && system->is_string() ? system->get<std::string>() : "";
}

Blocks blocks_of(const std::string& place, const Json& initial, std::size_t members) {
  Blocks blocks;
  for (const auto& [name, given] : initial.items())
    if (auto block = stacked(place + "." + name, given, members)) blocks[name] = *std::move(block);
  return blocks;
}

Json rows_of(const std::vector<RowMatrix>& members) {
  Json rows = Json::array();
  for (const RowMatrix& block : members)
    for (const auto& row : block.rowwise())
      rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

/// Returns M = ΛΩ + ΩΛ, or what stands for Q̇.
RowMatrix momentum(const std::string& system, const std::string& given, const RowMatrix& velocity,
                   const RowMatrix* Q, const Eigen::VectorXd& lambda) {
  const auto Lambda = lambda.asDiagonal();
  if (const auto frame = frames.find(system); frame != frames.end()) {
    const RowMatrix S = velocity * Lambda;
    return frame->second == "M" ? RowMatrix(Q->transpose() * S - S.transpose() * *Q) : S;
  }
  RowMatrix Omega = velocity;
  if (given == "Qdot")
    Omega = system.starts_with("right_") ? RowMatrix(velocity * Q->transpose())
                                         : RowMatrix(Q->transpose() * velocity);
  return Lambda * Omega + Omega * Lambda;
}

/// Replaces Omega or Qdot by the system's own block. Returns the names of the two.
std::map<std::string, std::string> write_out_velocity(const std::string& name, Json& scene,
                                                      std::size_t members) {
  Json& initial = scene["initial"];
  const std::string given = initial.contains("Omega") ? "Omega" : "Qdot";
  const std::string place = name + ": initial." + given, system = system_of(scene);
  const bool is_body = std::ranges::find(bodies, system) != bodies.end();
  if (!initial.contains(given) || initial[given].is_null()) return {};
  if (!is_body && (given == "Omega" || !frames.contains(system)))
    throw BadInput(place + ": must be absent: " + system + " takes " +
                   (frames.contains(system) ? "Qdot" : "neither Omega nor Qdot"));
  for (const char* other : {"Qdot", "M", "P", "S", "B"})
    if (other != given && initial.contains(other))
      throw BadInput(place + ": must be absent where " + other + " is given");
  const auto velocity = stacked(place, initial[given], members);
  const auto Q =
      initial.contains("Q") ? stacked(name + ": initial.Q", initial["Q"], members) : std::nullopt;
  if (!velocity) throw BadInput(place + ": must be a matrix of numbers");
  const auto rows = velocity->front().rows(), cols = velocity->front().cols();
  const auto lambda = numbers_of(name + ": inertia", scene.value("inertia", Json::array()));
  const bool own = lambda.size() == members * static_cast<std::size_t>(cols);
  if (!own && lambda.size() != static_cast<std::size_t>(cols))
    throw BadInput(
        place + ": is " + std::to_string(rows) + " x " + std::to_string(cols) +
        ": must have as many columns as inertia has numbers, " + std::to_string(lambda.size()) +
        (cols < rows && rows == static_cast<Eigen::Index>(lambda.size()) ? "; it looks transposed"
                                                                         : ""));
  if (given == "Qdot" && (!Q || Q->front().rows() != rows || Q->front().cols() != cols))
    throw BadInput(place + ": must have the shape of Q");
  std::vector<RowMatrix> made;
  for (std::size_t b = 0; b < members; ++b)
    made.push_back(momentum(system, given, (*velocity)[b], Q ? &(*Q)[b] : nullptr,
                            Eigen::Map<const Eigen::VectorXd>(
                                &lambda[own ? b * static_cast<std::size_t>(cols) : 0], cols)));
  const std::string block = is_body ? "M" : frames.at(system);
  initial.erase(given);
  initial[block] = rows_of(made);
  return {{"initial." + block, "initial." + given}};
}

google::protobuf::FieldDescriptorProto* add(google::protobuf::DescriptorProto* message,
                                            const char* name,
                                            google::protobuf::FieldDescriptorProto::Type type,
                                            bool list = false) {
  auto* field = message->add_field();
  field->set_name(name);
  field->set_json_name(name);
  field->set_number(message->field_size());
  field->set_type(type);
  field->set_label(list ? google::protobuf::FieldDescriptorProto::LABEL_REPEATED
                        : google::protobuf::FieldDescriptorProto::LABEL_OPTIONAL);
  return field;
}

}  // namespace

const google::protobuf::Descriptor* beside_the_scene() {
  static google::protobuf::DescriptorPool pool;
  static const google::protobuf::Descriptor* const type = [] {
    using Field = google::protobuf::FieldDescriptorProto;
    google::protobuf::FileDescriptorProto file;
    file.set_name(beside_file);
    file.set_syntax("proto3");
    auto* scene = file.add_message_type();
    scene->set_name("BesideTheScene");
    add(scene, "epoch", Field::TYPE_STRING);
    add(scene, "normalize", Field::TYPE_BOOL);
    add(scene, "body", Field::TYPE_MESSAGE)->set_type_name("BesideTheBody");
    auto* body = file.add_message_type();
    body->set_name("BesideTheBody");
    add(body, "order", Field::TYPE_STRING);
    add(body, "frame", Field::TYPE_STRING);
    add(body, "mrp", Field::TYPE_DOUBLE, true);
    add(body, "angular_momentum", Field::TYPE_DOUBLE, true);
    return pool.BuildFile(file)->message_type(0);
  }();
  return type;
}

void write_out_method(Json& scene) {
  if (const auto method = scene.find("method"); method != scene.end() && method->is_string())
    *method = {{"name", Json(*method)}};
}

std::map<std::string, std::string> write_out_forms(const std::string& name, Json& scene) {
  write_out_method(scene);
  const bool normalize = scene.contains("normalize") && scene["normalize"] == true;
  scene.erase("normalize");
  std::size_t members = 1;
  if (scene.contains("members") && scene["members"].is_number() && scene["members"] >= 1)
    members = static_cast<std::size_t>(scene["members"].get<double>());
  if (scene.contains("body") && scene["body"].is_object())
    write_out_body(name + ": body.", scene["body"], normalize);
  std::map<std::string, std::string> renamed;
  if (scene.contains("initial") && scene["initial"].is_object()) {
    renamed = write_out_velocity(name, scene, members);
    const std::string system = system_of(scene);
    if (normalize && system != "double_bracket" && !system.starts_with("parametric_")) {
      Blocks blocks = blocks_of(name + ": initial", scene["initial"], members);
      make_fit(name + ": initial.", system,
               numbers_of(name + ": inertia", scene.value("inertia", Json::array())), blocks);
      for (const auto& [block, values] : blocks) scene["initial"][block] = rows_of(values);
    }
  }
  return renamed;
}

}  // namespace stiefel::cli
