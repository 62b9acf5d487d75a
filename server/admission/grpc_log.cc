#include "server/admission/grpc_log.h"

#include <grpc/support/log.h>

#include <mutex>
#include <shared_mutex>
#include <string>
#include <string_view>

#include "server/admission/line_rate.h"

namespace stiefel::server {
namespace {

/// In bytes.
constexpr std::size_t longest_text = 512;

std::shared_mutex mutex;
const Log* taker = nullptr;  // guarded by mutex
LineRate rate;

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

void take(gpr_log_func_args* line) {
  const std::shared_lock lock(mutex);
  if (taker == nullptr || !taker->enabled(level_of(line->severity)) || !rate.take()) return;
  const std::string_view file(line->file);
  Log::Facts facts{
      {"text", std::string(std::string_view(line->message).substr(0, longest_text))},
      {"source", std::string(file.substr(file.rfind('/') + 1)) + ":" + std::to_string(line->line)}};
  if (const std::int64_t count = rate.take_left_out(); count > 0)
    facts.push_back({"left_out_before", count});
  taker->line(level_of(line->severity), "grpc", facts);
}

void set_taker(const Log* log) {
  const std::unique_lock lock(mutex);
  taker = log;
}

}  // namespace

GrpcLog::GrpcLog(const Log& log) {
  set_taker(&log);
  gpr_set_log_function(&take);
}

GrpcLog::~GrpcLog() {
  gpr_set_log_function(nullptr);  // gRPC's own
  set_taker(nullptr);
}

}  // namespace stiefel::server
