#pragma once

#include <grpcpp/server_context.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/observability/log.h"
#include "server/observability/metrics.h"

namespace stiefel::server {

class Account;

/// The metrics in which calls are counted.
struct Metrics {
  explicit Metrics(const std::vector<std::string>& methods) : calls(methods) {}

  CallMetrics calls;
  OpenStreams streams;
};

/// Returns the trace id of the call's metadata `traceparent` (W3C Trace Context); empty without a
/// valid one.
std::string_view trace_id_of(const grpc::ServerContextBase& context);

/// Writes the log line of one RPC, with the message "rpc" however the call ended: request id (the
/// caller's `x-request-id`, or a new one), trace id if there is one, method, session, peer,
/// principal if there is one, code, the error if it failed, duration, steps, and the predicted
/// price and the work done in instructions. Above the level debug a call of less than `is_long`
/// that succeeds is only counted. For a long stream a line "rpc begins" comes first. Also counts
/// the call in the metrics, if there are any.
class CallLog {
 public:
  CallLog(const Log& log, const grpc::ServerContextBase& context, const char* method,
          Metrics* metrics = nullptr);
  CallLog(CallLog&&) = default;
  static constexpr std::chrono::milliseconds is_long{10};

  /// Sets who pays for the call, and the context by which a refusal tells when to try again. Call
  /// it before `finish`.
  void bill(Account& account, grpc::ServerContextBase& context) {
    account_ = &account;
    context_ = &context;
  }
  Account& account() const { return *account_; }

  /// Adds to the predicted price, in instructions.
  void price(double work) { price_ += work; }
  /// Puts the price of a call of 10⁹ instructions or more into its initial metadata, as
  /// `stiefel-work`, so that a caller whose deadline passes can say how long the call takes.
  /// `at_most`: whether the call may end long before it has taken its price. Returns whether there
  /// is such metadata to send.
  bool tell_price(bool at_most) const;
  /// Adds the work of the slice that this thread runs. Call it before a slice ends that does not
  /// end the call; `finish` does the same.
  void worked();
  /// Adds work, in instructions, that was done outside a slice, to both the price and the work, and
  /// the steps that it computed.
  void did(double work, std::int64_t steps = 0) {
    price_ += work;
    work_ += work;
    steps_ += steps;
  }

  /// Begins a stream. Call it once, after `price`. Its line is written now if the price is one of a
  /// long call or the level debug, otherwise when the stream works or writes after `is_long`.
  void begin() noexcept;
  /// Sets the session.
  void name(std::string_view session_id);
  /// Call `writing` when a message of the stream goes to gRPC, `written` when gRPC has sent it.
  void writing() noexcept {
    if (stream_) stream_->writing();
    if (details_ && details_->begins) begin_if_long();
  }
  void written() noexcept {
    if (stream_) stream_->written();
  }
  /// Counts an error that the caller is told. `finish` counts that of the call itself.
  void refuse(const grpc::Status& status) const noexcept;

  /// Ends the call in the metrics and writes its line. Call it once. The line costs nothing when
  /// the level is above info; that of an INTERNAL error has the level error. Without memory the
  /// line is lost.
  void finish(const grpc::Status& status, std::int64_t steps = 0) noexcept;

 private:
  void write(const grpc::Status& status, std::int64_t steps) const;
  /// Returns the level of the line of a call that ended so after that time; nothing if it has none.
  std::optional<Log::Level> level(const grpc::Status& status, std::chrono::nanoseconds took) const;
  void begin_if_long() noexcept;
  void tell_begin(Log::Level level) noexcept;
  /// Returns the facts of both lines: who calls and what.
  Log::Facts facts() const;

  struct Details {
    std::string request_id;
    std::string trace_id;
    std::string session_id;
    std::string peer;
    std::chrono::steady_clock::time_point start;
    bool begins = false;  // whether the line "rpc begins" is still to be written
  };
  const Log* log_;
  const char* method_;
  Account* account_ = nullptr;
  grpc::ServerContextBase* context_ = nullptr;
  std::unique_ptr<Details> details_;
  Metrics* metrics_ = nullptr;
  CallMetrics::Running running_;
  std::unique_ptr<OpenStreams::Stream> stream_;
  double price_ = 0, work_ = 0;  // instructions
  std::int64_t steps_ = 0;       // outside slices
};

}  // namespace stiefel::server
