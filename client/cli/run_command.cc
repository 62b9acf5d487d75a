#include <cmath>
#include <iostream>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/interrupt.h"
#include "client/cli/options.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/run_command.h"
#include "client/cli/sinks/sink.h"

namespace stiefel::cli {
namespace {

/// Without --every, `run` samples every step if that gives at most this many samples, else only the
/// first and the last step.
constexpr std::int64_t max_default_samples = 1000;

std::int64_t every(const RunCommand& command, std::int64_t to) {
  if (command.every) return *command.every;
  // The server refuses a wrong range, whatever `every` is.
  if (command.from < 0 || to <= command.from) return 1;
  const std::int64_t steps = to - command.from;
  return steps < max_default_samples ? 1 : steps;
}

/// Returns the times of the samples of a run whose last time is between two steps.
std::vector<double> times_up_to(const RunCommand& command, const v1::Scene& scene) {
  const auto last = static_cast<std::int64_t>(std::floor(end_in_steps(command.scene, scene)));
  if (command.from < 0 || command.from > last)
    throw BadInput("--from: " + std::to_string(command.from) +
                   " must be from 0 to the step before --time");
  std::vector<double> times;
  for (std::int64_t k = command.from; k <= last; k += every(command, last))
    times.push_back(static_cast<double>(k) * scene.step());
  times.push_back(*command.scene.time);
  return times;
}

/// Ends an interrupted run: throws Interrupted. An incomplete file does not appear; JSON on stdout
/// is completed, without a diagnosis.
[[noreturn]] void give_up(const RunCommand& command, const Progress& progress, Sink& sink) {
  const bool to_stdout = command.output.empty();
  if (to_stdout) sink.finish({{"outcome", "CANCELLED"}, {"message", "interrupted"}}, {});
  throw Interrupted(progress.how_far() + (to_stdout ? "; the samples up to there are on stdout"
                                                    : "; nothing was written"));
}

/// Says on stderr how many samples a long run without --every has written, unless it wrote all.
void show_count(const RunCommand& command, std::int64_t to, std::int64_t samples) {
  if (command.every || every(command, to) == 1) return;
  std::cerr << "stiefel: wrote " << samples << (samples == 1 ? " sample" : " samples")
            << " (first and last); --every 1 for all\n";
}

}  // namespace

ExitStatus run(const RunCommand& command, const v1::Scene& scene, Origin& origin) {
  if (command.every && *command.every <= 0) {
    throw BadInput("--every: " + std::to_string(*command.every) + " must be positive");
  }
  if (!command.times.empty())
    return run_at_times(command, scene, read_times(command.times), origin);
  if (const double end = end_in_steps(command.scene, scene); end != std::floor(end))
    return run_at_times(command, scene, times_up_to(command, scene), origin);
  const std::int64_t to = last_step(command.scene, scene);
  const auto sink = make_sink(command.output);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  sink->describe({session,
                  {{"to", to}, {"start", command.from}, {"every", every(command, to)}},
                  command.epoch});
  auto stream = session.stream({command.from, to, every(command, to), command.fields});
  std::int64_t last = 0, samples = 0;
  v1::DiagnoseResponse diagnosis;
  {
    Progress progress(session, to);
    try {
      while (const auto* batch = stream.next_batch()) {
        sink->write(*batch);
        last = batch->steps(batch->steps_size() - 1);
        samples += batch->steps_size();
        progress.at(last);
      }
      v1::DiagnoseRequest request;
      request.set_to(to);
      request.set_estimate_error(error_estimation(command.estimate_error));
      diagnosis = session.diagnose(request);
    } catch (const client::Error&) {
      if (interrupted()) give_up(command, progress, *sink);
      throw;
    }
  }
  if (!stream.run_status()) throw std::runtime_error("the stream ended without a run status");
  const auto result = report(*stream.run_status(), diagnosis, session.choice());
  sink->finish(result, ending(*stream.run_status(), diagnosis));
  // Only JSON files hold outcome and diagnosis; for the other formats they go to stdout.
  if (command.quiet) return conclude(*stream.run_status(), diagnosis.step());
  show_count(command, to, samples);
  if (command.output.empty() || command.output.ends_with(".json"))
    show_summary(diagnosis);
  else
    print_report(result, diagnosis);
  return conclude(*stream.run_status(), diagnosis.step());
}

namespace {

void add_run(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<RunCommand>();
  add_run_of_scene(app, command->scene);
  app->add_option(
         "--times", command->times,
         "file of times, separated by white space, instead of --to: samples at these times, in "
         "the order of the motion. Between two steps the method makes one shorter step from the "
         "state before. A time before 0 is one of the scene with a step of the other sign")
      ->type_name("FILE")
      ->excludes("--to")
      ->excludes("--time");
  app->add_option("--from", command->from, "the first sample; 0 by default")
      ->transform(whole_number(between_steps))
      ->type_name("STEP");
  app->add_option("--every", command->every,
                  "a sample every K steps, and always at the last step. By default a sample at "
                  "every step if these are at most 1000, otherwise at the first and the last")
      ->transform(whole_number())
      ->type_name("K");
  app->add_option(
         "--fields", command->fields,
         "fields to sample, separated by commas, as `stiefel describe` lists them; by default "
         "quaternion and angular_velocity of a scene with `body`, otherwise the system's blocks")
      ->delimiter(',')
      ->type_name("Q,M,...");
  app->add_option(
         "--output", command->output,
         "a .json, .csv or .npz file; by default JSON on stdout. JSON contains outcome "
         "and diagnosis; with .csv and .npz the command prints them on stdout, on a terminal as "
         "a table")
      ->type_name("FILE");
  for (const char* option : {"--from", "--every"}) app->get_option("--times")->excludes(option);
  add_error(app, command->estimate_error);
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->scene.shown(),
                     .options = {{"from", "--from"},
                                 {"to", command->scene.time ? "--time" : "--to"},
                                 {"every", "--every"},
                                 {"fields", "--fields"},
                                 {"times", "--times"}}};
    chosen.run = [command](Origin& origin) {
      return run(*command, read_scene(command->scene, origin, &command->epoch), origin);
    };
  });
}

const Subcommand run_command("run", "Runs a scene and writes samples", add_run);

}  // namespace

}  // namespace stiefel::cli
