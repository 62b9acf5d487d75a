#include "server/service/service.h"

#include <google/protobuf/util/time_util.h>

#include <utility>

#include "server/service/convert.h"
#include "server/service/errors.h"
#include "server/service/limits.h"
#include "server/service/requests.h"
#include "server/service/walk_call.h"

namespace stiefel::server {
namespace {

// Above it, resolving a scene and making its simulation is work for the pool.
constexpr int small_dimension = 32;

grpc::Status create(Host& host, const v1::CreateSessionRequest& request,
                    v1::CreateSessionResponse* response) {
  if (!request.has_scene()) return errors::invalid("scene", "", "must be there");
  auto description = from_proto(request.scene());
  if (!description) return errors::invalid(description.error());
  auto scene = Scene::resolve(*std::move(description));
  if (!scene) return errors::invalid(scene.error());
  auto created =
      host.registry.create(request.session_id(), *std::move(scene), request.checkpoint());
  if (created) {
    to_proto(*created->session, host.registry, response->mutable_session());
    response->set_created(created->created);
    return grpc::Status::OK;
  }
  if (const auto* conflict = std::get_if<Registry::Conflict>(&created.error())) {
    return *conflict == Registry::Conflict::other_scene
               ? errors::session_has_other_scene(request.session_id())
               : errors::too_many_sessions(host.registry.max_sessions());
  }
  const auto& refusal = std::get<CheckpointRefusal>(created.error());
  const std::string value = std::to_string(request.checkpoint().size()) + " bytes";
  switch (refusal.fault) {
    case CheckpointFault::other_build:
      return errors::checkpoint_of_other_build(refusal.build, build_fingerprint());
    case CheckpointFault::other_scene:
      return errors::invalid("checkpoint", value, "must come from a session of the same scene");
    case CheckpointFault::corrupt:
      break;
  }
  return errors::invalid("checkpoint", value, "must be what Step returned: it is damaged");
}

}  // namespace

template <class Work>
grpc::ServerUnaryReactor* Service::answer(Context* context, CallLog log, Work work) {
  grpc::Status status;
  try {
    status = work();
  } catch (...) {
    status = errors::from_current_exception();
  }
  log.finish(status);
  auto* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

grpc::ServerUnaryReactor* Service::Describe(Context* context, const v1::DescribeRequest*,
                                            v1::DescribeResponse* response) {
  return answer(context, CallLog(host_.log, *context, "Describe"), [&] {
    response->set_version(STIEFEL_VERSION);
    response->set_build(build_fingerprint());
    auto* limits = response->mutable_limits();
    limits->set_max_dimension(Scene::max_dimension);
    limits->set_max_sessions(host_.registry.max_sessions());
    limits->set_max_step(Session::max_step);
    limits->set_max_message_bytes(max_message_bytes);
    limits->set_max_checkpoints(Checkpoints::max_count);
    limits->set_max_checkpoint_bytes(Checkpoints::max_bytes);
    *limits->mutable_idle_timeout() = google::protobuf::util::TimeUtil::MillisecondsToDuration(
        host_.registry.idle_timeout().count());
    to_proto(catalogue(), response);
    return grpc::Status::OK;
  });
}

grpc::ServerUnaryReactor* Service::CreateSession(Context* context,
                                                 const v1::CreateSessionRequest* request,
                                                 v1::CreateSessionResponse* response) {
  CallLog log(host_.log, *context, "CreateSession", request->session_id());
  const auto work = [this, request, response] {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    const grpc::Status status = check_session_id(request->session_id());
    return status.ok() ? create(host_, *request, response) : status;
  };
  if (request->scene().inertia_size() > small_dimension) {
    return new PooledCall(host_, std::move(log), work);
  }
  return answer(context, std::move(log), work);
}

grpc::ServerUnaryReactor* Service::GetSession(Context* context,
                                              const v1::GetSessionRequest* request,
                                              v1::GetSessionResponse* response) {
  return answer(context, CallLog(host_.log, *context, "GetSession", request->session_id()), [&] {
    const auto session = find_session(host_, request->session_id());
    if (!session) return session.error();
    to_proto(**session, host_.registry, response->mutable_session());
    return grpc::Status::OK;
  });
}

grpc::ServerUnaryReactor* Service::ListSessions(Context* context,
                                                const v1::ListSessionsRequest* request,
                                                v1::ListSessionsResponse* response) {
  return answer(context, CallLog(host_.log, *context, "ListSessions"), [&] {
    if (request->page_size() > max_page_size) {
      return errors::invalid("page_size", std::to_string(request->page_size()),
                             "must be at most " + std::to_string(max_page_size));
    }
    if (const std::string& token = request->page_token(); !token.empty()) {
      if (const auto status = check_session_id(token, "page_token"); !status.ok()) return status;
    }
    const std::size_t size = request->page_size() ? request->page_size() : default_page_size;
    // The token is the last id of the page before. One more than asked for tells if more follow.
    auto sessions = host_.registry.page(request->page_token(), size + 1);
    if (sessions.size() > size) {
      sessions.pop_back();
      response->set_next_page_token(sessions.back()->id());
    }
    for (const auto& session : sessions)
      to_proto(*session, host_.registry, response->add_sessions());
    return grpc::Status::OK;
  });
}

grpc::ServerUnaryReactor* Service::DeleteSession(Context* context,
                                                 const v1::DeleteSessionRequest* request,
                                                 v1::DeleteSessionResponse*) {
  return answer(context, CallLog(host_.log, *context, "DeleteSession", request->session_id()), [&] {
    const grpc::Status status = check_session_id(request->session_id());
    if (status.ok()) host_.registry.erase(request->session_id());
    return status;
  });
}

grpc::ServerUnaryReactor* Service::Diagnose(Context* context, const v1::DiagnoseRequest* request,
                                            v1::DiagnoseResponse* response) {
  CallLog log(host_.log, *context, "Diagnose", request->session_id());
  const auto refuse = [&](const grpc::Status& status) {
    return answer(context, std::move(log), [&] { return status; });
  };
  auto session = find_session(host_, request->session_id());
  if (!session) return refuse(session.error());
  if (const auto status = check_step("to", request->to()); !status.ok()) return refuse(status);
  std::vector<std::string> only(request->invariants().begin(), request->invariants().end());
  Violations violations;
  for (std::size_t i = 0; i < only.size(); ++i) {
    if (is_invariant((*session)->scene(), only[i])) continue;
    violations.push_back({"invariants[" + std::to_string(i) + "]", only[i],
                          "must be an invariant of " + (*session)->scene().system()});
  }
  if (!violations.empty()) return refuse(errors::invalid(violations));
  return new WalkCall(host_, std::move(log), *std::move(session), request->to(),
                      [only = std::move(only), response](const Session& at, const Walk& walk) {
                        to_proto(walk.ending(), response->mutable_ending());
                        response->set_step(walk.step());
                        response->set_time(at.scene().time(walk.step()));
                        response->set_computed_steps(walk.computed_steps());
                        to_proto(diagnose(at.scene(), walk.simulation(), only), response);
                        return grpc::Status::OK;
                      });
}

}  // namespace stiefel::server
