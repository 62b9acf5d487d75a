#include <iostream>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/input/scene_source.h"
#include "client/cli/options.h"
#include "client/cli/progress/status_line.h"
#include "client/cli/report.h"

namespace stiefel::cli {
namespace {

struct ConjugatePointsCommand {
  std::string file;
  Remote server;
};

ExitStatus conjugate_points(const ConjugatePointsCommand& command) {
  v1::ConjugatePointsRequest request;
  parse_message(command.file, read_source(command.file), &request);
  const Endpoint endpoint(command.server);
  const auto reply = [&] {
    const ElapsedLine line(request.has_radius() ? "looking for the injectivity radius"
                                                : "looking for conjugate points");
    return endpoint.client().conjugate_points(request);
  }();

  const v1::RunStatus& status = reply.run_status();
  nlohmann::ordered_json out = ending(status);
  if (reply.has_radius()) {
    out["radius"] = to_json(reply.radius());
  } else {
    out["until"] = reply.until();
    out["points"] = nlohmann::ordered_json::array();
    for (const auto& point : reply.points()) out["points"].push_back(to_json(point));
  }
  std::cout << to_text(out) << '\n';
  if (status.outcome() == v1::OUTCOME_REACHED) return reached;
  std::cerr << "stiefel: " << to_string(status.outcome()) << ": " << status.message() << '\n';
  return numerical_stop;
}

void add_conjugate_points(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<ConjugatePointsCommand>();
  app->add_option(
         "FILE", command->file,
         "{inertia, Q, Qdot, time}, or {inertia, radius: {n}} for the injectivity radius: "
         "the JSON form of stiefel.v1.ConjugatePointsRequest, in which a frame may also be "
         "a list of its rows; - for stdin")
      ->required()
      ->type_name("FILE.json");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->file, .whole_request = true};
    chosen.run = [command](Origin&) { return conjugate_points(*command); };
  });
}

const Subcommand conjugate_points_command(
    "conjugate-points",
    "Finds the conjugate points along a geodesic, or bounds of the "
    "injectivity radius",
    add_conjugate_points);

}  // namespace

}  // namespace stiefel::cli
