#include <filesystem>
#include <fstream>
#include <iostream>

#include "client/cli/command.h"
#include "client/cli/input/message_file.h"
#include "client/cli/options.h"
#include "client/cli/run_command.h"
#include "client/cli/sinks/saved_run.h"

namespace stiefel::cli {
namespace {

struct RerunCommand {
  std::string file;
  std::string output;
  Remote server;
};

/// A file that is removed at the end.
struct Temporary {
  std::string path;
  ~Temporary() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

/// Returns the command that makes the samples of a file again. `given`: what the file says of its
/// run. Throws BadInput if that is malformed.
RunCommand command_of(const RerunCommand& rerun, const nlohmann::ordered_json& given,
                      std::vector<double>& times) {
  RunCommand command;
  command.scene.name = rerun.file;
  command.server = rerun.server;
  command.output = rerun.output;
  try {
    command.fields = given.at("fields").get<std::vector<std::string>>();
    if (given.contains("times")) {
      times = given.at("times").get<std::vector<double>>();
    } else {
      command.scene.to = given.at("to").get<std::int64_t>();
      command.from = given.at("start").get<std::int64_t>();
      command.every = given.at("every").get<std::int64_t>();
    }
  } catch (const nlohmann::json::exception& error) {
    throw BadInput(rerun.file + ": run: " + error.what());
  }
  return command;
}

ExitStatus rerun(RerunCommand command, Origin& origin) {
  const SavedRun saved = read_saved_run(command.file);
  nlohmann::ordered_json given = saved.description["scene"];
  const auto epoch = given.value("epoch", std::string());
  given.erase("epoch");
  v1::Scene scene;
  parse_message(command.file + ": scene", given.dump(), &scene);
  Temporary temporary;
  if (command.output.empty())
    command.output = temporary.path =
        command.file + ".rerun" + std::filesystem::path(command.file).extension().string();
  std::vector<double> times;
  RunCommand again = command_of(command, saved.description["run"], times);
  again.estimate_error = saved.description.contains("estimated_error");
  again.epoch = epoch;
  again.quiet = true;
  const ExitStatus status =
      times.empty() ? run(again, scene, origin) : run_at_times(again, scene, times, origin);
  const SavedRun now = read_saved_run(command.output);
  if (now.samples == saved.samples) {
    std::cout << command.file << ": the same samples, to the last bit\n";
    return status;
  }
  const bool same_build = now.description["numerics_id"] == saved.description["numerics_id"];
  std::cout << command.file << ": other samples"
            << (same_build ? "\n"
                           : "; another build wrote the file: numerics id " +
                                 saved.description["numerics_id"].dump() + ", here " +
                                 now.description["numerics_id"].dump() + '\n');
  return failed;
}

void add_rerun(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<RerunCommand>();
  app->add_option("file", command->file,
                  "a .json, .csv or .npz file that `stiefel run --output` or Python's "
                  "Trajectory.save wrote. Exit status 1: the samples differ")
      ->required()
      ->type_name("FILE");
  app->add_option("--output", command->output,
                  "a file of the same kind for the new samples; by default they are only compared")
      ->type_name("FILE");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->file + ": scene", .options = {}};
    chosen.run = [command](Origin& origin) { return rerun(*command, origin); };
  });
}

const Subcommand rerun_command(
    "rerun", "Runs the scene of a file of samples again and compares the samples, bit by bit",
    add_rerun);

}  // namespace

}  // namespace stiefel::cli
