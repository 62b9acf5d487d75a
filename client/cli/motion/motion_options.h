#pragma once

#include <map>
#include <memory>
#include <string>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/options.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/destination.h"

namespace stiefel::cli {

/// What a command has that prints one JSON object about the steps --from to --to of a scene.
struct MotionCommand {
  SceneSource scene;
  Remote server;
  std::int64_t from = 0;
  std::string output;
};

/// Adds SCENE, --set, --to, --time and --from, whose help is `from`.
void add_motion(CLI::App* app, MotionCommand& command, const char* from);
void add_output(CLI::App* app, MotionCommand& command);

/// Adds --output and the server, and makes `run` what the command line chooses. `options`: the
/// options of the request's other fields.
template <class C>
void add_end(CLI::App* app, Command& chosen, std::shared_ptr<C> command,
             std::map<std::string, std::string> options,
             ExitStatus (*run)(const C& command, Origin& origin)) {
  add_output(app, *command);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->scene.shown(), .options = options};
    chosen.origin.options.emplace("from", "--from");
    chosen.origin.options.emplace("to", command->scene.time ? "--time" : "--to");
    chosen.run = [=](Origin& origin) { return run(*command, origin); };
  });
}

/// Prints the answer to a request for the steps of a motion. `ask(session, request, progress)`
/// makes the call and returns its last message `end`; `tell(json, end)` adds to how the motion
/// ended.
template <class Request, class Ask, class Tell>
ExitStatus answer(const MotionCommand& command, Origin& origin, Request request, const Ask& ask,
                  const Tell& tell) {
  const v1::Scene scene = read_scene(command.scene, origin);
  request.set_from(command.from);
  request.set_to(last_step(command.scene, scene));
  std::optional<Destination> destination;
  if (!command.output.empty()) destination.emplace(command.output);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  const auto end = with_progress(
      session, request.to(), [&](Progress& progress) { return ask(session, request, progress); });
  nlohmann::ordered_json json = ending(end.run_status());
  tell(json, end);
  write_whole(destination, to_text(json) + "\n");
  return conclude(end.run_status(), end.step());
}

}  // namespace stiefel::cli
