#include "stiefel/client/session.h"

#include <algorithm>
#include <mutex>

#include "client/cpp/resolved_scene.h"
#include "client/cpp/scene_arrays.h"
#include "client/cpp/step_by_stream.h"
#include "client/cpp/uuid.h"
#include "client/cpp/verify.h"

namespace stiefel::client {

using Stub = v1::SimulationService::Stub;

/// The resolved scene, whole once the arrays left out of the description have arrived.
struct Session::ResolvedScene {
  std::mutex mutex;
  bool whole;
  v1::Scene scene;
};

Session::Session(std::shared_ptr<const Connection> connection, v1::Session description,
                 v1::Scene base, bool kept)
    : connection_(std::move(connection)),
      description_(std::move(description)),
      scene_(std::make_shared<ResolvedScene>()),
      kept_(kept) {
  verify(description_, "the scene of session " + id());
  scene_->whole = description_.left_out().empty();
  scene_->scene = resolved_scene(std::move(base), description_.scene(), description_.cleared(),
                                 description_.left_out());
}

Session::~Session() {
  if (!connection_ || kept_) return;
  // One attempt: the server drops an idle session by itself.
  v1::DeleteSessionRequest request;
  request.set_session_id(id());
  v1::DeleteSessionResponse reply;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + connection_->options.timeout);
  connection_->stub->DeleteSession(&context, request, &reply);
}

const v1::Scene& Session::scene() const {
  const std::lock_guard lock(scene_->mutex);
  if (!scene_->whole) {
    const auto& left_out = description_.left_out();
    for (const auto& array : scene_arrays(*connection_, id())) {
      if (std::ranges::find(left_out, array.name()) != left_out.end())
        set_array(array, &scene_->scene);
    }
    scene_->whole = true;
  }
  return scene_->scene;
}

v1::Session Session::refresh() const {
  v1::GetSessionRequest request;
  request.set_session_id(id());
  request.mutable_view()->set_scene(v1::SCENE_VIEW_NONE);
  auto reply = connection_->call(&Stub::GetSession, request, connection_->options.timeout);
  return std::move(*reply.mutable_session());
}

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields,
                               bool return_checkpoint) const {
  v1::StepRequest request;
  request.set_session_id(id());
  request.set_to(to);
  request.mutable_fields()->Assign(fields.begin(), fields.end());
  request.set_return_checkpoint(return_checkpoint);
  request.set_checksum(connection_->options.checksums);
  try {
    auto reply = connection_->call(&Stub::Step, request, connection_->options.compute_timeout);
    verify(reply.sample(), "the state at step " + std::to_string(to));
    return reply;
  } catch (const Error& error) {
    if (!is_too_large(error)) throw;
  }
  return step_by_stream(connection_, request);
}

v1::StepResponse Session::step(std::int64_t to, const std::vector<std::string>& fields) const {
  return step(to, fields, false);
}

v1::StepResponse Session::checkpoint(std::int64_t to) const { return step(to, {}, true); }

Drive Session::drive() const { return {connection_, id()}; }

Stream Session::stream(Range range) const { return {connection_, id(), std::move(range)}; }

v1::DiagnoseResponse Session::diagnose(std::int64_t to,
                                       const std::vector<std::string>& invariants) const {
  v1::DiagnoseRequest request;
  request.set_to(to);
  request.mutable_invariants()->Assign(invariants.begin(), invariants.end());
  return diagnose(std::move(request));
}

v1::DiagnoseResponse Session::diagnose(v1::DiagnoseRequest request) const {
  request.set_session_id(id());
  request.set_checksum(connection_->options.checksums);
  auto reply = connection_->call(&Stub::Diagnose, request, connection_->options.compute_timeout);
  verify(reply, "the diagnosis of step " + std::to_string(request.to()));
  return reply;
}

Session Session::fork(v1::ForkSessionRequest request) const {
  request.set_from_session_id(id());
  if (request.session_id().empty()) request.set_session_id(make_uuid());
  request.mutable_view()->set_scene(v1::SCENE_VIEW_FILLED_IN);
  request.mutable_view()->set_checksum(connection_->options.checksums);
  auto reply = connection_->call(&Stub::ForkSession, request, connection_->options.compute_timeout);
  if (!reply.has_session())
    throw Error(grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, reply.run_status().message()));
  return Session(connection_, std::move(*reply.mutable_session()), scene(), false);
}

}  // namespace stiefel::client
