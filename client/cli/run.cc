#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/endpoint.h"
#include "client/cli/message_file.h"
#include "client/cli/progress.h"
#include "client/cli/report.h"
#include "client/cli/sink.h"

namespace stiefel::cli {
namespace {

std::int64_t every(const RunCommand& command) {
  if (command.every) return *command.every;
  // A range that is no range is the server's to refuse.
  if (command.from < 0 || command.to <= command.from) return 1;
  const std::int64_t steps = command.to - command.from;
  return steps < max_default_samples ? 1 : steps;
}

}  // namespace

ExitStatus run(const RunCommand& command) {
  if (command.every && *command.every <= 0) {
    throw BadInput("--every: " + std::to_string(*command.every) + " must be positive");
  }
  const v1::Scene scene = read_scene(command.scene);
  const auto sink = make_sink(command.output);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.client().create(scene);
  print_warnings(session.description());
  auto stream = session.stream({command.from, command.to, every(command), command.fields});
  std::int64_t last = 0;
  v1::DiagnoseResponse diagnosis;
  {
    Progress progress(session, command.to);
    while (const auto* batch = stream.next_batch()) {
      sink->write(*batch);
      last = batch->steps(batch->steps_size() - 1);
      progress.at(last);
    }
    v1::DiagnoseRequest request;
    request.set_to(command.to);
    request.set_estimate_error(error_estimation(command.estimate_error));
    diagnosis = session.diagnose(request);
  }
  if (!stream.ending()) throw std::runtime_error("the stream ended without an ending");
  const auto result = report(*stream.ending(), diagnosis);
  sink->finish(result);
  // Outcome and diagnosis have no place in the other formats.
  if (!command.output.empty() && !command.output.ends_with(".json")) {
    std::cout << result.dump(2) << '\n';
  }
  show_summary(diagnosis);
  return conclude(*stream.ending(), diagnosis.step());
}

}  // namespace stiefel::cli
