#include "stiefel/client/session.h"

#include <algorithm>
#include <mutex>

#include "client/cpp/late.h"
#include "client/cpp/replies.h"
#include "client/cpp/resolved_scene.h"
#include "client/cpp/scene_arrays.h"
#include "client/cpp/step_by_stream.h"
#include "client/cpp/uuid.h"

namespace stiefel::client {

using Stub = v1::SimulationService::Stub;

/// The resolved scene, whole once the arrays left out of the description have arrived.
struct Session::ResolvedScene {
  std::mutex mutex;
  bool whole;
  v1::Scene scene;
  v1::Scene sent;  ///< the caller's scene; empty once `scene` is whole

  /// Returns the scene that creates the session again.
  v1::Scene creating() {
    const std::lock_guard lock(mutex);
    return whole ? scene : sent;
  }
};

Session::Session(std::shared_ptr<const Connection> connection, v1::Session description,
                 v1::Scene base, bool kept, std::string checkpoint)
    : connection_(std::move(connection)),
      description_(std::move(description)),
      scene_(std::make_shared<ResolvedScene>()),
      kept_(kept) {
  scene_->whole = description_.left_out().empty();
  if (!scene_->whole) scene_->sent = base;
  scene_->scene = resolved_scene(std::move(base), description_.scene(), description_.cleared(),
                                 description_.left_out());
  Recreation::SceneSource source;
  if (!kept) source = [scene = scene_] { return scene->creating(); };
  recreation_ = std::make_shared<Recreation>(connection_, description_, std::move(source),
                                             std::move(checkpoint));
}

Session::~Session() {
  if (!connection_ || kept_) return;
  recreation_->end();
  // One attempt is enough: the server drops an idle session by itself.
  v1::DeleteSessionRequest request;
  request.set_session_id(id());
  v1::DeleteSessionResponse reply;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + connection_->options.timeout);
  Recreation(connection_, id()).route(context);
  connection_->stub->DeleteSession(&context, request, &reply);
}

const v1::Scene& Session::scene() const { return scene(*recreation_); }

const v1::Scene& Session::scene(Recreation& handle) const {
  const auto whole = [this] {
    const std::lock_guard lock(scene_->mutex);
    return scene_->whole;
  };
  if (whole()) return scene_->scene;
  // Without the lock, because `handle` may need the scene to create the session again.
  const Fields arrays = scene_arrays(*connection_, id(), handle);
  const std::lock_guard lock(scene_->mutex);
  if (scene_->whole) return scene_->scene;
  const auto& left_out = description_.left_out();
  for (const std::string& path : left_out) {
    const auto found = std::ranges::find(arrays, path, &v1::Field::name);
    require(found != arrays.end(), "the scene's array " + path + " is missing");
    set_array(*found, &scene_->scene);
  }
  scene_->whole = true;
  scene_->sent.Clear();
  return scene_->scene;
}

v1::Session Session::refresh() const {
  v1::GetSessionRequest request;
  request.set_session_id(id());
  request.mutable_view()->set_scene(v1::SCENE_VIEW_NONE);
  auto reply = connection_->call(&Stub::GetSession, request, connection_->options.timeout,
                                 recreation_.get());
  check_session(reply.session(), id(), false);
  return std::move(*reply.mutable_session());
}

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields,
                               bool return_checkpoint) const {
  v1::StepRequest request;
  request.set_session_id(id());
  request.set_to(to);
  request.mutable_fields()->Assign(fields.begin(), fields.end());
  request.set_return_checkpoint(return_checkpoint || recreation_->wants_checkpoint(to));
  v1::StepResponse reply;
  try {
    reply = in_time(*connection_, id(), to, [&] {
      return connection_->call(&Stub::Step, request, connection_->options.compute_timeout,
                               recreation_.get());
    });
    check_step(reply, to, request.fields(), request.return_checkpoint());
  } catch (const Error& error) {
    if (!is_too_large(error)) throw;
    reply = step_by_stream(connection_, request, recreation_);
  }
  recreation_->take(reply, return_checkpoint);
  return reply;
}

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields) const {
  return step(to, fields, false);
}

v1::StepResponse Session::checkpoint(std::int64_t to) const { return step(to, {}, true); }

Drive Session::drive() const { return {connection_, id(), recreation_}; }

Stream Session::stream(Range range) const {
  return {connection_, id(), std::move(range), recreation_};
}

v1::DiagnoseResponse Session::diagnose(std::int64_t to,
                                       const std::vector<std::string>& invariants) const {
  v1::DiagnoseRequest request;
  request.set_to(to);
  request.mutable_invariants()->Assign(invariants.begin(), invariants.end());
  return diagnose(std::move(request));
}

void Session::answer(const google::protobuf::Message& request,
                     const google::protobuf::Message& reply,
                     const std::function<void()>& call) const {
  in_time(*connection_, id(), last_step(request), call);
  check_reply(reply, request);
}

v1::DiagnoseResponse Session::diagnose(v1::DiagnoseRequest request) const {
  auto reply = call(&Stub::Diagnose, request);
  check_diagnosis(reply, request);
  return reply;
}

Session Session::fork(v1::ForkSessionRequest request) const {
  request.set_from_session_id(id());
  if (request.session_id().empty()) request.set_session_id(make_uuid());
  request.mutable_view()->set_scene(v1::SCENE_VIEW_FILLED_IN);
  const auto ask = [&] {
    auto reply = in_time(*connection_, id(), request.from_step(), [&] {
      return connection_->call(&Stub::ForkSession, request, connection_->options.compute_timeout,
                               recreation_.get());
    });
    check_outcome(reply.run_status());
    if (reply.run_status().outcome() != v1::OUTCOME_REACHED)
      throw Error(
          grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, reply.run_status().message()));
    check_session(reply.session(), request.session_id(), true);
    return std::move(*reply.mutable_session());
  };
  Session forked(connection_, ask(), scene(), false);
  // Fetches the arrays that this client never had: without them the fork could not be recreated.
  // Until they are here, only this session can make a lost fork again.
  Recreation handle(connection_, forked.description(), nullptr);
  auto pauses = connection_->patience_to_recover(Deadline(connection_->options.compute_timeout));
  while (true) {
    try {
      forked.scene(handle);
      return forked;
    } catch (const Error& error) {
      if (!handle.is_gone(error) ||
          !pauses.allows_another(grpc::Status(grpc::StatusCode::UNAVAILABLE, "")))
        throw;
    }
    ask();
  }
}

}  // namespace stiefel::client
