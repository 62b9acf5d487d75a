#include "server/calls/service.h"
#include "stiefel/version.h"

#include <google/protobuf/util/time_util.h>

#include <utility>

#include "server/calls/cursor_call.h"
#include "server/calls/limits.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"

namespace stiefel::server {
namespace {

// Above them, resolving a scene and making its simulation is work for a pool: for that of steps,
// or, where it is more than a slice, for the other.
constexpr int small_dimension = 32, large_dimension = 96;
constexpr int few_members = 64;

grpc::Status create(Host& host, const v1::CreateSessionRequest& request,
                    v1::CreateSessionResponse* response) {
  auto scene = read_scene(request.has_scene(), request.scene());
  if (!scene) return scene.error();
  auto admitted = admit(host, request.session_id(), *std::move(scene), Place::inside("scene"),
                        request.checkpoint());
  if (!admitted) return admitted.error();
  to_proto(*admitted->session, host.registry, response->mutable_session());
  response->set_created(admitted->created);
  return grpc::Status::OK;
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
    limits->set_max_members(Scene::max_members);
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
  const auto work = [this, request, response](const std::stop_token& = {}) {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    const grpc::Status status = check_session_id(request->session_id());
    return status.ok() ? create(host_, *request, response) : status;
  };
  const v1::Scene& scene = request->scene();
  const bool long_work = wants_choice(scene) || scene.inertia_size() > large_dimension ||
                         scene.members() > few_members;
  if (long_work) return new PooledCall(host_, host_.searches, std::move(log), work);
  if (scene.inertia_size() > small_dimension || scene.has_members())
    return new PooledCall(host_, host_.pool, std::move(log), work);
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

}  // namespace stiefel::server
