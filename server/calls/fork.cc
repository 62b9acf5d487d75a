#include "engine/simulation/scene/near_name.h"
#include "server/calls/cursor_call.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"
#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"

namespace stiefel::server {
namespace {

/// What the request does not change comes of the session it names.
Place inherited() { return Place::made_of("from_session_id"); }

/// The scene as a scene of another system.
OrStatus<Scene> in_system(const std::string& system, const Scene& scene) {
  if (catalogue().system(system) == nullptr)
    return std::unexpected(errors::invalid(
        "system", system,
        "must be a system" + did_you_mean(system, catalogue().systems, &SystemInfo::name)));
  ConversionTarget target{system};
  target.scene = inherited();
  target.to = "system";
  auto converted = convert(scene, target);
  if (!converted) return std::unexpected(refused(converted.error()));
  return *std::move(converted->scene);
}

/// The scene at the state of `now` with what the request changes.
OrStatus<Scene> forked(const Scene& from, const Simulation& now,
                       const v1::ForkSessionRequest& request) {
  auto scene = scene_at(from, now, Place::made_of("from_step"));
  if (!scene) return std::unexpected(errors::invalid(scene.error()));
  if (request.has_system() && request.system() != from.system()) {
    auto converted = in_system(request.system(), *scene);
    if (!converted) return converted;
    scene = *std::move(converted);
  }
  if (!request.has_method() && !request.has_step()) return *std::move(scene);
  Place place = inherited();
  SceneDescription changed = scene->description();
  // What was chosen was chosen for what it was.
  changed.tolerance.reset();
  changed.choice.clear();
  if (request.has_method()) {
    auto method = from_proto(request.method(), Place::inside("method"));
    if (!method) return std::unexpected(errors::invalid(method.error()));
    changed.method = *std::move(method);
    place.with("method", "method");
  }
  if (request.has_step()) {
    changed.step = request.step();
    place.with("step", "step");
  }
  auto resolved = Scene::resolve(std::move(changed), Scene::frame_tolerance, place);
  if (!resolved) return std::unexpected(errors::invalid(resolved.error()));
  return *std::move(resolved);
}

}  // namespace

grpc::ServerUnaryReactor* Service::ForkSession(Context* context,
                                               const v1::ForkSessionRequest* request,
                                               v1::ForkSessionResponse* response) {
  CallLog log(host_.log, *context, "ForkSession", request->session_id());
  const auto refuse = [&](const grpc::Status& status) {
    log.finish(status);
    auto* reactor = context->DefaultReactor();
    reactor->Finish(status);
    return reactor;
  };
  try {
    auto from = find_session(host_, request->from_session_id(), "from_session_id");
    if (!from) return refuse(from.error());
    if (const auto status = check_session_id(request->session_id()); !status.ok())
      return refuse(status);
    if (const auto status = check_step("from_step", request->from_step()); !status.ok())
      return refuse(status);
    return new CursorCall(
        host_, std::move(log), *std::move(from), request->from_step(),
        [&host = host_, request, response](const Session& at, const Cursor& cursor) {
          to_proto(cursor, at.scene(), response->mutable_run_status());
          if (!cursor.run_status().reached()) return grpc::Status::OK;
          auto scene = forked(at.scene(), cursor.simulation(), *request);
          if (!scene) return scene.error();
          auto made = admit(host, request->session_id(), *std::move(scene), inherited());
          if (!made) return made.error();
          to_proto(*made->session, host.registry, response->mutable_session());
          response->set_created(made->created);
          return grpc::Status::OK;
        });
  } catch (...) {
    return refuse(errors::from_current_exception());
  }
}

}  // namespace stiefel::server
