#pragma once

#include <grpcpp/server_context.h>

#include <boost/intrusive/list_hook.hpp>

#include "server/sessions/checkpoints/digest.h"
#include "server/sessions/principal.h"

namespace stiefel::server {

/// The context of a call at a server with tokens, with the caller's principal, which `Callers`
/// sets.
class CallerContext final : public grpc::CallbackServerContext,
                            public boost::intrusive::list_base_hook<> {
 public:
  const Principal& principal() const { return principal_; }

 private:
  friend class Callers;
  Principal principal_;
  Bytes32 digest_{};  // SHA-256 of the token
  bool admitted_ = false;
};

}  // namespace stiefel::server
