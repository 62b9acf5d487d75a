#include "server/calls/requests.h"

#include <algorithm>
#include <string>

#include "server/convert/errors.h"
#include "server/sessions/identity.h"

namespace stiefel::server {

grpc::Status check_routing(const grpc::ServerContextBase& context, std::string_view id,
                           const char* field) {
  // All of them, because a proxy may route by any.
  const auto [first, last] = context.client_metadata().equal_range("stiefel-session");
  for (auto sent = first; sent != last; ++sent) {
    const std::string_view routed(sent->second.data(), sent->second.size());
    if (routed == id) continue;
    return errors::invalid(
        field, std::string(id),
        "must equal the metadata stiefel-session, '" + std::string(routed) + "'");
  }
  return grpc::Status::OK;
}

OrStatus<SessionLease> find_session(const Host& host, const grpc::ServerContextBase& context,
                                    const Principal& principal, std::string_view id,
                                    const char* field) {
  if (host.lifecycle.refusing()) return std::unexpected(errors::shutting_down());
  if (const auto status = check_routing(context, id, field); !status.ok())
    return std::unexpected(status);
  if (auto session = host.registry.find(principal, id)) return *std::move(session);
  const grpc::Status status = check_session_id(id, field);
  if (!status.ok()) return std::unexpected(status);
  return std::unexpected(host.registry.deleted(principal, id)
                             ? errors::session_deleted(id, field)
                             : errors::session_not_found(id, field));
}

grpc::Status check_session_id(std::string_view id, const char* field) {
  const auto allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  if (!id.empty() && id.size() <= 128 && std::ranges::all_of(id, allowed)) return grpc::Status::OK;
  return errors::invalid(field, id.empty() ? "empty" : std::string(id),
                         "must have 1 to 128 characters of [A-Za-z0-9._-]");
}

grpc::Status check_step(const char* field, std::int64_t value, std::int64_t low) {
  if (low <= value && value <= Session::max_step) return grpc::Status::OK;
  return errors::invalid(
      field, std::to_string(value),
      "must be " + std::to_string(low) + " to " + std::to_string(Session::max_step) +
          (value < 0 ? "; for times before 0, use a negative step in the scene" : ""));
}

OrStatus<Registry::Created> admit(Host& host, Account& account, const std::string& id,
                                  ResolvedScene scene, std::string_view checkpoint, bool recreate) {
  auto admission = account.admit_session();
  // A request for an existing session takes no permit.
  if (admission.refusal && !host.registry.find(account.principal(), id))
    return std::unexpected(errors::over_quota(*admission.refusal));
  auto created = host.registry.create(account.principal(), id, std::move(scene.scene), checkpoint,
                                      std::move(scene.resolution), recreate, &account.memory());
  if (created) {
    if (created->created) created->session->hold_permit(std::move(admission.permit));
    return *std::move(created);
  }
  if (const auto* conflict = std::get_if<Registry::Conflict>(&created.error())) {
    if (*conflict == Registry::Conflict::deleted)
      return std::unexpected(errors::session_deleted(id));
    return std::unexpected(*conflict == Registry::Conflict::other_scene
                               ? errors::session_has_other_scene(id)
                               : errors::too_many_sessions(host.registry.max_sessions()));
  }
  if (const auto* overflow = std::get_if<Overflow>(&created.error()))
    return std::unexpected(errors::overflow(scene.place, *overflow));
  const auto& refusal = std::get<CheckpointRefusal>(created.error());
  const std::string value = std::to_string(checkpoint.size()) + " bytes";
  switch (refusal.fault) {
    case CheckpointFault::other_numerics:
      return std::unexpected(
          errors::checkpoint_of_other_numerics(refusal.numerics_id, numerics_id()));
    case CheckpointFault::other_scene:
      return std::unexpected(
          errors::invalid("checkpoint", value, "must come from a session of the same scene"));
    case CheckpointFault::corrupt:
      break;
  }
  return std::unexpected(errors::invalid(
      "checkpoint", value, "is damaged: must be the bytes that Step, Drive or Stream returned"));
}

}  // namespace stiefel::server
