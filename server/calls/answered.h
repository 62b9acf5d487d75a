#pragma once

#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <utility>

#include "server/calls/host.h"
#include "server/sessions/write_ahead_log.h"

namespace stiefel::server {

/// The answer of a call, and the change that must be on disk before the caller learns of it.
struct Answered {
  Answered(grpc::Status of_call, std::shared_ptr<PendingWrite> written = nullptr)
      : status(std::move(of_call)), pending_write(std::move(written)) {}

  grpc::Status status;
  std::shared_ptr<PendingWrite> pending_write;  ///< null: nothing to wait for
};

/// Calls `send` once with the status, or with the store's error: at once if nothing is being
/// written, else on the store's thread. Blocks no thread. `send` must not throw.
void when_written(const Answered& answered, const std::function<void(const grpc::Status&)>& send);

/// A unary call whose reply is ready and is sent once its change is on disk. `memory` is held until
/// the reply is delivered. Deletes itself.
class WrittenCall final : public grpc::ServerUnaryReactor {
 public:
  WrittenCall(Host& host, CallLog log, const Answered& answered, MemoryLease memory = {});
  void OnDone() override;

 private:
  Host& host_;
  CallLog log_;
  const MemoryLease memory_;
};

}  // namespace stiefel::server
