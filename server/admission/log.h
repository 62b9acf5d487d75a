#pragma once

#include <grpcpp/server_context.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/metrics/call_metrics.h"
#include "server/metrics/open_streams.h"

namespace spdlog {
class logger;
}

namespace stiefel::server {

class Account;

/// Lines on stderr, as text or as JSON. Nothing is formatted below the level asked for.
class Log {
 public:
  enum class Level { debug, info, warn, error };
  using Value = std::variant<std::string, std::int64_t, double>;
  using Fact = std::pair<const char*, Value>;
  using Facts = std::vector<Fact>;

  /// Throws std::runtime_error for an unknown level.
  Log(const std::string& level, bool json);
  ~Log();

  bool enabled(Level level) const;
  void line(Level level, std::string_view message, const Facts& facts = {}) const;

 private:
  std::unique_ptr<spdlog::logger> logger_;
  bool json_;
};

/// What calls are counted in.
struct Metrics {
  explicit Metrics(const std::vector<std::string>& methods) : calls(methods) {}

  CallMetrics calls;
  OpenStreams streams;
};

/// The trace id of the call's metadata `traceparent` (W3C Trace Context); empty without a sound
/// one.
std::string_view trace_id_of(const grpc::CallbackServerContext& context);

/// One RPC's line, whose message is "rpc" however the call ended: request id (the caller's
/// `x-request-id`, or a new one), trace id if there is one, method, session, peer, principal if
/// there is one, code, where it failed the error, duration, steps, the price that was predicted and
/// the work that was done, in instructions. A stream has a line "rpc begins" before. What is logged
/// is counted too, where there are metrics.
class CallLog {
 public:
  CallLog(const Log& log, const grpc::CallbackServerContext& context, const char* method,
          std::string_view session_id = {}, Metrics* metrics = nullptr);
  CallLog(CallLog&&) = default;

  /// Who pays for the call, and where a refusal says when to try again. Before `finish`.
  void bill(Account& account, grpc::CallbackServerContext& context) {
    account_ = &account;
    context_ = &context;
  }
  Account& account() const { return *account_; }

  /// So much more work is predicted, in instructions.
  void price(double work) { price_ += work; }
  /// Counts the work of the slice that this thread runs, for the line. Before a slice ends and the
  /// call does not; `finish` does it, too.
  void worked();
  /// Counts work that was done outside a slice, in instructions; it was its price as well.
  void did(double work) {
    price_ += work;
    work_ += work;
  }

  /// A stream begins: writes its line, if the level is info or below. After `price`, once.
  void begin() noexcept;
  /// The session of a call that did not name it at once.
  void name(std::string_view session_id);
  /// A message of the stream goes to gRPC; gRPC has sent it.
  void writing() noexcept {
    if (stream_) stream_->writing();
  }
  void written() noexcept {
    if (stream_) stream_->written();
  }
  /// Counts an error that the caller is told; `finish` counts that of the call itself.
  void refuse(const grpc::Status& status) const noexcept;

  /// Once; costs nothing when the level is above info. An INTERNAL error is a line of level error.
  /// A line for which there is no memory is not written.
  void finish(const grpc::Status& status, std::int64_t steps = 0) noexcept;

 private:
  void write(const grpc::Status& status, std::int64_t steps) const;
  /// Who and what, of both lines.
  Log::Facts facts() const;

  struct Details {
    std::string request_id;
    std::string trace_id;
    std::string session_id;
    std::string peer;
    std::chrono::steady_clock::time_point start;
  };
  const Log* log_;
  const char* method_;
  Account* account_ = nullptr;
  grpc::CallbackServerContext* context_ = nullptr;
  std::unique_ptr<Details> details_;
  Metrics* metrics_ = nullptr;
  CallMetrics::Running running_;
  std::unique_ptr<OpenStreams::Stream> stream_;
  double price_ = 0, work_ = 0;  // instructions
};

}  // namespace stiefel::server
