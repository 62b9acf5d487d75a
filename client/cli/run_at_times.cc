#include "client/cli/run.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "client/cli/endpoint.h"
#include "client/cli/interrupt.h"
#include "client/cli/message_file.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/sink.h"

namespace stiefel::cli {
namespace {

BadInput refused(std::size_t index, const std::string& rule) {
  return BadInput("--times[" + std::to_string(index) + "]: " + rule);
}

/// Returns the indices of the times in the order of the motion. Throws BadInput that names the
/// first wrong time by its index in the file.
std::vector<std::size_t> in_order(const std::vector<double>& times, double step) {
  constexpr double most = 0x1p53;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double steps = in_steps(times[k], step);
    if (!(std::floor(steps) >= 0 && std::ceil(steps) <= most))
      throw refused(k, nlohmann::json(times[k]).dump() +
                           ": must be in the direction of the scene's step, within 2^53 steps" +
                           (steps < 0 ? "; for this time, use a step of the other sign" : ""));
    order.push_back(k);
  }
  std::ranges::stable_sort(order, {},
                           [&](std::size_t k) { return std::copysign(1, step) * times[k]; });
  return order;
}

/// Returns a request for the times, in the order of the motion, and the range of steps around them.
v1::SummarizeRequest request_for(const RunCommand& command, const std::vector<double>& times,
                                 double step, Origin& origin) {
  origin.times = in_order(times, step);
  v1::SummarizeRequest request;
  request.set_from(
      static_cast<std::int64_t>(std::floor(in_steps(times[origin.times.front()], step))));
  request.set_to(static_cast<std::int64_t>(std::ceil(in_steps(times[origin.times.back()], step))));
  request.set_every(std::max<std::int64_t>(1, request.to()));
  for (const std::size_t k : origin.times) request.add_times(times[k]);
  request.mutable_fields()->Add(command.fields.begin(), command.fields.end());
  return request;
}

}  // namespace

std::vector<double> read_times(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw BadInput("--times: " + path + " cannot be read");
  std::vector<double> times;
  for (std::string word; file >> word;) {
    if (times.empty() && word.starts_with(byte_order_mark)) word.erase(0, byte_order_mark.size());
    if (word.empty()) continue;
    char* end = nullptr;
    const double time = std::strtod(word.c_str(), &end);
    if (*end != '\0' || !std::isfinite(time))
      throw refused(times.size(), word + " is not a finite number");
    times.push_back(time);
  }
  if (times.empty()) throw BadInput("--times: " + path + " has no times");
  return times;
}

ExitStatus run_at_times(const RunCommand& command, const v1::Scene& scene,
                        const std::vector<double>& times, Origin& origin) {
  if (!scene.has_step())
    throw BadInput(command.scene.shown() + ": step: absent: must be given, finite and not 0");
  const auto sink = make_sink(command.output);
  const v1::SummarizeRequest request = request_for(command, times, scene.step(), origin);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  sink->describe({session, {{"times", request.times()}}});
  v1::SummarizeResponse end;
  v1::DiagnoseResponse diagnosis;
  {
    Progress progress(session, request.to());
    try {
      end = session.summarize(request, [&](const v1::SummarizeResponse& message) {
        progress.at(message.step());
        if (!message.has_states()) return true;
        v1::StreamResponse batch;
        *batch.mutable_steps() = message.states().steps();
        *batch.mutable_times() = message.states().times();
        *batch.mutable_fields() = message.states().fields();
        sink->write(batch);
        return true;
      });
      v1::DiagnoseRequest to_diagnose;
      to_diagnose.set_to(request.to());
      to_diagnose.set_estimate_error(error_estimation(command.estimate_error));
      diagnosis = session.diagnose(to_diagnose);
    } catch (const client::Error&) {
      if (!interrupted()) throw;
      const bool to_stdout = command.output.empty();
      if (to_stdout) sink->finish({{"outcome", "CANCELLED"}, {"message", "interrupted"}}, {});
      throw Interrupted(progress.how_far() + (to_stdout ? "; the samples up to there are on stdout"
                                                        : "; nothing was written"));
    }
  }
  const auto result = report(end.run_status(), diagnosis, session.choice());
  sink->finish(result, ending(end.run_status(), diagnosis));
  if (command.quiet) return conclude(end.run_status(), diagnosis.step());
  if (!command.output.empty() && !command.output.ends_with(".json"))
    std::cout << result.dump(2) << '\n';
  show_summary(diagnosis);
  return conclude(end.run_status(), diagnosis.step());
}

}  // namespace stiefel::cli
