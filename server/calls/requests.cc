#include "server/calls/requests.h"

#include <algorithm>

#include "server/sessions/identity.h"

namespace stiefel::server {

void check_routing(const grpc::ServerContextBase& context, std::string_view id, const char* field) {
  // All of them, because a proxy may route by any.
  const auto [first, last] = context.client_metadata().equal_range("stiefel-session");
  for (auto sent = first; sent != last; ++sent) {
    const std::string_view routed(sent->second.data(), sent->second.size());
    if (routed != id)
      throw errors::invalid(
          field, std::string(id),
          "must equal the metadata stiefel-session, '" + std::string(routed) + "'");
  }
}

SessionRef find_session(const Host& host, const grpc::ServerContextBase& context,
                        const Principal& principal, std::string_view id, const char* field) {
  if (host.lifecycle.refusing()) throw errors::shutting_down();
  check_routing(context, id, field);
  if (auto session = host.registry.find(principal, id)) return session;
  check_session_id(id, field);
  throw errors::no_session(id, host.registry.deleted(principal, id), field);
}

void check_session_id(std::string_view id, const char* field) {
  const auto allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  if (id.empty() || id.size() > 128 || !std::ranges::all_of(id, allowed))
    throw errors::invalid(field, id.empty() ? "empty" : std::string(id),
                          "must have 1 to 128 characters of [A-Za-z0-9._-]");
}

void check_step(const char* field, std::int64_t value, std::int64_t low) {
  if (value < low || value > Session::max_step)
    throw errors::invalid(
        field, std::to_string(value),
        "must be " + std::to_string(low) + " to " + std::to_string(Session::max_step) +
            (value < 0 ? "; for times before 0, use a negative step in the scene" : ""));
}

Registry::Created admit(Host& host, Account& account, const std::string& id, ResolvedScene scene,
                        std::string_view checkpoint, bool recreate) {
  auto slot = account.admit_session();
  // A request for an existing session takes no slot.
  if (!slot && !host.registry.find(account.principal(), id)) throw errors::over_quota(slot.error());
  auto created = host.registry.create(account.principal(), id, std::move(scene.scene), checkpoint,
                                      std::move(scene.choice), recreate, &account.memory());
  if (created) {
    if (created->created) created->session->hold_slot(std::move(slot).value_or(nullptr));
    return *std::move(created);
  }
  if (const auto* overflow = std::get_if<Overflow>(&created.error()))
    throw errors::overflow(scene.place, *overflow);
  if (const auto* refusal = std::get_if<CheckpointRefusal>(&created.error()))
    throw errors::checkpoint_refused(*refusal, checkpoint.size(), "Step, Drive or Stream");
  switch (std::get<Registry::Conflict>(created.error())) {
    case Registry::Conflict::deleted:
      throw errors::no_session(id, true);
    case Registry::Conflict::other_scene:
      throw errors::session_has_other_scene(id);
    default:
      throw errors::too_many_sessions(host.registry.max_sessions());
  }
}

}  // namespace stiefel::server
