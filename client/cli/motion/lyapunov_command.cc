#include <fstream>
#include <iterator>

#include "client/cli/motion/motion_options.h"

namespace stiefel::cli {
namespace {

struct LyapunovCommand : MotionCommand {
  std::int64_t every = 0, count = 0, interval = 0, seed = 0;
  /// Files from which to go on, and to which the checkpoint is written.
  std::string resume, checkpoint;
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
  request.set_every(command.every);
  request.set_count(static_cast<std::uint32_t>(command.count));
  request.set_interval(command.interval);
  request.set_seed(static_cast<std::uint64_t>(command.seed));
  if (command.resume.empty()) return request;
  std::ifstream file(command.resume, std::ios::binary);
  if (!file) throw BadInput(command.resume + ": cannot be read");
  request.set_checkpoint(std::string(std::istreambuf_iterator<char>(file), {}));
  return request;
}

ExitStatus lyapunov(const LyapunovCommand& command, Origin& origin) {
  std::optional<Destination> saved;
  if (!command.checkpoint.empty()) saved.emplace(command.checkpoint);
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  const auto ask = [&](const auto& session, const auto& request, Progress& progress) {
    return session.lyapunov(request, [&](const v1::LyapunovSpectrumResponse& result) {
      progress.at(result.step());
      if (!result.exponents().empty())
        results.push_back({{"step", result.step()},
                           {"time", result.time()},
                           {"exponents", as_list(result.exponents())},
                           {"log_gali", as_list(result.log_gali())}});
      return true;
    });
  };
  return answer(command, origin, request_of(command), ask, [&](auto& json, const auto& end) {
    json["verdict"] = name_of(end.verdict());
    json["reason"] = end.reason();
    json["exponents"] = as_list(end.exponents());
    json["errors"] = as_list(end.errors());
    json["log_gali"] = as_list(end.log_gali());
    json["interval"] = end.interval();
    json["results"] = std::move(results);
    if (saved) write_whole(saved, end.checkpoint().data());
  });
}

void add_lyapunov(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<LyapunovCommand>();
  add_motion(app, *command, "the step at which the vectors start; 0 by default");
  app->add_option("--every", command->every, "the numbers about every K steps too")
      ->transform(whole_number())
      ->type_name("K");
  app->add_option("--count", command->count, "the K largest exponents; all by default")
      ->transform(whole_number())
      ->type_name("K");
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
  add_end(app, chosen, command,
          {{"every", "--every"},
           {"count", "--count"},
           {"interval", "--interval"},
           {"checkpoint", "--resume"}},
          lyapunov);
}

const Subcommand lyapunov_command(
    "lyapunov", "Prints Lyapunov exponents with error bars: regular, chaotic or undecided",
    add_lyapunov);

}  // namespace

}  // namespace stiefel::cli
