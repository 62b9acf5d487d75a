#include "stiefel/client/recreation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "stiefel/client/connection.h"

namespace stiefel::client {
namespace {

using Stub = v1::SimulationService::Stub;

constexpr const char* session_key = "stiefel-session";
constexpr const char* numerics_key = "stiefel-numerics-id";
/// In instructions; about a second.
constexpr double work_between_checkpoints = 5e9;
constexpr double most_steps = 9007199254740992.0;  // 2^53

/// Returns whether `id` is a valid session id. Others are not sent as metadata, because gRPC aborts
/// on characters that HTTP does not allow.
bool routable(const std::string& id) {
  return !id.empty() && id.size() <= 128 && std::ranges::all_of(id, [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

std::string entry(const std::map<std::string, std::string>& metadata, const std::string& key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : found->second;
}

}  // namespace

Recreation::Recreation(std::shared_ptr<const Connection> connection, std::string session_id)
    : connection_(std::move(connection)), session_id_(std::move(session_id)) {}

Recreation::Recreation(std::shared_ptr<const Connection> connection, const v1::Session& session,
                       SceneSource scene, std::string checkpoint)
    : connection_(std::move(connection)),
      session_id_(session.session_id()),
      numerics_id_(session.numerics_id()),
      step_work_(session.step_price().work()),
      scene_(std::move(scene)) {
  // The step of the checkpoint with which the session was created is among the cached steps.
  const auto& steps = session.cached_steps();
  if (!checkpoint.empty())
    keep({steps.empty() ? 0 : *std::ranges::max_element(steps), std::move(checkpoint)});
}

void Recreation::check_not_deleted() const {
  const std::lock_guard lock(mutex_);
  if (ended_) throw session_deleted(session_id_);
}

void Recreation::route(grpc::ClientContext& context) const {
  check_not_deleted();
  if (routable(session_id_)) context.AddMetadata(session_key, session_id_);
}

void Recreation::check_build(const grpc::ClientContext& context, bool failed) const {
  if (connection_->options.any_build || numerics_id_.empty() || (failed && !scene())) return;
  const auto& metadata = context.GetServerInitialMetadata();
  const auto found = metadata.find(numerics_key);
  if (found == metadata.end()) return;
  const std::string now(found->second.data(), found->second.size());
  if (now != numerics_id_) throw BuildChanged(session_id_, numerics_id_, now);
}

bool Recreation::is_gone(const Error& error) const {
  return error.code() == grpc::StatusCode::UNAVAILABLE ||
         (error.reason() == "SESSION_NOT_FOUND" &&
          entry(error.metadata(), "session_id") == session_id_);
}

bool Recreation::recovers(const Error& error, const Deadline& deadline, Patience& pauses) {
  const SceneSource source = scene();
  if (!source || !is_gone(error)) return false;
  if (!pauses.allows_another(grpc::Status(grpc::StatusCode::UNAVAILABLE, ""))) return false;
  create(source, deadline);
  return true;
}

void Recreation::create(const SceneSource& source, const Deadline& deadline) {
  v1::CreateSessionRequest request;
  request.set_session_id(session_id_);
  *request.mutable_scene() = source();
  request.set_recreate(true);
  request.mutable_view()->set_scene(v1::SCENE_VIEW_NONE);
  v1::Session began;
  began.set_session_id(session_id_);
  began.set_numerics_id(numerics_id_);
  Recreation once(connection_, began, nullptr);
  const auto timeout = deadline.at_most(connection_->options.timeout);
  try {
    for (const Checkpoint& checkpoint : checkpoints()) {
      request.set_checkpoint(checkpoint.bytes);
      connection_->call(&Stub::CreateSession, request, timeout, &once);
    }
  } catch (const Error& error) {
    if (request.checkpoint().empty() || !refuses_checkpoint(error)) throw;
    if (error.reason() == "CHECKPOINT_OF_OTHER_NUMERICS" && !connection_->options.any_build)
      throw BuildChanged(session_id_, numerics_id_, entry(error.metadata(), "server_numerics_id"));
    forget();
    request.clear_checkpoint();
    connection_->call(&Stub::CreateSession, request, timeout, &once);
  }
  if (scene()) return;
  // The handle was deleted meanwhile, and its deletion may have arrived before the creation.
  v1::DeleteSessionRequest deletion;
  deletion.set_session_id(session_id_);
  connection_->call(&Stub::DeleteSession, deletion, timeout, &once);
}

bool Recreation::refuses_checkpoint(const Error& error) {
  return error.reason().starts_with("CHECKPOINT_") ||
         std::ranges::any_of(error.violations(),
                             [](const auto& v) { return v.field == "checkpoint"; });
}

Recreation::SceneSource Recreation::scene() const {
  const std::lock_guard lock(mutex_);
  return scene_;
}

void Recreation::end() {
  const std::lock_guard lock(mutex_);
  scene_ = nullptr;
  ended_ = true;
}

void Recreation::keep(Checkpoint checkpoint) {
  const std::lock_guard lock(mutex_);
  last_ = std::move(checkpoint);
  if (earliest_.bytes.empty() || last_.step < earliest_.step) earliest_ = last_;
}

void Recreation::forget() {
  const std::lock_guard lock(mutex_);
  earliest_ = last_ = {};
}

std::vector<Checkpoint> Recreation::checkpoints() const {
  const std::lock_guard lock(mutex_);
  if (earliest_.step == last_.step) return {last_};
  return {earliest_, last_};
}

bool Recreation::has_checkpoint() const {
  const std::lock_guard lock(mutex_);
  return !last_.bytes.empty();
}

std::int64_t Recreation::checkpoint_every() const {
  if (step_work_ <= 0 || !scene()) return 0;
  const double steps = std::min(work_between_checkpoints / step_work_, most_steps);
  return std::max<std::int64_t>(1, std::llround(steps));
}

bool Recreation::wants_checkpoint(std::int64_t to) const {
  const std::int64_t every = checkpoint_every();
  if (every == 0) return false;
  const std::lock_guard lock(mutex_);
  return std::ranges::none_of(std::array{std::int64_t{0}, earliest_.step, last_.step},
                              [&](std::int64_t step) { return step <= to && to - step < every; });
}

void Recreation::take(v1::StepResponse& reply, bool asked) {
  if (reply.checkpoint().empty()) return;
  keep({.step = reply.sample().step(), .bytes = reply.checkpoint()});
  if (!asked) reply.clear_checkpoint();
}

}  // namespace stiefel::client
