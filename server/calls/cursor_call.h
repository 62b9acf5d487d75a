#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <functional>
#include <optional>
#include <stop_token>

#include "server/calls/answered.h"
#include "server/calls/host.h"
#include "server/scheduling/departure.h"
#include "server/sessions/cursor.h"

namespace stiefel::server {

/// A unary call that computes up to a step on the pool and then answers. Deletes itself.
class CursorCall final : public grpc::ServerUnaryReactor, private Job {
 public:
  /// Writes the reply at the step where the cursor ended.
  using Answer = std::function<Answered(const Session&, const Cursor&)>;
  /// Writes the reply after more work. The token requests a stop when the caller cancels or the
  /// server shuts down, which also stops the engine's work.
  using Search = std::function<Answered(const Session&, const Cursor&, const std::stop_token&)>;
  /// The work of a Search: the pool on which it runs, null for the thread that computed the last
  /// step, and its price in instructions.
  struct Rest {
    Pool* pool = nullptr;
    double price = 0;

    /// Returns that of work of a known price.
    static Rest of(Host& host, double price) {
      return {price <= short_work ? nullptr : &host.pool_for_piece(price), price};
    }
    /// Returns that of work which may take long.
    static Rest search(Host& host, double price) { return {&host.searches, price}; }
  };

  /// `memory` is held until the reply is delivered.
  CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to, Answer answer,
             MemoryLease memory = {});
  CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to, const Rest& rest,
             Search search, MemoryLease memory = {});

  void OnCancel() override;
  void OnDone() override;

 private:
  CursorCall(Host& host, CallLog log, SessionLease session, std::int64_t to, Search search,
             const Rest& rest, MemoryLease memory);
  bool run_slice() noexcept override;
  /// Makes the cursor. Returns false if the call has ended: with an error, or because its caller
  /// left and OnCancel has answered.
  bool make_cursor() noexcept;
  /// Runs one slice; returns true when nothing is left to advance.
  bool advance_cursor();
  void finish(const Answered& answered);
  /// Deletes the call.
  void remove();

  Host& host_;
  CallLog log_;
  Ticket ticket_;
  const MemoryLease memory_;
  std::optional<SessionLease> session_;
  Departure departure_;
  const std::int64_t to_;
  const Search answer_;
  Pool* rest_;                ///< the pool that is left to compute the answer, null if none is
  bool cursor_done_ = false;  ///< whether nothing is left to advance
  std::optional<Cursor> cursor_;
  std::atomic<bool> cancelled_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
};

/// Runs `work` on a pool and answers with what it returns. The token requests a stop when the
/// caller cancels or the server shuts down. Deletes itself.
class PooledCall final : public grpc::ServerUnaryReactor, private Job {
 public:
  using Work = std::function<Answered(std::stop_token)>;

  /// `memory` is held until the reply is delivered. `price`: the most instructions that the work
  /// takes; at least the pool's cap is billed.
  PooledCall(Host& host, Pool& pool, CallLog log, Work work, MemoryLease memory = {},
             double price = 0);
  void OnCancel() override;
  void OnDone() override;

 private:
  bool run_slice() noexcept override;
  void finish(const Answered& answered);

  Host& host_;
  CallLog log_;
  Ticket ticket_;
  const MemoryLease memory_;
  const Work work_;
  std::atomic<bool> cancelled_ = false;
  std::stop_source stop_;
  std::stop_callback<RequestStop> shutdown_;
};

}  // namespace stiefel::server
