#include "engine/simulation/conversion.h"
#include "server/service/convert.h"
#include "server/service/errors.h"
#include "server/service/requests.h"
#include "server/service/service.h"
#include "server/service/walk_call.h"

namespace stiefel::server {
namespace {

/// The scene at the state of `now` with what the request changes.
OrStatus<Scene> forked(const Scene& from, const Simulation& now,
                       const v1::ForkSessionRequest& request) {
  auto scene = scene_at(from, now);
  if (!scene) return std::unexpected(errors::invalid(scene.error()));
  if (request.has_system() && request.system() != from.system()) {
    auto converted = convert(*scene, {request.system()});
    if (!converted) return std::unexpected(refused(converted.error()));
    if (!converted->scene)
      return std::unexpected(errors::invalid("system", request.system(), "must be a system"));
    scene = *std::move(converted->scene);
  }
  if (!request.has_method() && !request.has_step()) return *std::move(scene);
  v1::Scene changed;
  to_proto(scene->description(), &changed);
  // What was chosen was chosen for what it was.
  changed.clear_tolerance();
  changed.clear_choice();
  if (request.has_method()) *changed.mutable_method() = request.method();
  if (request.has_step()) changed.set_step(request.step());
  return read_scene(true, changed);
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
    return new WalkCall(host_, std::move(log), *std::move(from), request->from_step(),
                        [&host = host_, request, response](const Session& at, const Walk& walk) {
                          to_proto(walk, at.scene(), response->mutable_ending());
                          if (!walk.ending().reached()) return grpc::Status::OK;
                          auto scene = forked(at.scene(), walk.simulation(), *request);
                          if (!scene) return scene.error();
                          auto made = admit(host, request->session_id(), *std::move(scene));
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
