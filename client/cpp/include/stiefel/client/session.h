#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/call.h"
#include "stiefel/client/drive.h"
#include "stiefel/client/samples.h"

namespace stiefel::client {

/// The samples at from, from + every, ... and always at `to`.
struct Range {
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::int64_t every = 1;
  /// When empty: quaternion and angular_velocity in a scene with `body`, else the system's blocks.
  std::vector<std::string> fields = {};
};

/// A handle to a simulation held by a server: a pure function from step index to state. Steps are
/// absolute and ≥ 0. Copies are handles to the same session, which stays on the server when they
/// are gone unless `Client::temporary` made it. Thread-safe: several threads may call it at once.
class Session {
 public:
  /// `description`: the server's reply about the session.
  Session(std::shared_ptr<const Connection> connection, v1::Session description)
      : connection_(std::move(connection)), description_(std::move(description)) {}

  const std::string& id() const { return description_.session_id(); }
  /// The server's description when this handle began. Its `scene` is the resolved scene, with every
  /// default filled in.
  const v1::Session& description() const { return description_; }

  /// Returns the state at step `to`, or the last good one if the run ended before; see the reply's
  /// run status. `fields`: as Range::fields. Throws Error.
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields = {}) const;
  /// Opens a call for many steps in a tight loop.
  Drive drive() const { return {connection_, id()}; }
  /// Opens a stream of samples.
  Samples stream(const Range& range) const;
  /// Opens the stream of a request, which may ask for checkpoints; the session's id is filled in.
  Samples stream(v1::StreamRequest request) const;
  /// Creates a session that starts from this one's state at the step `from_step`, with the changes
  /// that the request names. An empty `session_id` is replaced by a new UUID; `from_session_id` is
  /// filled in. Throws Error, also when the step cannot be reached.
  Session fork(v1::ForkSessionRequest request) const;

  /// Makes any call about this session; its id is filled in. Returns the reply, such as a
  /// v1::DiagnoseResponse of `session.call(&Stub::Diagnose, request)`, or for a call with a stream
  /// of replies, such as &Stub::Summarize, a Replies. Throws Error.
  template <class Method, class Request>
  auto call(Method method, Request request) const {
    if constexpr (requires { request.from_session_id(); })
      request.set_from_session_id(id());
    else
      request.set_session_id(id());
    return client::call(connection_, method, request);
  }

 private:
  /// For a temporary session, its last copy deletes the session.
  std::shared_ptr<const Connection> connection_;
  v1::Session description_;
};

}  // namespace stiefel::client
