#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <functional>
#include <optional>

#include "server/service/host.h"
#include "server/sessions/walk.h"

namespace stiefel::server {

/// A unary call that walks to a step on the pool and then answers. Deletes itself.
class WalkCall final : public grpc::ServerUnaryReactor, private Job {
 public:
  /// Writes the reply from where the walk ended.
  using Answer = std::function<grpc::Status(const Session&, const Walk&)>;

  WalkCall(Host& host, CallLog log, Hold session, std::int64_t to, Answer answer);

  void OnCancel() override { cancelled_ = true; }
  void OnDone() override;

 private:
  bool run_slice() noexcept override;
  /// True when there is nothing left to do.
  bool walk_on();
  void finish(const grpc::Status& status);

  Host& host_;
  CallLog log_;
  std::optional<Hold> session_;
  const std::int64_t to_;
  const Answer answer_;
  std::optional<Walk> walk_;
  std::atomic<bool> cancelled_ = false;
};

/// Runs `work` on the pool and answers with what it returns. Deletes itself.
class PooledCall final : public grpc::ServerUnaryReactor, private Job {
 public:
  PooledCall(Host& host, CallLog log, std::function<grpc::Status()> work);
  void OnDone() override;

 private:
  bool run_slice() noexcept override;

  Host& host_;
  CallLog log_;
  const std::function<grpc::Status()> work_;
};

}  // namespace stiefel::server
