#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/cpp/session.h"

namespace stiefel::client {

/// A server, seen from here. Thread-safe.
///
///     auto client = Client::connect("localhost:50551");
///     auto session = client.create(scene);
///     for (const SampleView sample : session.stream({.to = 1000, .every = 10})) ...
class Client {
 public:
  /// "host:port" or "unix:/path". Returns at once; the first call connects.
  static Client connect(const std::string& address, Options options = {});
  /// Over a channel of the caller's, such as a server's in-process one.
  explicit Client(std::shared_ptr<grpc::Channel> channel, Options options = {});

  v1::DescribeResponse describe() const;

  /// The id is a new UUID if it is empty; a checkpoint fills the new session's cache. With the id
  /// of an existing session of the same scene it is that session. Throws Error.
  Session create(const v1::Scene& scene, std::string id = "", std::string checkpoint = "") const;
  /// A session that exists; it stays when the handle goes.
  Session attach(const std::string& id) const;
  /// All of them, ordered by id.
  std::vector<v1::Session> list() const;
  /// Deleting an unknown id succeeds.
  void remove(const std::string& id) const;

 private:
  explicit Client(Connection connection);

  std::shared_ptr<const Connection> connection_;
};

/// A random UUID (version 4).
std::string make_uuid();

}  // namespace stiefel::client
