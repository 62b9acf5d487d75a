#include "stiefel/client/call.h"

#include <algorithm>
#include <chrono>

namespace stiefel::client {
namespace {

/// Whether a session's id may be the value of metadata. The server refuses any other id.
bool is_routable(const std::string& id) {
  return !id.empty() && std::ranges::all_of(id, [](char c) { return c > ' ' && c < 0x7F; });
}

}  // namespace

Error Connection::error(const grpc::Status& status) const {
  const bool answered = status.error_code() != grpc::StatusCode::UNAVAILABLE ||
                        !status.error_details().empty() || address.empty();
  if (answered) return Error(status);
  return Error({status.error_code(), "cannot reach " + address + ": " + status.error_message()});
}

Context::Context(const Connection& connection, const std::string& session_id, bool has_timeout)
    : stop_(connection.options.stop, [this] { cancel(); }) {
  if (is_routable(session_id)) context_.AddMetadata("stiefel-session", session_id);
  if (const auto timeout = connection.options.timeout; timeout && has_timeout)
    context_.set_deadline(std::chrono::system_clock::now() + *timeout);
}

}  // namespace stiefel::client
