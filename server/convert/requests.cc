#include "server/convert/requests.h"
#include "stiefel/version.h"

#include <algorithm>
#include <string>

#include "engine/linalg/arithmetic/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {

OrStatus<SessionLease> find_session(const Host& host, std::string_view id, const char* field) {
  if (host.lifecycle.refusing()) return std::unexpected(errors::shutting_down());
  if (auto session = host.registry.find(id)) return *std::move(session);
  const grpc::Status status = check_session_id(id, field);
  return std::unexpected(status.ok() ? errors::session_not_found(id, field) : status);
}

grpc::Status check_session_id(std::string_view id, const char* field) {
  const auto allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  if (!id.empty() && id.size() <= 128 && std::ranges::all_of(id, allowed)) return grpc::Status::OK;
  return errors::invalid(field, id.empty() ? "empty" : std::string(id),
                         "must be 1 to 128 of [A-Za-z0-9._-]");
}

grpc::Status check_step(const char* field, std::int64_t value, std::int64_t low) {
  if (low <= value && value <= Session::max_step) return grpc::Status::OK;
  return errors::invalid(
      field, std::to_string(value),
      "must be " + std::to_string(low) + " to " + std::to_string(Session::max_step));
}

OrStatus<Scene> read_scene(bool present, const v1::Scene& scene, const char* field) {
  if (!present) return std::unexpected(errors::invalid(field, "absent", "must be given"));
  const auto place = Place::inside(field);
  auto description = from_proto(scene, place);
  if (!description) return std::unexpected(errors::invalid(description.error()));
  auto resolved = resolve_choosing(*std::move(description), Scene::frame_tolerance, place);
  if (!resolved) return std::unexpected(errors::invalid(resolved.error()));
  return *std::move(resolved);
}

bool wants_choice(const v1::Scene& scene) { return scene.has_tolerance() && !scene.has_method(); }

OrStatus<Registry::Created> admit(Host& host, const std::string& id, Scene scene,
                                  const Place& place, std::string_view checkpoint) {
  auto created = host.registry.create(id, std::move(scene), checkpoint);
  if (created) return *std::move(created);
  if (const auto* conflict = std::get_if<Registry::Conflict>(&created.error())) {
    return std::unexpected(*conflict == Registry::Conflict::other_scene
                               ? errors::session_has_other_scene(id)
                               : errors::too_many_sessions(host.registry.max_sessions()));
  }
  if (const auto* overflow = std::get_if<Overflow>(&created.error()))
    return std::unexpected(errors::invalid(
        {place.violation("", overflow->field + " = " + to_text(overflow->value) + " at step 0",
                         "numbers are so large or so small that a field overflows")}));
  const auto& refusal = std::get<CheckpointRefusal>(created.error());
  const std::string value = std::to_string(checkpoint.size()) + " bytes";
  switch (refusal.fault) {
    case CheckpointFault::other_build:
      return std::unexpected(errors::checkpoint_of_other_build(refusal.build, build_fingerprint()));
    case CheckpointFault::other_scene:
      return std::unexpected(
          errors::invalid("checkpoint", value, "must come from a session of the same scene"));
    case CheckpointFault::corrupt:
      break;
  }
  return std::unexpected(
      errors::invalid("checkpoint", value, "must be what Step returned: it is damaged"));
}

}  // namespace stiefel::server
