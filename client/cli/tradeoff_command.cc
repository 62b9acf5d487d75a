#include <algorithm>
#include <iostream>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/interrupt.h"
#include "client/cli/options.h"
#include "client/cli/progress/tradeoff_progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/destination.h"
#include "client/cli/sinks/sink.h"
#include "engine/numbers/to_text.h"

namespace stiefel::cli {
namespace {

struct TradeoffCommand {
  SceneSource scene;
  Remote server;
  std::optional<double> horizon;
  std::optional<double> budget;
  std::optional<std::uint32_t> repeats;
  bool all = false;  ///< prints all the points, not only the front
  std::string output;
};

struct Answer {
  v1::TradeoffSetup setup;
  std::vector<v1::TradeoffPoint> points;
  std::vector<bool> front;

  void mark(const v1::TradeoffFront& marked) {
    front.assign(points.size(), false);
    for (const auto i : marked.points()) front.at(i) = true;
  }
};

/// Returns the value with `decimals` digits after the point: "1.23e-09".
std::string brief(double value, int decimals = 2) { return scientific_text(value, decimals + 1); }

std::string scalar(const v1::Method& method) {
  return method.scalar().empty() ? "double" : method.scalar();
}

double median(const v1::TradeoffPoint& point) {
  std::vector<double> times(point.cpu_seconds_per_second().begin(),
                            point.cpu_seconds_per_second().end());
  std::ranges::sort(times);
  return times.empty() ? 0 : times[times.size() / 2];
}

std::string knob(const v1::Method& method) {
  if (method.has_tolerance()) return "tolerance " + brief(method.tolerance(), 0);
  return std::to_string(method.substeps()) + (method.substeps() == 1 ? " substep" : " substeps");
}

std::string arithmetic(const v1::Method& method) {
  return method.arithmetic() + (method.scalar() == "float" ? ", float" : "");
}

std::vector<std::string> row(const v1::TradeoffPoint& point, bool marked) {
  const auto& method = point.method();
  const std::string mark = std::string(marked ? "*" : " ") + (point.extrapolated() ? "~" : "");
  const std::vector<std::string> name = {mark, method.name(), std::to_string(method.order()),
                                         knob(method), arithmetic(method)};
  std::vector<std::string> out = name;
  if (point.run_status().outcome() != v1::OUTCOME_REACHED) {
    out.push_back(to_string(point.run_status().outcome()));
    return out;
  }
  const std::string below = point.below_reference() ? "<" : "";
  out.push_back(point.has_attitude_error() ? below + brief(point.attitude_error()) : "");
  out.push_back(below + brief(point.momentum_error()));
  out.push_back(brief(point.drift()));
  out.push_back(brief(point.work()));
  out.push_back(brief(median(point)));
  out.push_back(brief(point.steps_per_second()));
  return out;
}

/// Prints the points of the Pareto front or, if `all`, all points with those of the front marked.
/// The point of least work comes first.
void print(const Answer& answer, bool all) {
  const auto& setup = answer.setup;
  std::cout << "machine: " << setup.machine() << "\nnumerics id: " << setup.numerics_id()
            << "\nreference: " << setup.reference() << ", its own error "
            << brief(setup.reference_error(), 1) << "\nhorizon: " << setup.horizon() << " ("
            << setup.steps() << " steps)\nbudget: " << setup.budget() << " instructions, "
            << setup.repeats() << " timed runs a point\n\n";
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < answer.points.size(); ++i) {
    if (all || answer.front[i]) order.push_back(i);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return answer.points[i].work(); });
  Rows rows = {{"", "method", "order", "", "arithmetic", "attitude", "momentum", "drift", "work",
                "CPU s/s", "steps/s"}};
  for (const std::size_t i : order) rows.push_back(row(answer.points[i], all && answer.front[i]));
  print_table(rows);
  std::cout << '\n';
  if (all) {
    std::cout << "* the Pareto front: no other point beats it in both work and error\n";
  } else {
    std::cout << "The Pareto front, " << order.size() << " of " << answer.points.size()
              << " points: no other point beats one of them in both work and error. --all prints "
                 "the rest.\n";
  }
  std::cout << "~ extrapolated from a part of the horizon   "
               "< the error is below that of the reference, which is shown instead\n";
}

nlohmann::ordered_json to_json(const v1::TradeoffPoint& point, bool front) {
  nlohmann::ordered_json out = {{"method", cli::to_json(point.method())},
                                {"outcome", to_string(point.run_status().outcome())}};
  if (point.has_attitude_error()) out["attitude_error"] = point.attitude_error();
  if (point.has_momentum_error()) out["momentum_error"] = point.momentum_error();
  out["drift"] = point.drift();
  out["drift_of"] = point.drift_of();
  out["work"] = point.work();
  out["cpu_seconds_per_second"] = point.cpu_seconds_per_second();
  out["steps_per_second"] = point.steps_per_second();
  out["measured_steps"] = point.measured_steps();
  out["extrapolated"] = point.extrapolated();
  out["below_reference"] = point.below_reference();
  out["front"] = front;
  return out;
}

