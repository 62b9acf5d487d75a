#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "server/calls/call.h"
#include "server/sessions/cursor.h"
#include "server/sessions/write_ahead_log.h"

namespace stiefel::server {

/// The answer of a call, and the change that must be on disk before the caller learns of it.
struct Answered {
  Answered(grpc::Status of_call, std::shared_ptr<PendingWrite> written = nullptr)
      : status(std::move(of_call)), pending_write(std::move(written)) {}

  grpc::Status status;
  std::shared_ptr<PendingWrite> pending_write;  ///< null: nothing to wait for
};

/// A unary call that computes its session up to a step in slices, if it has a session, and then
/// answers. The token requests a stop when the caller cancels or the server interrupts its calls;
/// it also stops the engine's work.
class UnaryCall final : public Call<grpc::ServerUnaryReactor> {
 public:
  /// Writes the reply at the step where the cursor ended.
  using Answer = std::function<Answered(const Session&, const Cursor&, const std::stop_token&)>;
  /// Writes the reply of a call without steps.
  using Work = std::function<Answered(const std::stop_token&)>;
  /// The work of an Answer: its price in instructions, 0 for one that only copies, and the kind of
  /// job that does it; nothing if the slice does it that computed the last step.
  struct MoreWork {
    double price = 0;
    std::optional<JobKind> kind = std::nullopt;

    /// Returns that of work of a known price.
    static MoreWork of(double price) {
      return {price, price <= short_work ? std::nullopt : std::optional(kind_of_piece(price))};
    }
  };

  /// `memory` is held until the reply is delivered.
  UnaryCall(Host& host, CallLog log, SessionLease session, std::int64_t to, const MoreWork& more,
            Answer answer, MemoryLease memory);
  /// `price`: the most instructions that the work takes; at least the kind's `price_cap` is billed.
  UnaryCall(Host& host, CallLog log, JobKind kind, double price, Work work,
            MemoryLease memory = {});
  /// Sends a reply that is ready once its change is on disk.
  UnaryCall(Host& host, CallLog log, const Answered& answered, MemoryLease memory);

 private:
  bool run_slice() noexcept override;
  grpc::Status make() override;
  void free() noexcept override;
  std::int64_t computed_steps() const override {
    return cursor_ ? cursor_->computed_steps() : steps_;
  }
  void finish(const Answered& answered);

  std::optional<SessionLease> session_;
  const std::int64_t to_ = 0;
  std::function<Answered()> answer_;
  std::optional<JobKind> more_;  ///< of the job that is left to compute the answer
  bool steps_done_ = true;       ///< whether nothing is left to advance
  std::optional<Cursor> cursor_;
  std::int64_t steps_ = 0;  ///< computed by the cursor that was freed
};

}  // namespace stiefel::server
