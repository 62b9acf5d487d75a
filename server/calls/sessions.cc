#include <utility>

#include "server/calls/cursor_call.h"
#include "server/calls/limits.h"
#include "server/calls/page_token.h"
#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/wire_bytes.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/request_price.h"
#include "server/pricing/memory_price.h"
#include "server/scheduling/failpoint.h"
#include "server/sessions/field_bytes.h"

namespace stiefel::server {
namespace {

/// The most work of a call, in instructions, that runs on the thread that received it.
constexpr double inline_work = inline_nanoseconds * instructions_a_nanosecond;
/// The most bytes of a scene that is written, and the most sessions that are listed, on the thread
/// that received the call.
constexpr std::uint64_t small_scene = 8 << 10;
constexpr std::size_t short_page = 16;
/// The bytes of a session in a list without scenes.
constexpr std::uint64_t heading_bytes = 512;

/// Returns the number of sessions that are listed.
std::size_t page_size(const v1::ListSessionsRequest& request) {
  return request.page_size() == 0 ? default_page_size
                                  : std::min<std::size_t>(request.page_size(), max_page_size);
}

/// Whether it takes less than `inline_nanoseconds` to free the session.
bool is_freed_at_once(const Session& session) {
  return session.scene_bytes() <= small_scene && session.scene().members().size() == 0;
}

Answered create(Host& host, Account& account, const v1::CreateSessionRequest& request,
                v1::CreateSessionResponse* response) {
  failpoint("call.create");
  MemoryLease resolving(account.memory(), wants_choice(request.scene())
                                              ? search_memory(request.scene())
                                              : scene_memory(request.scene()));
  const std::uint64_t to_resolve = resolving.bytes();
  auto scene = read_scene(request.has_scene(), request.scene());
  if (!scene) return scene.error();
  resolving = {};  // the session pays for its scene
  // A session is made only if its first step and the reply fit beside it.
  const MemoryLease step(account.memory(), first_step_memory(scene->scene, request.scene()));
  const Resolution resolution = scene->resolution;
  const auto admitted = admit(host, account, request.session_id(), *std::move(scene),
                              request.checkpoint(), request.recreate());
  if (!admitted) return admitted.error();
  to_proto(*admitted->session, resolution, host.registry, request.view(),
           response->mutable_session());
  response->set_created(admitted->created);
  response->set_checkpoint_ignored(admitted->checkpoint_ignored);
  const double work =
      wants_choice(request.scene()) ? most_choice_work() : recommendation_work(request.scene());
  if (work > 0)
    to_proto(work, 0, v1::PRICE_BOUND_AT_MOST, std::max(to_resolve, step.bytes()),
             response->mutable_price());
  return {grpc::Status::OK, admitted->pending_write};
}

std::size_t wire_size(const google::protobuf::Message& reply) { return reply.ByteSizeLong(); }
std::size_t wire_size(const grpc::ByteBuffer& reply) { return reply.Length(); }

/// Lists a page of sessions, which ends at the number asked for or at the bytes of a reply. Throws
/// Stopped (stiefel/stop.h).
grpc::Status list(const Registry& registry, const Principal& principal,
                  const v1::ListSessionsRequest& request, v1::ListSessionsResponse* response) {
  const std::optional<std::string> after =
      request.page_token().empty() ? "" : read_page_token(request.page_token());
  if (!after)
    return errors::invalid("page_token", request.page_token(),
                           "must be the next_page_token of a reply of ListSessions");
  const std::size_t size = page_size(request);
  // One more session than asked for tells whether more follow.
  const auto sessions = registry.page(principal, *after, size + 1);
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

template <class Response, class Work>
grpc::ServerUnaryReactor* Service::answer(Context* context, CallLog log, Response* response,
                                          Work work) {
  Answered answered{grpc::Status::OK};
  MemoryLease memory;
  try {
    answered = work();
    if (const std::size_t bytes = wire_size(*response); bytes > part_bytes / 16)
      memory = MemoryLease(log.account().memory(), reply_memory(bytes));
    if (answered.pending_write || memory)
      return new WrittenCall(host_, std::move(log), answered, std::move(memory));
  } catch (...) {
    answered = errors::from_current_exception();
    *response = {};
  }
  return finished(context, log, answered.status);
}

grpc::ServerUnaryReactor* Service::CreateSession(Context* context,
                                                 const v1::CreateSessionRequest* request,
                                                 v1::CreateSessionResponse* response) {
  CallLog log = open(context, "CreateSession", request->session_id());
  Account& account = log.account();
  const auto work = [this, &account, context, request,
                     response](const std::stop_token& = {}) -> Answered {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    if (const auto status = check_session_id(request->session_id()); !status.ok()) return status;
    if (const auto status = check_routing(*context, request->session_id()); !status.ok())
      return status;
    return create(host_, account, *request, response);
  };
  MemoryLease memory;
  try {
    memory = MemoryLease(account.memory(), reading_memory(*request));
  } catch (...) {
    return finished(context, log, errors::from_current_exception());
  }
  const v1::Scene& scene = request->scene();
  const double price = wants_choice(scene) ? most_choice_work() : creation_work(scene);
  if (!wants_choice(scene) && price <= inline_work && request->ByteSizeLong() <= part_bytes)
    return answer(context, std::move(log), response, work);
  Pool& pool = wants_choice(scene) ? host_.searches : host_.pool_for_piece(price);
  return new PooledCall(host_, pool, std::move(log), work, std::move(memory), price);
}

grpc::ServerUnaryReactor* Service::GetSession(Context* context,
                                              const v1::GetSessionRequest* request,
                                              v1::GetSessionResponse* response) {
  CallLog log = open(context, "GetSession", request->session_id());
  try {
    auto found = find_session(host_, *context, request->session_id());
    if (!found) return finished(context, log, found.error());
    const auto session = std::make_shared<const SessionLease>(*std::move(found));
    const auto work = [this, session, request, response](const std::stop_token& = {}) -> Answered {
      to_proto(**session, (*session)->resolution(), host_.registry, request->view(),
               response->mutable_session());
      return grpc::Status::OK;
    };
    if (!shows_scenes(request->view()) || (*session)->scene_bytes() <= small_scene)
      return answer(context, std::move(log), response, work);
    MemoryLease memory(log.account().memory(), reply_memory(max_reply_bytes));
    return new PooledCall(host_, host_.pool, std::move(log), work, std::move(memory));
  } catch (...) {
    return finished(context, log, errors::from_current_exception());
  }
}

grpc::ServerUnaryReactor* Service::ListSessions(Context* context,
                                                const v1::ListSessionsRequest* request,
                                                grpc::ByteBuffer* response) {
  CallLog log = open(context, "ListSessions");
  const auto work = [this, context, request, response](const std::stop_token& = {}) -> Answered {
    v1::ListSessionsResponse page;
    const grpc::Status status = list(host_.registry, host_.identify(*context), *request, &page);
    if (status.ok()) serialize(page, *response);
    return status;
  };
  const std::size_t size = page_size(*request);
  const bool scenes = shows_scenes(request->view());
  if (!scenes && size <= short_page) return answer(context, std::move(log), response, work);
  try {
    MemoryBudget& budget = log.account().memory();
    // A list without scenes is never refused, so that a caller beyond the limits finds its
    // sessions.
    MemoryLease memory = scenes
                             ? MemoryLease(budget, reply_memory(max_reply_bytes))
                             : MemoryLease::if_it_fits(budget, reply_memory(size * heading_bytes));
    return new PooledCall(host_, host_.pool, std::move(log), work, std::move(memory));
  } catch (...) {
    return finished(context, log, errors::from_current_exception());
  }
}

grpc::ServerUnaryReactor* Service::DeleteSession(Context* context,
                                                 const v1::DeleteSessionRequest* request,
                                                 v1::DeleteSessionResponse* response) {
  const auto work = [this, context, request](const std::stop_token& = {}) -> Answered {
    if (const auto status = check_session_id(request->session_id()); !status.ok()) return status;
    if (const auto status = check_routing(*context, request->session_id()); !status.ok())
      return status;
    const Principal principal = host_.identify(*context);
    MemoryBudget& memory = host_.accounts.of(principal).memory();
    return {grpc::Status::OK,
            host_.registry.erase(principal, request->session_id(), &memory).pending_write};
  };
  CallLog log = open(context, "DeleteSession", request->session_id());
  const auto found = host_.registry.find(log.account().principal(), request->session_id());
  if (!found || is_freed_at_once(**found)) return answer(context, std::move(log), response, work);
  return new PooledCall(host_, host_.pool, std::move(log), work);
}

}  // namespace stiefel::server
