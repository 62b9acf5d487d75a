#pragma once

#include <grpcpp/server_context.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "server/calls/host.h"
#include "server/convert/errors.h"
#include "server/convert/resolve.h"

/// Checks of a request before anything moves. All throw StatusError (errors.h).
namespace stiefel::server {

/// Throws INVALID_ARGUMENT if the call's metadata `stiefel-session`, by which proxies route, names
/// another session.
void check_routing(const grpc::ServerContextBase& context, std::string_view id,
                   const char* field = "session_id");

/// Returns the session. Throws UNAVAILABLE during shutdown, INVALID_ARGUMENT, or NOT_FOUND, whose
/// reason distinguishes a deleted session from one that was never there or is lost.
SessionRef find_session(const Host& host, const grpc::ServerContextBase& context,
                        const Principal& principal, std::string_view id,
                        const char* field = "session_id");

/// Throws INVALID_ARGUMENT unless the id is 1 to 128 characters of [A-Za-z0-9._-].
void check_session_id(std::string_view id, const char* field = "session_id");

/// Throws INVALID_ARGUMENT unless low <= value <= Session::max_step.
void check_step(const char* field, std::int64_t value, std::int64_t low = 0);

/// Throws INVALID_ARGUMENT unless 0 <= from <= to <= Session::max_step and `every` and, where the
/// request has it, `checkpoint_every` are not negative.
template <class Request>
void check_range(const Request& request) {
  check_step("from", request.from());
  check_step("to", request.to(), request.from());
  const auto check_spacing = [](const char* field, std::int64_t value) {
    if (value < 0) throw errors::invalid(field, std::to_string(value), "must be at least 0");
  };
  check_spacing("every", request.every());
  if constexpr (requires { request.checkpoint_every(); })
    check_spacing("checkpoint_every", request.checkpoint_every());
}

/// Returns the account's session with that scene and id, new or existing. A new session takes a
/// slot of the account. `checkpoint` and `recreate`: see Registry::create.
Registry::Created admit(Host& host, Account& account, const std::string& id, ResolvedScene scene,
                        std::string_view checkpoint = {}, bool recreate = false);

}  // namespace stiefel::server
