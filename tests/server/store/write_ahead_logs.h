#pragma once

#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/sessions/identity.h"
#include "server/sessions/registry.h"
#include "server/sessions/store/journal.h"
#include "tests/server/scene_cases.h"

namespace stiefel::test {

/// A scene for each number.
inline Scene numbered_scene(int number) {
  auto description = test::description();
  description.step = 0.01 + 1e-6 * number;
  return Scene::resolve(description).value();
}

/// The row of a session whose scene is written as its identity.
inline server::StoredSession identity_row(const server::Session& session) {
  return {session.owner(),    session.id(), 0,  "n",         server::hash(session.identity()),
          session.identity(), "",           "", std::nullopt};
}

/// A registry that writes into a store.
struct Written {
  explicit Written(const server::StoreOptions& options,
                   std::chrono::milliseconds between_checkpoints = std::chrono::hours(1))
      : store(options),
        journal(store,
                {identity_row, [this](const server::Session& session) { registry.drop(session); },
                 [this](const server::WriteFault& fault) {
                   const std::lock_guard lock(mutex);
                   reports.push_back(fault.what);
                 }},
                between_checkpoints) {
    registry.write_to(journal);
  }

  std::shared_ptr<server::PendingWrite> create(const std::string& id, int scene = 0) {
    return registry.create(everybody, id, numbered_scene(scene), "").value().pending_write;
  }

  server::Registry registry{100'000, std::chrono::hours(1), {}};
  std::mutex mutex;
  std::vector<std::string> reports;
  server::Store store;
  server::Journal journal;
};

/// Waits for the outcome.
inline std::optional<server::WriteFault> outcome(server::PendingWrite& pending_write) {
  std::promise<std::optional<server::WriteFault>> promise;
  pending_write.then([&](const auto& fault) { promise.set_value(fault); });
  return promise.get_future().get();
}

/// What is in a store that nobody has open: the scene's bytes by the session's id.
inline std::map<std::string, std::string> stored(const std::string& file) {
  server::Store store({file});
  server::Store::Reader reader(store);
  std::map<std::string, std::string> all;
  while (const auto row = reader.next()) all[row->session.id] = row->session.scene;
  return all;
}

}  // namespace stiefel::test
