// What servers that are killed are compared with: the states of an embedded simulation, and a
// checkpoint.
//
//   replicas_client states FOLDER FROM COUNT         writes scene.json and the states FROM to
//                                                    FROM + COUNT - 1, one after another
//   replicas_client checkpoint ADDRESS FOLDER FROM   asks a server for a checkpoint of state FROM
#include <google/protobuf/util/json_util.h>

#include <fstream>
#include <iostream>

#include "server/convert/convert.h"
#include "stiefel/client/client.h"
#include "stiefel/simulation.h"
#include "tests/server/scene_cases.h"

namespace stiefel::client {
namespace {

void append_state(const Simulation& simulation, std::string& bytes) {
  for (std::size_t i = 0; i < simulation.block_count(); ++i) {
    std::vector<double> values(static_cast<std::size_t>(simulation.fields()[i].size()));
    simulation.write(i, values);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }
}

/// Without negative zeros, which JSON does not keep.
SceneDescription description() {
  SceneDescription scene = test::description();
  for (auto& [name, block] : scene.initial) block.values.array() += 0.0;
  return scene;
}

v1::Scene wire_scene() {
  v1::Scene scene;
  server::to_proto(description(), &scene);
  return scene;
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
}

void write_states(const std::string& folder, std::int64_t from, std::int64_t count) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(wire_scene(), &json, options).ok())
    throw std::runtime_error("the scene is no JSON");
  write(folder + "/scene.json", json);
  std::string states;
  const auto simulation = make_simulation(Scene::resolve(description()).value());
  simulation->advance(from);
  for (std::int64_t i = 0; i < count; ++i, simulation->advance(1))
    append_state(*simulation, states);
  write(folder + "/states", states);
}

/// Asks a server for the checkpoint of a state and writes it.
void write_checkpoint(const std::string& address, const std::string& folder, std::int64_t step) {
  v1::StepRequest request;
  request.set_to(step);
  request.set_return_checkpoint(true);
  const auto session = Client::connect(address).create(wire_scene());
  write(folder + "/checkpoint", session.call(&Stub::Step, request).checkpoint());
}

int main(const std::vector<std::string>& arguments) {
  const auto number = [&](std::size_t i) { return std::stoll(arguments.at(i)); };
  const std::string& mode = arguments.at(1);
  if (mode == "states")
    write_states(arguments.at(2), number(3), number(4));
  else
    write_checkpoint(arguments.at(2), arguments.at(3), number(4));
  return 0;
}

}  // namespace
}  // namespace stiefel::client

int main(int count, char** arguments) {
  try {
    return stiefel::client::main({arguments, arguments + count});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
