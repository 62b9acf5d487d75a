#pragma once

#include <grpcpp/client_context.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "stiefel/client/error.h"
#include "stiefel/v1/session.pb.h"

namespace stiefel::v1 {
class StepResponse;
}

namespace stiefel::client {

struct Connection;
class Deadline;
class Patience;

/// A saved state of a session, which Client::create accepts.
struct Checkpoint {
  std::int64_t step = 0;
  std::string bytes;
};

/// What the calls of one session handle share: the id by which proxies route them, and the build
/// with which replies are compared. The handle that created the session also keeps its scene and
/// two checkpoints, so that any server can take the session over when its own server is gone: the
/// last checkpoint, and the earliest one for calls that go back. Thread-safe.
class Recreation {
 public:
  using SceneSource = std::function<v1::Scene()>;

  /// For a handle that knows only the session's id and cannot create the session again.
  Recreation(std::shared_ptr<const Connection> connection, std::string session_id);
  /// `session`: the description that the handle got first. `scene`: returns the scene that creates
  /// the session again; null if the handle must not create it. `checkpoint`: the checkpoint with
  /// which the session was created.
  Recreation(std::shared_ptr<const Connection> connection, const v1::Session& session,
             SceneSource scene, std::string checkpoint = "");

  /// Throws Error, reason SESSION_DELETED, if this handle has deleted its session.
  void check_not_deleted() const;
  /// Adds the metadata `stiefel-session` to a call, unless no server accepts such an id. Throws
  /// Error, reason SESSION_DELETED, if this handle has deleted its session.
  void route(grpc::ClientContext& context) const;
  /// Throws BuildChanged if the server that answered a call computes other bits than the server
  /// where the handle began, unless Options::any_build. `failed`: whether the call has failed.
  void check_build(const grpc::ClientContext& context, bool failed) const;

  /// Creates the session again, after a pause, if the error means that the session or its server is
  /// gone. Returns whether it did so: false if this handle must not create it, or if `pauses` are
  /// used up. Throws Error.
  bool recovers(const Error& error, const Deadline& deadline, Patience& pauses);
  /// Returns whether the error means that the session or its server is gone.
  bool is_gone(const Error& error) const;
  /// Returns whether a server did not take the checkpoint of a request.
  static bool refuses_checkpoint(const Error& error);
  /// Call this before deleting the session: the handle never creates it again, and later calls
  /// throw SESSION_DELETED.
  void end();

  /// Keeps a checkpoint, with which the session is created again if necessary.
  void keep(Checkpoint checkpoint);
  bool has_checkpoint() const;
  /// Returns how many steps of a stream lie between two checkpoints: about a second of priced work.
  /// 0 if no checkpoints are needed.
  std::int64_t checkpoint_every() const;
  /// Returns whether neither step 0 nor a kept checkpoint lies within the `checkpoint_every()`
  /// steps before `to`, so that a checkpoint there is worth its bytes.
  bool wants_checkpoint(std::int64_t to) const;
  /// Keeps the checkpoint of a reply, and removes it from the reply unless the caller `asked` for
  /// it.
  void take(v1::StepResponse& reply, bool asked);

 private:
  void create(const SceneSource& scene, const Deadline& deadline);
  /// Returns the kept checkpoints, the earliest first; a single one without bytes if there is none.
  std::vector<Checkpoint> checkpoints() const;
  void forget();
  SceneSource scene() const;

  const std::shared_ptr<const Connection> connection_;
  const std::string session_id_;
  const std::string numerics_id_;
  const double step_work_ = 0;
  mutable std::mutex mutex_;
  SceneSource scene_;           // guarded by mutex_
  bool ended_ = false;          // guarded by mutex_
  Checkpoint earliest_, last_;  // guarded by mutex_; without bytes until there is one
};

}  // namespace stiefel::client