std::string json_text(const Answer& answer) {
  const auto& setup = answer.setup;
  nlohmann::ordered_json out = {{"machine", setup.machine()},
                                {"numerics_id", setup.numerics_id()},
                                {"reference", setup.reference()},
                                {"reference_error", setup.reference_error()},
                                {"horizon", setup.horizon()},
                                {"steps", setup.steps()},
                                {"reference_steps", setup.reference_steps()},
                                {"budget", setup.budget()},
                                {"repeats", setup.repeats()},
                                {"warnings", setup.warnings()}};
  out["points"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < answer.points.size(); ++i)
    out["points"].push_back(to_json(answer.points[i], answer.front[i]));
  return to_text(out) + "\n";
}

std::string csv_text(const Answer& answer) {
  std::string text =
      "method,order,substeps,tolerance,arithmetic,scalar,outcome,attitude_error,momentum_error,"
      "drift,drift_of,work,cpu_seconds_per_second,steps_per_second,measured_steps,extrapolated,"
      "below_reference,front\n";
  for (std::size_t i = 0; i < answer.points.size(); ++i) {
    const auto& point = answer.points[i];
    const auto& method = point.method();
    const auto number = [&](bool present, double value) {
      if (present) append_number(text, value);
      text += ',';
    };
    text += method.name() + ',' + std::to_string(method.order()) + ',' +
            std::to_string(method.substeps()) + ',';
    number(method.has_tolerance(), method.tolerance());
    text += method.arithmetic() + ',' + scalar(method) + ',' +
            to_string(point.run_status().outcome()) + ',';
    number(point.has_attitude_error(), point.attitude_error());
    number(point.has_momentum_error(), point.momentum_error());
    number(true, point.drift());
    text += '"' + point.drift_of() + "\",";
    number(true, point.work());
    number(true, median(point));
    number(true, point.steps_per_second());
    text += std::to_string(point.measured_steps());
    for (const bool flag : {point.extrapolated(), point.below_reference(), bool(answer.front[i])})
      text += flag ? ",1" : ",0";
    text += '\n';
  }
  return text;
}

Answer measure(const v1::MeasureTradeoffRequest& request, const Remote& server) {
  Answer answer;
  MeasuringLine line;
  try {
    Endpoint(server).client().tradeoff(request, [&](const auto& part) {
      if (part.has_setup()) answer.setup = part.setup();
      if (part.has_point()) answer.points.push_back(part.point());
      if (part.has_front()) answer.mark(part.front());
      line.take(part);
      return true;
    });
  } catch (const client::Error&) {
    if (interrupted()) throw Interrupted(line.how_far() + "; nothing was written");
    throw;
  }
  return answer;
}

ExitStatus tradeoff(const TradeoffCommand& command, Origin& origin) {
  const bool json = command.output.ends_with(".json"), csv = command.output.ends_with(".csv");
  if (!command.output.empty() && !json && !csv)
    throw BadInput("--output: " + command.output + " must end in .json or .csv");
  v1::MeasureTradeoffRequest request;
  *request.mutable_scene() = read_scene(command.scene, origin);
  if (command.horizon) request.set_horizon(*command.horizon);
  if (command.budget) request.set_budget(*command.budget);
  if (command.repeats) request.set_repeats(*command.repeats);

  const Answer answer = measure(request, command.server);
  print_warnings(answer.setup.warnings());
  print(answer, command.all);
  if (!command.output.empty()) {
    Destination destination(command.output);
    const File file = open_for_writing(destination.working_path());
    write(file.get(), json ? json_text(answer) : csv_text(answer));
    flush(file.get());
    destination.commit();
  }
  return reached;
}

void add_tradeoff(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<TradeoffCommand>();
  add_scene(app, command->scene);
  app->get_option("SCENE")->description("a scene, as of `stiefel run`; its method is ignored");
  app->add_option(
         "--horizon", command->horizon,
         "the time at which errors are measured; by default the scene's horizon, else 100 steps")
      ->type_name("T");
  app->add_option(
         "--budget", command->budget,
         "work in instructions; by default 5e10, about ten seconds. A point that needs more than "
         "its share is measured over a part of the horizon and extrapolated (marked ~)")
      ->type_name("B");
  app->add_flag("--all", command->all,
                "prints all points, and marks those of the Pareto front with *");
  app->add_option("--repeats", command->repeats, "timed runs of each point; by default 3")
      ->transform(whole_number())
      ->type_name("R");
  app->add_option("--output", command->output, "a .json or .csv file for all points")
      ->type_name("FILE");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {
        .file = command->scene.shown(),
        .options = {{"horizon", "--horizon"}, {"budget", "--budget"}, {"repeats", "--repeats"}}};
    chosen.run = [command](Origin& origin) { return tradeoff(*command, origin); };
  });
}

const Subcommand tradeoff_command(
    "tradeoff",
    "Measures error against cost of every method and prints the Pareto front: the points that no "
    "other point beats in both work and error",
    add_tradeoff);

}  // namespace

}  // namespace stiefel::cli
