#include "server/service/requests.h"

#include <algorithm>
#include <string>

#include "server/service/errors.h"

namespace stiefel::server {

OrStatus<Hold> find_session(const Host& host, std::string_view id) {
  if (host.lifecycle.refusing()) return std::unexpected(errors::shutting_down());
  if (auto session = host.registry.find(id)) return *std::move(session);
  const grpc::Status status = check_session_id(id);
  return std::unexpected(status.ok() ? errors::session_not_found(id) : status);
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

}  // namespace stiefel::server
