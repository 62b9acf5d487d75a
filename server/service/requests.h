#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <expected>
#include <string_view>
#include <vector>

#include "server/service/convert.h"
#include "server/service/host.h"

/// What is checked before anything moves.
namespace stiefel::server {

template <class T>
using OrStatus = std::expected<T, grpc::Status>;

/// UNAVAILABLE when shutting down, NOT_FOUND, or the session.
OrStatus<Hold> find_session(const Host& host, std::string_view id);

/// INVALID_ARGUMENT unless it is 1 to 128 of [A-Za-z0-9._-].
grpc::Status check_session_id(std::string_view id, const char* field = "session_id");

/// INVALID_ARGUMENT unless low <= value <= Session::max_step.
grpc::Status check_step(const char* field, std::int64_t value, std::int64_t low = 0);

}  // namespace stiefel::server
