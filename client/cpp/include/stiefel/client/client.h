#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/session.h"

namespace stiefel::client {

/// A connection to a server. Thread-safe.
///
///     auto client = Client::connect("localhost:50551");
///     auto session = client.create(scene);
///     for (const SampleView sample : session.stream({.to = 1000, .every = 10})) ...
class Client {
 public:
  /// "host:port" or "unix:/path". Returns at once; the first call connects. Throws Error of the
  /// code INVALID_ARGUMENT for what is no address, such as a port above 65535, for a token that
  /// would travel in plaintext beyond this machine, and for files of TLS that cannot be read.
  static Client connect(const std::string& address, Options options = {});
  /// Over a channel of the caller's, such as a server's in-process one.
  explicit Client(std::shared_ptr<grpc::Channel> channel, Options options = {});

  v1::DescribeResponse describe() const;

  /// The id is a new UUID if it is empty; a checkpoint fills the new session's cache. With the id
  /// of an existing session of the same scene it is that session. Throws Error.
  Session create(const v1::Scene& scene, std::string id = "", std::string checkpoint = "") const;
  /// A session that exists; it stays when the handle goes.
  Session attach(const std::string& id) const;
  /// All of them, ordered by id; without scenes.
  std::vector<v1::Session> list() const;
  /// Deleting an unknown id succeeds.
  void remove(const std::string& id) const;

  /// A motion in the variables of another system: a whole scene, or blocks.
  /// Throws Error.
  v1::ConvertResponse convert(v1::ConvertRequest request) const;
  /// The geodesics that join the request's pairs of frames, one for each pair in their order; see
  /// each one's run status. Throws Error.
  std::vector<v1::ConnectResponse> geodesics(v1::ConnectRequest request) const;
  /// Error against cost: `receive` gets each part of the answer as it arrives, and ends the
  /// measurement by returning false. Throws Error.
  using TradeoffReceiver = std::function<bool(const v1::MeasureTradeoffResponse&)>;
  void tradeoff(const v1::MeasureTradeoffRequest& request, const TradeoffReceiver& receive) const;

 private:
  explicit Client(Connection connection);

  std::shared_ptr<const Connection> connection_;
};

}  // namespace stiefel::client
