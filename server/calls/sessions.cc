#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/calls/unary_call.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/convert/work_price.h"
#include "server/sessions/field_bytes.h"
#include "server/sessions/identity.h"

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

/// The page sizes of ListSessions.
constexpr std::size_t default_page_size = 100, max_page_size = 1000;

constexpr std::string_view digits = "0123456789abcdef";
constexpr std::size_t check_digits = 8;

std::string hexadecimal(std::string_view bytes) {
  std::string out;
  for (const char byte : bytes) {
    out += digits[static_cast<unsigned char>(byte) >> 4];
    out += digits[static_cast<unsigned char>(byte) & 0xF];
  }
  return out;
}

std::string check_of(std::string_view id) {
  const std::uint64_t value = hash(id);
  return hexadecimal({reinterpret_cast<const char*>(&value), sizeof value}).substr(0, check_digits);
}

/// Converts the last id of a page of ListSessions to an opaque token, and back; returns nothing for
/// a text that is not a token.
std::string page_token(std::string_view last_id) {
  return check_of(last_id) + hexadecimal(last_id);
}

std::optional<std::string> read_page_token(std::string_view token) {
  if (token.size() < check_digits || token.size() % 2 != 0) return std::nullopt;
  std::string id;
  for (std::size_t i = check_digits; i < token.size(); i += 2) {
    const std::size_t high = digits.find(token[i]), low = digits.find(token[i + 1]);
    if (high == digits.npos || low == digits.npos) return std::nullopt;
    id += static_cast<char>(16 * high + low);
  }
  if (token.substr(0, check_digits) != check_of(id)) return std::nullopt;
  return id;
}

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
  const v1::Scene& given = request.scene();
  MemoryLease resolving(account.memory(), scene_workspace(given));
  auto scene = read_scene(request.has_scene(), given, "scene",
                          [&] { resolving.grow_to(choice_workspace(given)); });
  if (!scene) return scene.error();
  const std::uint64_t to_resolve = resolving.bytes();
  resolving = {};  // the session pays for its scene
  // A session is made only if its first step and the reply fit beside it. The state may have twice
  // the arrays of the request.
  const MemoryLease step(account.memory(),
                         memory_price({.workspace = first_step_workspace(scene->scene),
                                       .reply = 2 * held_by(request.scene())}));
  const Resolution resolution = scene->resolution;
  const auto admitted = admit(host, account, request.session_id(), *std::move(scene),
                              request.checkpoint(), request.recreate());
  if (!admitted) return admitted.error();
  to_proto(*admitted->session, resolution, host.registry, request.view(),
           response->mutable_session());
  response->set_created(admitted->created);
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

/// Does the work on this thread and answers with its result, once its change is on disk.
template <class Response, class Work>
Service::Unary answer_here(Host& host, CallLog& log, Response* response, const Work& work) {
  const Answered answered = work({});
  MemoryLease memory;
  if (const std::size_t bytes = wire_size(*response); bytes > part_bytes / 16)
    memory = MemoryLease(log.account().memory(), memory_price({.reply = bytes}));
  if (!answered.pending_write && !memory) return answered.status;
  return new UnaryCall(host, std::move(log), answered, std::move(memory));
}

}  // namespace

Service::Unary Service::CreateSession(Context& context, CallLog& log,
                                      const v1::CreateSessionRequest& request,
                                      v1::CreateSessionResponse* response) {
  Account& account = log.account();
  const auto work = [this, &account, &context, &request,
                     response](const std::stop_token&) -> Answered {
    if (host_.lifecycle.refusing()) return errors::shutting_down();
    if (auto status = check_session_id(request.session_id()); !status.ok()) return status;
    if (auto status = check_routing(context, request.session_id()); !status.ok()) return status;
    return create(host_, account, request, response);
  };
  MemoryLease memory(account.memory(), memory_price({.request = held_by(request)}));
  const v1::Scene& scene = request.scene();
  const bool chooses = wants_choice(scene);
  const double price = chooses ? most_choice_work() : creation_work(scene);
  if (!chooses && price <= inline_work && request.ByteSizeLong() <= part_bytes)
    return answer_here(host_, log, response, work);
  return new UnaryCall(host_, std::move(log), chooses ? JobKind::unsliced : kind_of_piece(price),
                       price, work, std::move(memory));
}

Service::Unary Service::GetSession(Context& context, CallLog& log,
                                   const v1::GetSessionRequest& request,
                                   v1::GetSessionResponse* response) {
  auto found = find_session(host_, context, request.session_id());
  if (!found) return found.error();
  const auto session = std::make_shared<const SessionLease>(*std::move(found));
  const auto work = [this, session, &request, response](const std::stop_token&) -> Answered {
    to_proto(**session, (*session)->resolution(), host_.registry, request.view(),
             response->mutable_session());
    return grpc::Status::OK;
  };
  if (!shows_scenes(request.view()) || (*session)->scene_bytes() <= small_scene)
    return answer_here(host_, log, response, work);
  MemoryLease memory(log.account().memory(), memory_price({.reply = max_reply_bytes}));
  return new UnaryCall(host_, std::move(log), JobKind::sliced, 0, work, std::move(memory));
}

Service::Unary Service::ListSessions(Context& context, CallLog& log,
                                     const v1::ListSessionsRequest& request,
                                     grpc::ByteBuffer* response) {
  const auto work = [this, &context, &request, response](const std::stop_token&) -> Answered {
    v1::ListSessionsResponse page;
    const grpc::Status status = list(host_.registry, host_.identify(context), request, &page);
    if (status.ok()) serialize(page, *response);
    return status;
  };
  const std::size_t size = page_size(request);
  const bool scenes = shows_scenes(request.view());
  if (!scenes && size <= short_page) return answer_here(host_, log, response, work);
  MemoryBudget& budget = log.account().memory();
  // A list without scenes is never refused, so that a caller beyond the limits finds its sessions.
  MemoryLease memory =
      scenes ? MemoryLease(budget, memory_price({.reply = max_reply_bytes}))
             : MemoryLease::if_it_fits(budget, memory_price({.reply = size * heading_bytes}));
  return new UnaryCall(host_, std::move(log), JobKind::sliced, 0, work, std::move(memory));
}

Service::Unary Service::DeleteSession(Context& context, CallLog& log,
                                      const v1::DeleteSessionRequest& request,
                                      v1::DeleteSessionResponse* response) {
  const auto work = [this, &context, &request](const std::stop_token&) -> Answered {
    if (auto status = check_session_id(request.session_id()); !status.ok()) return status;
    if (auto status = check_routing(context, request.session_id()); !status.ok()) return status;
    const Principal principal = host_.identify(context);
    MemoryBudget& memory = host_.accounts.of(principal).memory();
    return {grpc::Status::OK,
            host_.registry.erase(principal, request.session_id(), &memory).pending_write};
  };
  const auto found = host_.registry.find(log.account().principal(), request.session_id());
  if (!found || is_freed_at_once(**found)) return answer_here(host_, log, response, work);
  return new UnaryCall(host_, std::move(log), JobKind::sliced, 0, work);
}

}  // namespace stiefel::server
