#include <fstream>
#include <iterator>
#include <optional>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/interrupt.h"
#include "client/cli/options.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/destination.h"

namespace stiefel::cli {
namespace {

struct LyapunovCommand {
  SceneSource scene;
  Remote server;
  std::int64_t from = 0, every = 0, count = 0, interval = 0, seed = 0;
  std::string method = "discrete_qr";
  /// Files from which to go on, and to which the checkpoint is written.
  std::string resume, checkpoint;
  std::string output;
};

template <class Numbers>
nlohmann::ordered_json as_list(const Numbers& numbers) {
  return std::vector<double>(numbers.begin(), numbers.end());
}

const char* name_of(v1::Verdict verdict) {
  switch (verdict) {
    case v1::VERDICT_REGULAR:
      return "regular";
    case v1::VERDICT_CHAOTIC:
      return "chaotic";
    default:
      return "undecided";
  }
}

v1::LyapunovSpectrumRequest request_of(const LyapunovCommand& command) {
  v1::LyapunovSpectrumRequest request;
  request.set_from(command.from);
  request.set_every(command.every);
  request.set_count(static_cast<std::uint32_t>(command.count));
  request.set_orthonormalization(command.method == "continuous"
                                     ? v1::ORTHONORMALIZATION_CONTINUOUS
                                     : v1::ORTHONORMALIZATION_DISCRETE_QR);
  request.set_interval(command.interval);
  request.set_seed(static_cast<std::uint64_t>(command.seed));
  if (command.resume.empty()) return request;
  std::ifstream file(command.resume, std::ios::binary);
  if (!file) throw BadInput(command.resume + ": cannot be read");
  request.set_checkpoint(std::string(std::istreambuf_iterator<char>(file), {}));
  return request;
}

ExitStatus lyapunov(const LyapunovCommand& command, Origin& origin) {
  const v1::Scene scene = read_scene(command.scene, origin);
  v1::LyapunovSpectrumRequest request = request_of(command);
  request.set_to(last_step(command.scene, scene));
  std::optional<Destination> destination, saved;
  if (!command.output.empty()) destination.emplace(command.output);
  if (!command.checkpoint.empty()) saved.emplace(command.checkpoint);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  v1::LyapunovSpectrumResponse end;
  {
    Progress progress(session, request.to());
    try {
      end = session.lyapunov(request, [&](const v1::LyapunovSpectrumResponse& result) {
        progress.at(result.step());
        if (!result.exponents().empty())
          results.push_back({{"step", result.step()},
                             {"time", result.time()},
                             {"exponents", as_list(result.exponents())},
                             {"log_gali", as_list(result.log_gali())}});
        return true;
      });
    } catch (const client::Error&) {
      if (interrupted()) throw Interrupted(progress.how_far() + "; nothing was written");
      throw;
    }
  }
  nlohmann::ordered_json out = {{"outcome", to_string(end.run_status().outcome())}};
  if (end.run_status().outcome() != v1::OUTCOME_REACHED)
    out["message"] = end.run_status().message();
  out["verdict"] = name_of(end.verdict());
  out["reason"] = end.reason();
  out["exponents"] = as_list(end.exponents());
  out["errors"] = as_list(end.errors());
  out["log_gali"] = as_list(end.log_gali());
  out["interval"] = end.interval();
  out["results"] = std::move(results);
  if (saved) write_whole(saved, end.checkpoint().data());
  write_whole(destination, to_text(out) + "\n");
  return conclude(end.run_status(), end.step());
}

}  // namespace

void add_lyapunov(CLI::App& all, Command& chosen) {
  const auto command = std::make_shared<LyapunovCommand>();
  auto* app = all.add_subcommand(
      "lyapunov", "Prints Lyapunov exponents with error bars: regular, chaotic or undecided");
  add_run_of_scene(app, command->scene);
  app->add_option("--from", command->from, "the step at which the vectors start; 0 by default")
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
  app->add_option("--every", command->every, "the numbers about every K steps too")
      ->transform(whole_number())
      ->type_name("K");
  app->add_option("--count", command->count, "the K largest exponents; all by default")
      ->transform(whole_number())
      ->type_name("K");
  app->add_option("--orthonormalization", command->method,
                  "discrete_qr, by default, or continuous, for continuous systems")
      ->check(CLI::IsMember({"discrete_qr", "continuous"}))
      ->type_name("METHOD");
  app->add_option("--interval", command->interval,
                  "steps between two orthonormalisations; by default about a radian of the motion")
      ->transform(whole_number())
      ->type_name("STEPS");
  app->add_option("--seed", command->seed, "of the random first vectors; 0 by default")
      ->transform(whole_number())
      ->type_name("SEED");
  app->add_option(
         "--resume", command->resume,
         "goes on from a file that --checkpoint wrote with the same scene and options, but "
         "a later last step")
      ->type_name("FILE");
  app->add_option("--checkpoint", command->checkpoint, "writes what --resume needs")
      ->type_name("FILE");
  app->add_option("--output", command->output, "a .json file; stdout by default")
      ->type_name("FILE.json");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->scene.shown(),
                     .options = {{"from", "--from"},
                                 {"to", command->scene.time ? "--time" : "--to"},
                                 {"every", "--every"},
                                 {"count", "--count"},
                                 {"orthonormalization", "--orthonormalization"},
                                 {"interval", "--interval"},
                                 {"checkpoint", "--resume"}}};
    chosen.run = [command](Origin& origin) { return lyapunov(*command, origin); };
  });
}

}  // namespace stiefel::cli
