#include "remote.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <stdexcept>

#include "stiefel/client/client.h"

namespace {

/// Closing its stdin stops the server; pclose waits for it.
struct Stop {
  void operator()(std::FILE* server) const { pclose(server); }
};
using Server = std::unique_ptr<std::FILE, Stop>;

stiefel::v1::Scene message(const stiefel::SceneDescription& description) {
  stiefel::v1::Scene scene;
  scene.set_system(description.system);
  scene.mutable_method()->set_name(description.method->name);
  scene.mutable_inertia()->Add(description.inertia.begin(), description.inertia.end());
  for (const auto& [name, block] : description.initial) {
    auto& matrix = (*scene.mutable_initial())[name];
    const stiefel::RowMatrix& values = block.values;
    matrix.set_rows(static_cast<std::uint32_t>(values.rows()));
    matrix.set_cols(static_cast<std::uint32_t>(values.cols()));
    matrix.mutable_values()->Add(values.data(), values.data() + values.size());
  }
  scene.set_step(*description.step);
  return scene;
}

}  // namespace

Eigen::MatrixXd remote_momentum(const std::string& program,
                                const stiefel::SceneDescription& description, std::int64_t to) {
  const std::string address = "unix:consumer." + std::to_string(getpid());
  const std::string command = "'" + program + "' --listen " + address + " --exit-with-parent";
  const Server server(popen(command.c_str(), "w"));
  if (!server) throw std::runtime_error("cannot run " + program);

  // The client is patient while the server starts.
  const auto client =
      stiefel::client::Client::connect(address, {.patience = std::chrono::seconds(30)});
  const auto session = client.create(message(description));
  const auto reply = session.step(to, {"M"});
  const auto M = stiefel::client::field(reply.sample(), "M");
  return Eigen::Map<const stiefel::RowMatrix>(M.values.data(), static_cast<Eigen::Index>(M.rows),
                                              static_cast<Eigen::Index>(M.cols));
}
