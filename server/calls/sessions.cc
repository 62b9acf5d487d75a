#include <utility>

#include "server/calls/cursor_call.h"
#include "server/calls/limits.h"
#include "server/calls/page_token.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/price.h"
#include "server/convert/reply_limits.h"

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
  const Resolution resolution = scene->resolution;
  const auto admitted = admit(host, request.session_id(), *std::move(scene), Place::inside("scene"),
                              request.checkpoint());
  if (!admitted) return admitted.error();
  to_proto(*admitted->session, resolution, host.registry, request.view(),
           response->mutable_session());
  response->set_created(admitted->created);
  if (wants_choice(request.scene()))
    to_proto(most_choice_work(), 0, v1::PRICE_BOUND_AT_MOST, response->mutable_price());
  return grpc::Status::OK;
}

/// A page ends when it has so many sessions as were asked for, or as many bytes as a reply may
/// have.
grpc::Status list(const Registry& registry, const v1::ListSessionsRequest& request,
                  v1::ListSessionsResponse* response) {
  const std::optional<std::string> after =
      request.page_token().empty() ? "" : read_page_token(request.page_token());
  if (!after)
    return errors::invalid("page_token", request.page_token(),
                           "must be the next_page_token of a reply");
  const std::size_t size = request.page_size() == 0
                               ? default_page_size
                               : std::min<std::size_t>(request.page_size(), max_page_size);
  // One more than asked for tells if more follow.
  const auto sessions = registry.page(*after, size + 1);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    v1::Session session;
    if (i < size) to_list(*sessions[i], registry, request.view(), &session);
    bytes += session.ByteSizeLong();
    if (i == size || (i > 0 && bytes > max_reply_bytes)) {
      response->set_next_page_token(page_token(sessions[i - 1]->id()));
      break;
    }
    *response->add_sessions() = std::move(session);
  }
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
  return finished(context, log, status);
}

grpc::ServerUnaryReactor* Service::CreateSession(Context* context,
                                                 const v1::CreateSessionRequest* request,
                                                 v1::CreateSessionResponse* response) {
  CallLog log = open(context, "CreateSession", request->session_id());
  const auto work = [this, context, request, response](const std::stop_token& = {}) {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    if (const auto status = check_session_id(request->session_id()); !status.ok()) return status;
    if (const auto status = check_routing(*context, request->session_id()); !status.ok())
      return status;
    return create(host_, *request, response);
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
  return answer(context, open(context, "GetSession", request->session_id()), [&] {
    const auto session = find_session(host_, *context, request->session_id());
    if (!session) return session.error();
    to_proto(**session, (*session)->resolution(), host_.registry, request->view(),
             response->mutable_session());
    return grpc::Status::OK;
  });
}

grpc::ServerUnaryReactor* Service::ListSessions(Context* context,
                                                const v1::ListSessionsRequest* request,
                                                v1::ListSessionsResponse* response) {
  return answer(context, open(context, "ListSessions"),
                [&] { return list(host_.registry, *request, response); });
}

grpc::ServerUnaryReactor* Service::DeleteSession(Context* context,
                                                 const v1::DeleteSessionRequest* request,
                                                 v1::DeleteSessionResponse*) {
  return answer(context, open(context, "DeleteSession", request->session_id()), [&] {
    if (const auto status = check_session_id(request->session_id()); !status.ok()) return status;
    const grpc::Status status = check_routing(*context, request->session_id());
    if (status.ok()) host_.registry.erase(request->session_id());
    return status;
  });
}

}  // namespace stiefel::server
