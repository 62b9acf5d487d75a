#pragma once

#include <grpcpp/server_context.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/connections/log.h"
#include "server/connections/metrics.h"

namespace stiefel::server {

class Account;

/// Writes the log line of one RPC, with the message "rpc" however the call ended: request id (the
/// caller's `x-request-id`, or a new one), trace id if there is one, method, session, peer,
/// principal if there is one, code, the error if it failed, duration, steps, and the work done in
/// instructions. Above the level debug a call of less than `is_long` that succeeds has no line.
/// Also counts the call in the metrics, if there are any, and tells the caller the numerics id.
class CallLog {
 public:
  CallLog(const Log& log, grpc::ServerContextBase& context, const char* method,
          CallMetrics* metrics = nullptr);
  static constexpr std::chrono::milliseconds is_long{10};

  /// Sets who pays for the call.
  void bill(Account& account) { account_ = &account; }
  Account& account() const { return *account_; }

  /// Adds work, in instructions, and the steps that it computed.
  void did(double work, std::int64_t steps = 0) {
    work_ += work;
    steps_ += steps;
  }

  /// Sets the session.
  void name(std::string_view session_id);
  /// Puts the numerics id into the initial metadata, once. Call it before a message is sent.
  void tell_numerics();
  /// Counts an error that the caller is told. `finish` counts that of the call itself.
  void refuse(const grpc::Status& status) const noexcept;

  /// Ends the call in the metrics, completes the reply's metadata, and writes the call's line. Call
  /// it once. The line costs nothing when the level is above info; that of an INTERNAL error has
  /// the level error. Without memory the line is lost.
  void finish(const grpc::Status& status) noexcept;

 private:
  void write(const grpc::Status& status, std::chrono::nanoseconds took) const;
  /// Returns the level of the line of a call that ended so after that time; nothing if it has none.
  std::optional<Log::Level> level(const grpc::Status& status, std::chrono::nanoseconds took) const;

  struct Details {
    std::string request_id;
    std::string trace_id;
    std::string session_id;
    std::string peer;
  };
  const Log* log_;
  const char* method_;
  Account* account_ = nullptr;
  grpc::ServerContextBase* context_;
  bool numerics_told_ = false;
  std::unique_ptr<Details> details_;
  CallMetrics* metrics_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double work_ = 0;  // instructions
  std::int64_t steps_ = 0;
};

}  // namespace stiefel::server
