#pragma once

#include <grpcpp/server_context.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

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

/// One RPC's line, whose message is "rpc" however the call ended: request id (the caller's
/// `x-request-id`, or a new one), method, session, code, where it failed the error, duration,
/// steps.
class CallLog {
 public:
  CallLog(const Log& log, const grpc::CallbackServerContext& context, const char* method,
          std::string_view session_id = {});
  CallLog(CallLog&&) = default;

  /// Who pays for the call, and where a refusal says when to try again. Before `finish`.
  void bill(Account& account, grpc::CallbackServerContext& context) {
    account_ = &account;
    context_ = &context;
  }
  Account& account() const { return *account_; }

  /// Once; costs nothing when the level is above info. An INTERNAL error is a line of level error.
  /// A line for which there is no memory is not written.
  void finish(const grpc::Status& status, std::int64_t steps = 0) noexcept;

 private:
  void write(const grpc::Status& status, std::int64_t steps) const;

  struct Details {
    std::string request_id;
    std::string session_id;
    std::chrono::steady_clock::time_point start;
  };
  const Log* log_;
  const char* method_;
  Account* account_ = nullptr;
  grpc::CallbackServerContext* context_ = nullptr;
  std::unique_ptr<Details> details_;
};

}  // namespace stiefel::server
