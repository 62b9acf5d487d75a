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

/// A state that Client::create accepts.
struct Checkpoint {
  std::int64_t step = 0;
  std::string bytes;
};

/// What the calls of one handle share: the name that proxies route them by, the build that replies
/// are compared with and, in the handle that created the session, the scene and two checkpoints,
/// from which any server goes on where the session's own is gone: the last one, and the earliest
/// for calls that go back. Thread-safe.
class Recreation {
 public:
  using SceneSource = std::function<v1::Scene()>;

  /// Of a handle that only knows the session's name.
  Recreation(std::shared_ptr<const Connection> connection, std::string session_id);
  /// `session`: as it was when the handle began. `scene` gives what creates it again; without it
  /// the handle creates nothing.
  Recreation(std::shared_ptr<const Connection> connection, const v1::Session& session,
             SceneSource scene, std::string checkpoint = "");

  /// Throws Error, reason SESSION_DELETED, if this handle has deleted its session.
  void check_not_deleted() const;
  /// Gives a call the metadata `stiefel-session`, if a server could have a session of that name.
  /// Throws like `check_not_deleted`.
  void route(grpc::ClientContext& context) const;
  /// After a reply, or after a call has failed: throws BuildChanged if the server that answered
  /// computes other bits than the one where the handle began, unless Options::any_build.
  void check_build(const grpc::ClientContext& context, bool failed) const;

  /// Whether the error means that the session or its server is gone and this handle creates it
  /// again. If so it has done so, after a pause, which is counted by `pauses`; false also when
  /// these are used up. Throws Error.
  bool recovers(const Error& error, const Deadline& deadline, Patience& pauses);
  /// From now on this handle creates nothing and finds nothing, at no server: it deletes the
  /// session.
  void end();

  /// The session goes on from there if it is created again.
  void keep(Checkpoint checkpoint);
  bool has_checkpoint() const;
  /// Steps of a stream between two checkpoints, about a second of priced work; 0: none.
  std::int64_t checkpoint_every() const;
  /// Whether the way from a checkpoint, or from step 0, is so long that a new one is worth its
  /// bytes.
  bool wants_checkpoint(std::int64_t to) const;
  /// Keeps the checkpoint of a reply, which goes on to the caller only if it was `asked` for.
  void take(v1::StepResponse& reply, bool asked);

 private:
  bool is_gone(const Error& error) const;
  void create(const SceneSource& scene, const Deadline& deadline);
  /// Those that there are, the earliest first; one without bytes if there is none.
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
