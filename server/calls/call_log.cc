#include "server/calls/call_log.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <exception>
#include <random>
#include <utility>

#include "server/convert/errors.h"
#include "server/scheduling/account.h"
#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

std::string new_request_id() {
  thread_local std::mt19937_64 random(std::random_device{}());
  return fmt::format("{:016x}", random());
}

/// Tells gRPC's retries of a refused call when to come back, in the trailing metadata
/// `grpc-retry-pushback-ms`: after the delay of the status, or never (-1) if it has none.
void push_back(const grpc::Status& status, grpc::ServerContextBase& context) {
  if (status.error_code() != grpc::RESOURCE_EXHAUSTED) return;
  const auto delay = errors::retry_delay(status);
  context.AddTrailingMetadata("grpc-retry-pushback-ms",
                              delay ? std::to_string(delay->count()) : "-1");
}

constexpr const char* numerics_key = "stiefel-numerics-id";

/// Returns instructions as an integer, at most 2⁶².
std::int64_t whole(double work) { return static_cast<std::int64_t>(std::min(work, 0x1p62)); }

/// Returns the first 128 bytes, the most that an id may have.
std::string cut(std::string_view text) { return std::string(text.substr(0, 128)); }

/// Returns the trace id in the call's metadata `traceparent` (W3C Trace Context): version, trace id
/// of 32 digits, parent id and flags, 55 characters with the dashes. Empty without one.
std::string trace_id_of(const grpc::ServerContextBase& context) {
  const auto sent = context.client_metadata().find("traceparent");
  if (sent == context.client_metadata().end() || sent->second.size() < 55) return {};
  return {sent->second.data() + 3, 32};
}

}  // namespace

CallLog::CallLog(const Log& log, grpc::ServerContextBase& context, const char* method,
                 CallMetrics* metrics)
    : log_(&log), method_(method), context_(&context), metrics_(metrics) {
  if (log.enabled(Log::Level::info)) {
    const auto sent = context.client_metadata().find("x-request-id");
    details_ = std::make_unique<Details>(Details{
        sent == context.client_metadata().end() ? new_request_id()
                                                : cut({sent->second.data(), sent->second.size()}),
        trace_id_of(context), "", cut(context.peer())});
  }
  if (metrics) metrics->begin(method);
}

void CallLog::tell_numerics() {
  if (!std::exchange(numerics_told_, true))
    context_->AddInitialMetadata(numerics_key, numerics_id());
}

void CallLog::name(std::string_view session_id) {
  if (details_) details_->session_id = cut(session_id);
}

void CallLog::refuse(const grpc::Status& status) const noexcept {
  if (!metrics_ || status.ok() || status.error_code() == grpc::CANCELLED) return;
  try {
    const auto [reason, limit] = errors::reason(status);
    metrics_->refused(reason.empty() ? code_name(status.error_code()) : reason, limit);
  } catch (const std::exception&) {
  }
}

void CallLog::finish(const grpc::Status& status) noexcept {
  refuse(status);
  const auto took = std::chrono::steady_clock::now() - start_;
  if (metrics_)
    metrics_->end(method_, status.error_code(), std::chrono::duration<double>(took).count());
  try {
    push_back(status, *context_);
    // gRPC's clients do not repeat a call whose initial metadata has arrived.
    if (status.ok())
      tell_numerics();
    else if (!numerics_told_)
      context_->AddTrailingMetadata(numerics_key, numerics_id());
    write(status, took);
  } catch (const std::exception&) {
  }
  details_.reset();
}

std::optional<Log::Level> CallLog::level(const grpc::Status& status,
                                         std::chrono::nanoseconds took) const {
  if (status.error_code() == grpc::INTERNAL) return Log::Level::error;
  if (!details_) return std::nullopt;
  if (took >= is_long || !status.ok()) return Log::Level::info;
  return Log::Level::debug;
}

void CallLog::write(const grpc::Status& status, std::chrono::nanoseconds took) const {
  const std::optional<Log::Level> level = this->level(status, took);
  if (!level || !log_->enabled(*level)) return;
  Log::Facts facts;
  if (details_) {
    facts.push_back({"request_id", details_->request_id});
    if (!details_->trace_id.empty()) facts.push_back({"trace_id", details_->trace_id});
  }
  facts.push_back({"method", method_});
  if (details_) {
    facts.push_back({"session", details_->session_id});
    facts.push_back({"peer", details_->peer});
  }
  if (account_ && !account_->principal().name.empty())
    facts.push_back({"principal", account_->principal().name});
  facts.push_back({"code", code_name(status.error_code())});
  if (!status.ok()) facts.push_back({"error", status.error_message()});
  if (details_) {
    facts.push_back({"milliseconds", std::chrono::duration<double, std::milli>(took).count()});
    facts.push_back({"steps", steps_});
    facts.push_back({"work", whole(work_)});
  }
  log_->line(*level, "rpc", facts);
}

}  // namespace stiefel::server
