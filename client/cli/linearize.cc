#include <optional>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/input/nested_numbers.h"
#include "client/cli/options.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/destination.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {
namespace {

struct LinearizeCommand {
  SceneSource scene;
  Remote server;
  std::int64_t from = 0;
  std::int64_t every = 0;
  bool inertia = false, step = false;
  /// A file with `vectors`, as in stiefel.v1.LinearizeRequest.
  std::string request;
  std::string output;
};

v1::LinearizeRequest request_of(const LinearizeCommand& command) {
  v1::LinearizeRequest request;
  if (!command.request.empty()) {
    read_message(command.request, &request);
    std::vector<const google::protobuf::FieldDescriptor*> given;
    request.GetReflection()->ListFields(request, &given);
    for (const auto* field : given)
      if (field->name() != "vectors")
        throw BadInput(command.request + ": " + field->name() +
                       ": must be absent; the file has `vectors` alone");
  }
  request.set_from(command.from);
  request.set_every(command.every);
  request.set_inertia(command.inertia);
  request.set_step(command.step);
  request.set_bases(request.vectors().shape_size() != 3);
  return request;
}

ExitStatus linearize(const LinearizeCommand& command, Origin& origin) {
  const v1::Scene scene = read_scene(command.scene, origin);
  v1::LinearizeRequest request = request_of(command);
  request.set_to(last_step(command.scene, scene));
  std::optional<Destination> destination;
  if (!command.output.empty()) destination.emplace(command.output);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  const auto end = with_progress(session, request.to(), [&](Progress& progress) {
    return session.linearize(request, [&](const v1::LinearizeResponse& result) {
      progress.at(result.step());
      nlohmann::ordered_json one = {{"step", result.step()}, {"time", result.time()}};
      for (const auto& field : result.fields()) one[field.name()] = as_lists(field.value());
      results.push_back(std::move(one));
      return true;
    });
  });
  nlohmann::ordered_json out = ending(end.run_status());
  out["results"] = std::move(results);
  const std::string text = to_text(out) + "\n";
  write_whole(destination, text);
  return conclude(end.run_status(), end.step());
}

}  // namespace

void add_linearize(CLI::App& all, Command& chosen) {
  const auto command = std::make_shared<LinearizeCommand>();
  auto* app = all.add_subcommand(
      "linearize", "Prints the derivative of the computed steps: the state transition matrix");
  add_run_of_scene(app, command->scene);
  app->add_option("--from", command->from, "the step at which the vectors start; 0 by default")
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
  app->add_option("--every", command->every,
                  "a result every K steps too; by default at the last step alone")
      ->transform(whole_number())
      ->type_name("K");
  app->add_flag("--inertia", command->inertia, "adds the derivatives by lambda_1 ... lambda_N");
  app->add_flag("--by-step", command->step, "adds the derivative by the step");
  app->add_option("--request", command->request,
                  "file with `vectors`, which are moved instead of a basis: the JSON form of "
                  "stiefel.v1.LinearizeRequest")
      ->type_name("FILE.json");
  app->add_option("--output", command->output, "a .json file; stdout by default")
      ->type_name("FILE.json");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->scene.shown(),
                     .options = {{"from", "--from"},
                                 {"to", command->scene.time ? "--time" : "--to"},
                                 {"every", "--every"},
                                 {"inertia", "--inertia"},
                                 {"step", "--by-step"},
                                 {"vectors", "--request: vectors"}}};
    chosen.run = [command](Origin& origin) { return linearize(*command, origin); };
  });
}

}  // namespace stiefel::cli
