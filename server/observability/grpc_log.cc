#include <grpc/support/log.h>

#include <mutex>
#include <shared_mutex>
#include <string>
#include <string_view>

#include "server/observability/log.h"

namespace stiefel::server {
namespace {

/// In bytes.
constexpr std::size_t longest_text = 512;

/// The log that takes the lines.
struct Taker {
  std::shared_mutex mutex;
  const Log* log = nullptr;  // guarded by mutex
  LineRate rate;
} taker_of_grpc;

Log::Level level_of(gpr_log_severity severity) {
  switch (severity) {
    case GPR_LOG_SEVERITY_DEBUG:
      return Log::Level::debug;
    case GPR_LOG_SEVERITY_INFO:
      return Log::Level::info;
    case GPR_LOG_SEVERITY_ERROR:
      break;
  }
  return Log::Level::warn;  // most are faults of a caller
}

void take_line(gpr_log_func_args* line) {
  Taker& taker = taker_of_grpc;
  const std::shared_lock lock(taker.mutex);
  if (taker.log == nullptr || !taker.log->enabled(level_of(line->severity)) || !taker.rate.take())
    return;
  const std::string_view file(line->file);
  Log::Facts facts{
      {"text", std::string(std::string_view(line->message).substr(0, longest_text))},
      {"source", std::string(file.substr(file.rfind('/') + 1)) + ":" + std::to_string(line->line)}};
  if (const std::int64_t count = taker.rate.take_left_out(); count > 0)
    facts.push_back({"left_out_before", count});
  taker.log->line(level_of(line->severity), "grpc", facts);
}

void set_taker(const Log* log) {
  const std::unique_lock lock(taker_of_grpc.mutex);
  taker_of_grpc.log = log;
}

}  // namespace

GrpcLog::GrpcLog(const Log& log) {
  set_taker(&log);
  gpr_set_log_function(&take_line);
}

GrpcLog::~GrpcLog() {
  gpr_set_log_function(nullptr);  // gRPC's own
  set_taker(nullptr);
}

}  // namespace stiefel::server
