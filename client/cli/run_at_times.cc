#include "client/cli/run_command.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <ranges>

#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/interrupt.h"
#include "client/cli/progress/progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/sink.h"

namespace stiefel::cli {
namespace {

BadInput refused(std::size_t index, const std::string& rule) {
  return BadInput("--times[" + std::to_string(index) + "]: " + rule);
}

/// Returns the indices of the times that are on one side of 0, in the order of the motion that
/// leads there from 0 in steps of this length. Throws BadInput that names the first wrong time by
/// its index in the file.
std::vector<std::size_t> in_order(const std::vector<double>& times, double step, bool with_0) {
  constexpr double most = 0x1p53;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double steps = in_steps(times[k], step);
    if (!(std::abs(steps) <= most))
      throw refused(k, nlohmann::json(times[k]).dump() + ": must be within 2^53 steps");
    if (steps > 0 || (with_0 && steps == 0)) order.push_back(k);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return std::abs(times[k]); });
  return order;
}

/// Returns a request for the times in this order, and the range of steps around them.
v1::SummarizeRequest request_for(const RunCommand& command, const std::vector<double>& times,
                                 double step, const std::vector<std::size_t>& order) {
  v1::SummarizeRequest request;
  request.set_from(static_cast<std::int64_t>(std::floor(in_steps(times[order.front()], step))));
  request.set_to(static_cast<std::int64_t>(std::ceil(in_steps(times[order.back()], step))));
  request.set_every(std::max<std::int64_t>(1, request.to()));
  for (const std::size_t k : order) request.add_times(times[k]);
  request.mutable_fields()->Add(command.fields.begin(), command.fields.end());
  return request;
}

v1::StreamResponse batch_of(const v1::StateBatch& states) {
  v1::StreamResponse batch;
  *batch.mutable_steps() = states.steps();
  *batch.mutable_times() = states.times();
  *batch.mutable_fields() = states.fields();
  return batch;
}

/// Turns samples of the motion in steps of the other sign into those before time 0, whose steps are
/// negative, in the order of time.
void turn_back(v1::StreamResponse& batch) {
  std::ranges::reverse(*batch.mutable_steps());
  std::ranges::reverse(*batch.mutable_times());
  for (auto& step : *batch.mutable_steps()) step = -step;
  for (auto& field : *batch.mutable_fields()) {
    const std::string given = field.value().data();
    const std::size_t size = given.size() / static_cast<std::size_t>(batch.steps_size());
    std::string& data = *field.mutable_value()->mutable_data();
    data.clear();
    for (std::size_t end = given.size(); end > 0; end -= size) data.append(given, end - size, size);
  }
}

/// Returns the session of the motion before time 0, which has a step of the other sign.
client::Session before(const client::Session& session, const std::vector<double>& times,
                       std::size_t first) {
  const v1::Scene& scene = session.scene();
  if (scene.initial().contains("Q_prev") || scene.initial_tensors().contains("Q_prev"))
    throw refused(first, nlohmann::json(times[first]).dump() +
                             ": must have the sign of the scene's step, because the state 0 of " +
                             scene.system() + " is a pair of frames");
  v1::ForkSessionRequest request;
  request.set_step(-scene.step());
  return session.fork(request);
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
  const double step = scene.step();
  const auto ahead = in_order(times, step, true), behind = in_order(times, -step, false);
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  std::vector<double> in_order_of_time;
  for (const std::size_t k : behind | std::views::reverse) in_order_of_time.push_back(times[k]);
  for (const std::size_t k : ahead) in_order_of_time.push_back(times[k]);
  sink->describe({session, {{"times", in_order_of_time}}, command.epoch});
  v1::DiagnoseResponse diagnosis;  // of the side that runs last
  const auto run = [&](const client::Session& on, double h, const std::vector<std::size_t>& order,
                       const std::function<void(v1::StreamResponse)>& take) {
    origin.times = order;
    const v1::SummarizeRequest request = request_for(command, times, h, order);
    Progress progress(on, request.to());
    try {
      const auto end = on.summarize(request, [&](const v1::SummarizeResponse& message) {
        progress.at(message.step());
        if (message.has_states()) take(batch_of(message.states()));
        return true;
      });
      v1::DiagnoseRequest to_diagnose;
      to_diagnose.set_to(request.to());
      to_diagnose.set_estimate_error(error_estimation(command.estimate_error));
      diagnosis = on.diagnose(to_diagnose);
      return end.run_status();
    } catch (const client::Error&) {
      if (!interrupted()) throw;
      const bool to_stdout = command.output.empty();
      if (to_stdout) sink->finish({{"outcome", "CANCELLED"}, {"message", "interrupted"}}, {});
      throw Interrupted(progress.how_far() + (to_stdout ? "; the samples up to there are on stdout"
                                                        : "; nothing was written"));
    }
  };
  v1::RunStatus status;
  if (!behind.empty()) {
    const client::Session back = before(session, times, behind.front());
    std::vector<v1::StreamResponse> held;
    status = run(back, -step, behind,
                 [&](v1::StreamResponse batch) { held.push_back(std::move(batch)); });
    for (auto& batch : held | std::views::reverse) {
      turn_back(batch);
      sink->write(batch);
    }
  }
  if (!ahead.empty()) {
    const v1::RunStatus end =
        run(session, step, ahead, [&](const v1::StreamResponse& batch) { sink->write(batch); });
    if (behind.empty() || status.outcome() == v1::OUTCOME_REACHED) status = end;
  }
  const auto result = report(status, diagnosis, session.choice());
  sink->finish(result, ending(status, diagnosis));
  if (command.quiet) return conclude(status, diagnosis.step());
  if (command.output.empty() || command.output.ends_with(".json"))
    show_summary(diagnosis);
  else
    print_report(result, diagnosis);
  return conclude(status, diagnosis.step());
}

}  // namespace stiefel::cli
