#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "server/calls/host.h"
#include "server/convert/errors.h"
#include "server/convert/resolve.h"

/// What is checked before anything moves.
namespace stiefel::server {

/// INVALID_ARGUMENT if the call carries another session's name as metadata `stiefel-session`, by
/// which proxies route.
grpc::Status check_routing(const grpc::CallbackServerContext& context, std::string_view id,
                           const char* field = "session_id");

/// UNAVAILABLE when shutting down, INVALID_ARGUMENT, NOT_FOUND (never there, lost or deleted: see
/// the reason), or the session.
OrStatus<SessionLease> find_session(const Host& host, const grpc::CallbackServerContext& context,
                                    std::string_view id, const char* field = "session_id");

/// INVALID_ARGUMENT unless it is 1 to 128 of [A-Za-z0-9._-].
grpc::Status check_session_id(std::string_view id, const char* field = "session_id");

/// INVALID_ARGUMENT unless low <= value <= Session::max_step.
grpc::Status check_step(const char* field, std::int64_t value, std::int64_t low = 0);

/// INVALID_ARGUMENT unless 0 <= from <= to <= Session::max_step and `every` and `checkpoint_every`
/// are not negative. `Request`: StreamRequest or SummarizeRequest.
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

/// The account's session of that scene under that id, new or there already; or why there is none.
/// `place`: of the scene in the request. A new session takes a seat of the account. `recreate`: see
/// Registry::create.
OrStatus<Registry::Created> admit(Host& host, Account& account, const std::string& id,
                                  ResolvedScene scene, const Place& place,
                                  std::string_view checkpoint = {}, bool recreate = false);

}  // namespace stiefel::server
