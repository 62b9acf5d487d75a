#pragma once

#include <cstdint>
#include <string>

#include "stiefel/client/connection.h"

namespace stiefel::client {

/// Returns the error of a call that ended at its deadline before the session reached step `to`: it
/// also says where the session stands. Returns any other error unchanged.
Error with_standing(const Error& error, const Connection& connection, const std::string& session_id,
                    std::int64_t to);

/// Returns what `call` returns, and completes the error of a call that ended at its deadline.
template <class Call>
auto in_time(const Connection& connection, const std::string& session_id, std::int64_t to,
             const Call& call) {
  try {
    return call();
  } catch (const Error& error) {
    if (error.code() != grpc::StatusCode::DEADLINE_EXCEEDED) throw;
    throw with_standing(error, connection, session_id, to);
  }
}

}  // namespace stiefel::client
