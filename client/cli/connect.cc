#include <algorithm>
#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/endpoint.h"
#include "client/cli/message_file.h"
#include "client/cli/report.h"

namespace stiefel::cli {
namespace {

/// "yes", "no" or "unknown".
std::string to_string(v1::Shortest shortest) {
  std::string name = v1::Shortest_Name(shortest).substr(std::string("SHORTEST_").size());
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

}  // namespace

ExitStatus connect(const ConnectCommand& command) {
  v1::ConnectRequest request;
  read_message(command.file, &request);
  const auto reply = Endpoint(command.server).client().geodesic(request);

  nlohmann::ordered_json out = {{"outcome", cli::to_string(reply.run_status().outcome())}};
  if (reply.has_scene()) {
    const auto scene = to_json(reply.scene());
    out["initial"] = scene["initial"];
    out["energy"] = reply.energy();
    out["residual"] = reply.residual();
    out["shortest"] = to_string(reply.shortest());
    out["distinct"] = reply.distinct();
    out["scene"] = scene;
  } else {
    out["residual"] = reply.residual();
    out["message"] = reply.run_status().message();
  }
  std::cout << to_text(out) << '\n';
  return conclude(reply.run_status(), 0);
}

}  // namespace stiefel::cli
