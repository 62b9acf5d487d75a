#include <iostream>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/options.h"
#include "client/cli/progress/status_line.h"
#include "client/cli/sinks/destination.h"

namespace stiefel::cli {

namespace {

struct ConvertCommand {
  SceneSource scene;
  Remote server;
  std::string target;
  std::optional<double> epsilon;
  std::optional<double> parameter;
  std::string output;
};

nlohmann::ordered_json blocks(const v1::ConvertResponse& reply) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const auto& block : reply.blocks())
    out[block.name()] = to_json(client::to_matrix(block.value()));
  return out;
}

ExitStatus convert(const ConvertCommand& command, Origin& origin) {
  v1::ConvertRequest request;
  *request.mutable_scene() = read_scene(command.scene, origin);
  request.set_to(command.target);
  if (command.epsilon) request.set_epsilon(*command.epsilon);
  if (command.parameter) request.set_parameter(*command.parameter);
  const Endpoint endpoint(command.server);
  const auto reply = [&] {
    const ElapsedLine line("converting");
    return endpoint.client().convert(request);
  }();

  nlohmann::ordered_json margins = nlohmann::ordered_json::object();
  for (const auto& margin : reply.margins()) margins[margin.domain()] = margin.margin();
  if (!command.output.empty()) {
    if (!reply.has_scene())
      throw BadInput("--output: " + command.target +
                     " is not a system, so there is no scene to write");
    Destination destination(command.output);
    const File file = open_for_writing(destination.working_path());
    write(file.get(), to_text(to_json(reply.scene())) + "\n");
    flush(file.get());
    destination.commit();
    std::cout << to_text({{"margins", margins}}) << '\n';
    return reached;
  }
  nlohmann::ordered_json out;
  if (reply.has_scene())
    out["scene"] = to_json(reply.scene());
  else
    out["blocks"] = blocks(reply);
  out["margins"] = margins;
  std::cout << to_text(out) << '\n';
  return reached;
}

void add_convert(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<ConvertCommand>();
  add_scene(app, command->scene);
  app->add_option("--to", command->target,
                  "the target: a system, or velocity, angular_velocity, interpolation")
      ->required()
      ->type_name("SYSTEM");
  app->add_option(
      "--epsilon", command->epsilon,
      "epsilon of the symmetric and parametric systems; by default a power of two chosen "
      "from the norm of M");
  app->add_option("--parameter", command->parameter,
                  "mu of the parametric systems; by default the scene's");
  app->add_option("--output", command->output,
                  "file for the converted scene; stdout then has the margins only")
      ->type_name("FILE.json");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {
        .file = command->scene.shown(),
        .options = {{"to", "--to"}, {"epsilon", "--epsilon"}, {"parameter", "--parameter"}}};
    chosen.run = [command](Origin& origin) { return convert(*command, origin); };
  });
}

const Subcommand convert_command("convert", "Prints the same motion as a scene of another system",
                                 add_convert);

}  // namespace

}  // namespace stiefel::cli
