#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/session.h"

namespace stiefel::client {

/// A connection to a server. Thread-safe.
///
///     const auto client = Client::connect("localhost:50551");
///     const auto session = client.temporary(scene);
///     for (const Sample& sample : session.stream({.to = 1000, .every = 10})) ...
///
/// A call is repeated up to four times, within 4 s, while the server is UNAVAILABLE, and after the
/// delay that a refusal names; every call is idempotent. A stream is repeated until its first
/// message, a call of more than 256 MiB not at all.
class Client {
 public:
  /// Returns a client of the server at "host:port" or "unix:/path". Returns at once; the first call
  /// connects. Throws Error with the code INVALID_ARGUMENT for a malformed address (such as a port
  /// above 65535), for a token that would travel in plaintext beyond this machine, and for TLS
  /// files that cannot be read.
  static Client connect(const std::string& address, Options options = {});
  /// Uses a channel that the caller made, such as the in-process channel of a server. TLS, token
  /// and repetition of calls are then the channel's.
  explicit Client(std::shared_ptr<grpc::Channel> channel, Options options = {});

  /// Returns systems, methods, limits and versions. Throws Error.
  v1::DescribeResponse describe() const;

  /// Creates a session, or returns the existing one with this id and scene. An empty `id` is
  /// replaced by a new UUID. The session stays on the server until it is removed or idle for the
  /// server's `idle_timeout`. Throws Error.
  Session create(const v1::Scene& scene, const std::string& id = "") const;
  /// Creates the session of a request, which may bring a checkpoint. Throws Error.
  Session create(v1::CreateSessionRequest request) const;
  /// Creates a session that is deleted from the server when the last copy of the handle, and all
  /// samples, drives and forks that came from it, are destroyed: by a call of at most 5 s, whose
  /// failure is not told. Throws Error.
  Session temporary(const v1::Scene& scene) const;
  /// Returns a handle to an existing session. Throws Error.
  Session get(const std::string& id) const;
  /// Returns all sessions, ordered by id and without scenes. Throws Error.
  std::vector<v1::Session> list() const;
  /// Deletes a session; deleting an unknown id succeeds. Throws Error.
  void remove(const std::string& id) const;

  /// Returns the geodesics that join the request's pairs of frames, one for each pair, in their
  /// order. The run status of each tells whether it was found. Throws Error.
  std::vector<v1::ConnectResponse> geodesics(const v1::ConnectRequest& request) const;

  /// Makes any call. Returns the reply, such as a v1::DescribeResponse of
  /// `client.call(&Stub::Describe, v1::DescribeRequest())`, or for a call with a stream of replies,
  /// such as &Stub::MeasureTradeoff, a Replies. Throws Error.
  template <class Method, class Request>
  auto call(Method method, const Request& request) const {
    return client::call(connection_, method, request);
  }

 private:
  explicit Client(std::shared_ptr<const Connection> connection)
      : connection_(std::move(connection)) {}

  std::shared_ptr<const Connection> connection_;
};

}  // namespace stiefel::client
