#include <cmath>
#include <filesystem>
#include <iostream>
#include <numbers>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/embedded.h"
#include "client/cli/input/message_file.h"
#include "client/cli/input/scene_source.h"
#include "client/cli/interrupt.h"
#include "client/cli/options.h"
#include "client/cli/page/run_data.h"
#include "client/cli/progress/progress.h"
#include "client/cli/progress/tradeoff_progress.h"
#include "client/cli/report.h"
#include "client/cli/sinks/destination.h"

namespace stiefel::cli {
namespace {

/// Characters; the page of a larger scene has not the arrays of its initial state.
constexpr std::size_t largest_scene = 600'000;
/// Instructions of a measurement that nobody asked for: about a second.
constexpr double cheap_budget = 5e9;

struct ReportCommand {
  SceneSource scene;
  Remote server;
  std::string output;
  std::size_t member = 0;
  bool estimate_error = true;
  std::optional<bool> tradeoff;
};

/// Measures error against cost at the end of the run. Returns null where the scene has no
/// trade-off, such as that of a discrete system, or where a measurement that was not asked for
/// fails.
nlohmann::ordered_json tradeoff(const client::Client& client, const client::Session& session,
                                const ReportCommand& command, double horizon) {
  const auto& scene = session.scene();
  const bool asked = command.tradeoff.value_or(false);
  if (!command.tradeoff.value_or(scene.has_method() && !scene.has_members())) return nullptr;
  v1::MeasureTradeoffRequest request;
  *request.mutable_scene() = scene;
  if (!asked) request.set_budget(cheap_budget);
  if (horizon > 0) request.set_horizon(horizon);
  v1::TradeoffSetup setup;
  auto points = nlohmann::ordered_json::array();
  MeasuringLine line;
  try {
    client.tradeoff(request, [&](const v1::MeasureTradeoffResponse& part) {
      line.take(part);
      if (part.has_setup()) setup = part.setup();
      if (part.has_point()) {
        const auto& point = part.point();
        points.push_back({{"method", point.method().name()},
                          {"order", point.method().order()},
                          {"work", point.work()},
                          {"error", nullptr},
                          {"front", false}});
        if (point.run_status().outcome() == v1::OUTCOME_REACHED)
          points.back()["error"] = std::max(point.attitude_error(), point.momentum_error());
      }
      for (const auto i : part.front().points()) points.at(i)["front"] = true;
      return true;
    });
  } catch (const client::Error&) {
    if (interrupted()) throw Interrupted(line.how_far() + "; nothing was written");
    if (asked) throw;
    return nullptr;
  }
  if (points.empty()) return nullptr;
  return {{"horizon", setup.horizon()},
          {"reference_error", setup.reference_error()},
          {"points", std::move(points)}};
}

/// Returns the scene's `epoch`, which only clients read, or null.
nlohmann::ordered_json epoch(const SceneSource& source) {
  if (source.name == "-") return nullptr;  // which was read
  const auto json = nlohmann::ordered_json::parse(read_source(source.name), nullptr, false);
  return json.is_object() ? json.value("epoch", nlohmann::ordered_json()) : nullptr;
}

/// Returns the name by which the commands on the page call the scene: that of the file or the
/// example, or a name for what the page saves.
std::string called(const SceneSource& source) {
  if (source.name == "-" || !source.changes.empty()) return "scene.json";
  return std::filesystem::path(source.name).filename().string();
}

/// Returns what the page shows, as its script reads it.
nlohmann::ordered_json data(const client::Client& client, const client::Session& session,
                            const ReportCommand& command, const RunData& run) {
  const auto catalogue = client.describe();
  const auto& scene = session.scene();
  const auto system = std::ranges::find(catalogue.systems(), scene.system(), &v1::SystemInfo::name);
  if (system == catalogue.systems().end())
    throw std::runtime_error("the server does not describe " + scene.system());
  auto shown_scene = to_json(scene);
  const bool whole = shown_scene.dump().size() <= largest_scene;
  if (!whole) {
    shown_scene.erase("initial");
    shown_scene.erase("initial_tensors");
  }
  const auto epoch = cli::epoch(command.scene);
  if (!epoch.is_null()) shown_scene["epoch"] = epoch;
  const auto status = report(run.last.run_status(), run.last, session.choice());
  nlohmann::ordered_json out = {
      {"name", std::filesystem::path(command.scene.shown()).stem().string()},
      {"file", called(command.scene)},
      {"to", run.last.step()},
      {"member", nullptr},
      {"horizon", run.last.time()},
      {"turn", nullptr},
      {"outcome", to_string(run.last.run_status().outcome())},
      {"message", run.last.run_status().message()},
      {"choice", nullptr},
      {"epoch", epoch},
      {"version", catalogue.version()},
      {"numerics_id", session.description().numerics_id()},
      {"scene", std::move(shown_scene)},
      {"whole_scene", whole},
      {"samples", draw_samples(session, *system, run, command.member)},
      {"drift", run.drift},
      {"error", run.error},
      {"tradeoff", tradeoff(client, session, command, std::abs(run.last.time()))}};
  if (scene.has_members()) out["member"] = command.member;
  if (run.speed > 0) out["turn"] = 2 * std::numbers::pi / run.speed;
  if (session.choice() != nullptr) out["choice"] = session.choice()->reason();
  out["error"]["last"] = status["diagnosis"].value("estimated_error", nlohmann::ordered_json());
  return out;
}

/// Returns the page with the data. No text in these can end the script that holds them.
std::string page(const nlohmann::ordered_json& data) {
  std::string block;
  for (const char c : data.dump()) c == '<' ? block += "\\u003c" : block += c;
  std::string page(std::ranges::find(pages(), "page.html", &EmbeddedFile::name)->text);
  const auto put = [&](const std::string& place, std::string_view text) {
    page.replace(page.find(place), place.size(), text);
  };
  for (const EmbeddedFile& file : pages())
    if (file.name != "page.html") put(std::string("@").append(file.name) + "@", file.text);
  put("@DATA@", block);
  return page;
}

ExitStatus report_page(const ReportCommand& command, Origin& origin) {
  const v1::Scene scene = read_scene(command.scene, origin);
  const auto to = static_cast<std::int64_t>(std::ceil(end_in_steps(command.scene, scene)));
  if (command.member >= std::max(scene.members(), 1u))
    throw BadInput("--member: " + std::to_string(command.member) + " is not a member of the scene");
  const Endpoint endpoint(command.server);
  const auto session = endpoint.create(scene);
  print_remarks(session.description());
  Destination destination(command.output);
  const File file = open_for_writing(destination.working_path());
  RunData run;
  {
    const Progress progress(session, to);
    try {
      run = diagnose_run(session, to, error_estimation(command.estimate_error));
    } catch (const client::Error&) {
      if (interrupted()) throw Interrupted(progress.how_far() + "; nothing was written");
      throw;
    }
  }
  write(file.get(), page(data(endpoint.client(), session, command, run)));
  flush(file.get());
  destination.commit();
  show_summary(run.last);
  std::cout << "wrote " << command.output << '\n';
  return conclude(run.last.run_status(), run.last.step());
}

void add_report(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<ReportCommand>();
  add_run_of_scene(app, command->scene);
  app->add_option("--output", command->output, "the page; by default report.html")
      ->default_val("report.html")
      ->type_name("FILE.html");
  app->add_option("--member", command->member, "the member of an ensemble to draw; 0 by default")
      ->transform(whole_number())
      ->type_name("I");
  auto* always = app->add_flag_callback(
      "--tradeoff", [=] { command->tradeoff = true; },
      "measure error against cost of every method for about ten seconds; by default for about a "
      "second, and not for ensembles");
  app->add_flag_callback(
         "--no-tradeoff", [=] { command->tradeoff = false; }, "do not measure error against cost")
      ->excludes(always);
  app->add_flag_callback(
      "--no-error", [=] { command->estimate_error = false; },
      "do not estimate the error, which takes at most about ten seconds");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->scene.shown(),
                     .options = {{"to", command->scene.time ? "--time" : "--to"}}};
    chosen.run = [command](Origin& origin) { return report_page(*command, origin); };
  });
}

const Subcommand report_command(
    "report",
    "Runs a scene and writes an HTML page about it, which needs no network: the body turning in "
    "space, polhode, rates, drift beside the estimated error, error against cost, and the scene",
    add_report);

}  // namespace

}  // namespace stiefel::cli
