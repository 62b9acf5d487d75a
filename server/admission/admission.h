#pragma once

#include <grpcpp/support/status.h>

#include "server/convert/errors.h"
#include "server/scheduling/account.h"

namespace stiefel::server {

/// Takes a place for a call with that price, in instructions. Returns RESOURCE_EXHAUSTED with the
/// limit if there is none.
inline grpc::Status admit(Ticket& ticket, Account& account, Ticket::Kind kind, double price) {
  const auto refusal = ticket.take(account, kind, price);
  return refusal ? errors::over_quota(*refusal) : grpc::Status::OK;
}

}  // namespace stiefel::server
