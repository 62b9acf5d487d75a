#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/endpoint.h"
#include "client/cli/message_file.h"
#include "client/cli/progress/status_line.h"
#include "client/cli/sinks/destination.h"

namespace stiefel::cli {

namespace {

nlohmann::ordered_json blocks(const v1::ConvertResponse& reply) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const auto& block : reply.blocks())
    out[block.name()] = to_json(client::to_matrix(block.value()));
  return out;
}

}  // namespace

ExitStatus convert(const ConvertCommand& command) {
  v1::ConvertRequest request;
  *request.mutable_scene() = read_scene(command.scene);
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

}  // namespace stiefel::cli
