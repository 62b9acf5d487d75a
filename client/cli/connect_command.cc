#include <algorithm>
#include <iostream>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/endpoint.h"
#include "client/cli/input/message_file.h"
#include "client/cli/input/nested_numbers.h"
#include "client/cli/input/scene_source.h"
#include "client/cli/options.h"
#include "client/cli/progress/status_line.h"
#include "client/cli/report.h"

namespace stiefel::cli {
namespace {

struct ConnectCommand {
  std::string file;
  Remote server;
};

/// Returns "yes", "no", "unknown" or "none_shorter_found".
std::string answer(v1::Shortest shortest) {
  std::string name = v1::Shortest_Name(shortest).substr(std::string("SHORTEST_").size());
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

/// Reads a request. The file may give a single pair of frames without a list: {"Q_0", "Q_T", ...}.
v1::ConnectRequest read_request(const std::string& file, bool& single_pair) {
  v1::ConnectRequest request;
  v1::FramePair pair;
  parse_messages(file, read_source(file), {&request, &pair});
  single_pair = pair.has_q_0() || pair.has_q_t();
  if (single_pair && request.pairs_size() > 0)
    throw BadInput(file + ": pairs: must be absent when Q_0 or Q_T is given");
  if (single_pair) *request.add_pairs() = pair;
  return request;
}

nlohmann::ordered_json geodesic_json(const v1::ConnectResponse& geodesic) {
  nlohmann::ordered_json out = {{"outcome", to_string(geodesic.run_status().outcome())}};
  if (geodesic.run_status().outcome() == v1::OUTCOME_REACHED) {
    const auto scene = to_json(geodesic.scene());
    if (geodesic.has_scene()) out["initial"] = scene["initial"];
    if (geodesic.has_velocity()) out["velocity"] = as_lists(geodesic.velocity().value());
    out["energy"] = geodesic.energy();
    out["residual"] = geodesic.residual();
    out["shortest"] = answer(geodesic.shortest());
    out["distinct"] = geodesic.distinct();
    if (geodesic.has_scene()) out["scene"] = scene;
  } else {
    out["residual"] = geodesic.residual();
    out["message"] = geodesic.run_status().message();
  }
  return out;
}

/// Returns the exit status, and prints the first pair without a geodesic to stderr.
ExitStatus conclude_all(const std::vector<v1::ConnectResponse>& geodesics) {
  for (const auto& geodesic : geodesics) {
    const auto& status = geodesic.run_status();
    if (status.outcome() == v1::OUTCOME_REACHED) continue;
    std::cerr << "stiefel: pair " << geodesic.pair() << ": " << to_string(status.outcome()) << ": "
              << status.message() << '\n';
    return numerical_stop;
  }
  return reached;
}

ExitStatus connect(const ConnectCommand& command, Origin& origin) {
  const auto request = read_request(command.file, origin.single_pair);
  const Endpoint endpoint(command.server);
  const auto geodesics = [&] {
    const ElapsedLine line("connecting frames");
    return endpoint.client().geodesics(request);
  }();

  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const auto& geodesic : geodesics) all.push_back(geodesic_json(geodesic));
  std::cout << to_text(origin.single_pair ? all.at(0) : nlohmann::ordered_json{{"geodesics", all}})
            << '\n';
  return conclude_all(geodesics);
}

void add_connect(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<ConnectCommand>();
  app->add_option(
         "FILE", command->file,
         "{inertia, Q_0, Q_T, time}, or {inertia, pairs: [{Q_0, Q_T}, ...], time}: the JSON "
         "form of stiefel.v1.ConnectRequest, in which a frame may also be a list of its rows; - "
         "for "
         "stdin; or the example frames")
      ->required()
      ->type_name("FILE.json");
  add_server(app, command->server);
  app->callback([=, &chosen] {
    chosen.origin = {.file = command->file, .whole_request = true};
    chosen.run = [command](Origin& origin) { return connect(*command, origin); };
  });
}

const Subcommand connect_command("connect",
                                 "Finds the geodesics that join pairs of frames in a given time",
                                 add_connect);

}  // namespace

}  // namespace stiefel::cli
