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
  /// Returns a client of the server at "host:port" or "unix:/path". Returns at once; the first call
  /// connects. Throws Error with the code INVALID_ARGUMENT for a malformed address (such as a port
  /// above 65535), for a token that would travel in plaintext beyond this machine, and for TLS
  /// files that cannot be read.
  static Client connect(const std::string& address, Options options = {});
  /// Uses a channel that the caller made, such as the in-process channel of a server.
  explicit Client(std::shared_ptr<grpc::Channel> channel, Options options = {});

  v1::DescribeResponse describe() const;

  /// Creates a session, or returns the existing one with this id and scene. An empty `id` is
  /// replaced by a new UUID; a checkpoint fills the new session's cache. Throws Error.
  Session create(const v1::Scene& scene, std::string id = "", std::string checkpoint = "") const;
  /// Returns a handle to an existing session, which its destruction leaves on the server. Throws
  /// Error.
  Session attach(const std::string& id) const;
  /// Returns all sessions, ordered by id and without scenes. Throws Error.
  std::vector<v1::Session> list() const;
  /// Deletes a session; deleting an unknown id succeeds. Throws Error.
  void remove(const std::string& id) const;

  /// Converts a motion to the variables of another system. The reply has a whole scene, or blocks
  /// if the target is not a system. Throws Error.
  v1::ConvertResponse convert(v1::ConvertRequest request) const;
  /// Returns the geodesics that join the request's pairs of frames, one for each pair, in their
  /// order. The run status of each tells whether it was found. Throws Error.
  std::vector<v1::ConnectResponse> geodesics(v1::ConnectRequest request) const;
  /// Returns the conjugate points along a geodesic, or bounds of the injectivity radius. The run
  /// status tells whether the search was completed. Throws Error.
  v1::ConjugatePointsResponse conjugate_points(const v1::ConjugatePointsRequest& request) const;
  /// Measures error against cost. `receive` gets each part of the answer as it arrives and ends the
  /// measurement by returning false. Throws Error.
  using TradeoffReceiver = std::function<bool(const v1::MeasureTradeoffResponse&)>;
  void tradeoff(v1::MeasureTradeoffRequest request, const TradeoffReceiver& receive) const;

 private:
  explicit Client(Connection connection);

  std::shared_ptr<const Connection> connection_;
};

}  // namespace stiefel::client
