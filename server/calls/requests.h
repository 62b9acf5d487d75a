#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "server/calls/host.h"
#include "server/convert/errors.h"
#include "server/convert/resolve.h"

/// Checks of a request before anything moves.
namespace stiefel::server {

/// Returns INVALID_ARGUMENT if the call's metadata `stiefel-session`, by which proxies route, names
/// another session.
grpc::Status check_routing(const grpc::ServerContextBase& context, std::string_view id,
                           const char* field = "session_id");

/// Returns the session, or UNAVAILABLE during shutdown, INVALID_ARGUMENT, or NOT_FOUND, whose
/// reason distinguishes a deleted session from one that was never there or is lost.
OrStatus<SessionLease> find_session(const Host& host, const grpc::ServerContextBase& context,
                                    const Principal& principal, std::string_view id,
                                    const char* field = "session_id");

/// Returns INVALID_ARGUMENT unless the id is 1 to 128 characters of [A-Za-z0-9._-].
grpc::Status check_session_id(std::string_view id, const char* field = "session_id");

/// Returns INVALID_ARGUMENT unless low <= value <= Session::max_step.
grpc::Status check_step(const char* field, std::int64_t value, std::int64_t low = 0);

/// Returns INVALID_ARGUMENT unless 0 <= from <= to <= Session::max_step and `every` and
/// `checkpoint_every` are not negative. `Request` is StreamRequest or SummarizeRequest.
template <class Request>
grpc::Status check_range(const Request& request) {
  if (const auto status = check_step("from", request.from()); !status.ok()) return status;
  if (const auto status = check_step("to", request.to(), request.from()); !status.ok())
    return status;
  if (request.every() < 0)
    return errors::invalid("every", std::to_string(request.every()), "must be at least 0");
  if (request.checkpoint_every() < 0)
    return errors::invalid("checkpoint_every", std::to_string(request.checkpoint_every()),
                           "must be at least 0");
  return grpc::Status::OK;
}

/// Returns the account's session with that scene and id, new or existing, or the error that
/// prevents it. A new session takes a permit of the account. `checkpoint` and `recreate`: see
/// Registry::create.
OrStatus<Registry::Created> admit(Host& host, Account& account, const std::string& id,
                                  ResolvedScene scene, std::string_view checkpoint = {},
                                  bool recreate = false);

}  // namespace stiefel::server
