#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/endpoint.h"
#include "client/cli/interrupt.h"
#include "client/cli/message_file.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/sink.h"
#include "client/cli/summaries/at_times.h"

namespace stiefel::cli {
namespace {

std::int64_t every(const RunCommand& command) {
  if (command.every) return *command.every;
  // The server refuses a wrong range, whatever `every` is.
  if (command.from < 0 || command.to <= command.from) return 1;
  const std::int64_t steps = command.to - command.from;
  return steps < max_default_samples ? 1 : steps;
}

/// Ends an interrupted run: throws Interrupted. An incomplete file does not appear; JSON on stdout
/// is completed, without a diagnosis.
[[noreturn]] void give_up(const RunCommand& command, const Progress& progress, Sink& sink) {
  const bool to_stdout = command.output.empty();
  if (to_stdout) sink.finish({{"outcome", "CANCELLED"}, {"message", "interrupted"}});
  throw Interrupted(progress.how_far() + (to_stdout ? "; the samples up to there are on stdout"
                                                    : "; nothing was written"));
}

/// Says on stderr how many samples a long run without --every has written, unless it wrote all.
void show_count(const RunCommand& command, std::int64_t samples) {
  if (command.every || every(command) == 1) return;
  std::cerr << "stiefel: wrote " << samples << (samples == 1 ? " sample" : " samples")
            << " (first and last); --every 1 for all\n";
}

}  // namespace

ExitStatus run(const RunCommand& command, Origin& origin) {
  if (command.every && *command.every <= 0) {
    throw BadInput("--every: " + std::to_string(*command.every) + " must be positive");
  }
  if (!command.times.empty()) return run_at_times(command, origin);
  const v1::Scene scene = read_scene(command.scene);
  const auto sink = make_sink(command.output);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  auto stream = session.stream({command.from, command.to, every(command), command.fields});
  std::int64_t last = 0, samples = 0;
  v1::DiagnoseResponse diagnosis;
  {
    Progress progress(session, command.to);
    try {
      while (const auto* batch = stream.next_batch()) {
        sink->write(*batch);
        last = batch->steps(batch->steps_size() - 1);
        samples += batch->steps_size();
        progress.at(last);
      }
      v1::DiagnoseRequest request;
      request.set_to(command.to);
      request.set_estimate_error(error_estimation(command.estimate_error));
      diagnosis = session.diagnose(request);
    } catch (const client::Error&) {
      if (interrupted()) give_up(command, progress, *sink);
      throw;
    }
  }
  if (!stream.run_status()) throw std::runtime_error("the stream ended without a run status");
  const auto result = report(*stream.run_status(), diagnosis, session.choice());
  sink->finish(result);
  // Only JSON files hold outcome and diagnosis; for the other formats they go to stdout.
  if (!command.output.empty() && !command.output.ends_with(".json")) {
    std::cout << result.dump(2) << '\n';
  }
  show_count(command, samples);
  show_summary(diagnosis);
  return conclude(*stream.run_status(), diagnosis.step());
}

}  // namespace stiefel::cli
