#pragma once

#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <utility>

#include "server/calls/host.h"
#include "server/sessions/ledger.h"

namespace stiefel::server {

/// What a call answers, and what must be on disk before the caller learns of it.
struct Answered {
  Answered(grpc::Status of_call, std::shared_ptr<Receipt> written = nullptr)
      : status(std::move(of_call)), receipt(std::move(written)) {}

  grpc::Status status;
  std::shared_ptr<Receipt> receipt;  ///< null: nothing to wait for
};

/// Calls `send` once, with the status, or with the store's error: now, or on the store's thread. No
/// thread waits. `send` throws nothing.
void when_written(const Answered& answered, const std::function<void(const grpc::Status&)>& send);

/// A unary call whose reply is ready and is sent once it is on disk. `memory`: what the reply takes
/// until it is delivered. Deletes itself.
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
