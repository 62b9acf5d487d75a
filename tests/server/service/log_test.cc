// The line that a call leaves in the log.
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "server/calls/call_log.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

using Lines = std::vector<nlohmann::json>;

/// The lines that `work` logs as JSON.
template <class Work>
Lines logged(Work work) {
  testing::internal::CaptureStderr();
  work();
  std::istringstream text(testing::internal::GetCapturedStderr());
  Lines lines;
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

nlohmann::json only(const Lines& lines, const std::string& method) {
  nlohmann::json found;
  for (const auto& line : lines) {
    if (line.value("method", "") != method) continue;
    EXPECT_TRUE(found.is_null()) << "more than one line of " << method;
    found = line;
  }
  return found;
}

TEST(Log, AnInternalErrorIsToldAtEveryLevel) {
  for (const char* level : {"debug", "error"}) {
    const Lines lines = logged([&] {
      const server::Log log(level, true);
      grpc::ServerContext context;
      server::CallLog(log, context, "Step").finish({grpc::INTERNAL, "out of \"luck\""});
      server::CallLog(log, context, "Describe").finish(grpc::Status::OK);
    });
    const auto line = only(lines, "Step");
    EXPECT_EQ(line["message"], "rpc");
    EXPECT_EQ(line["level"], "error");
    EXPECT_EQ(line["code"], "INTERNAL");
    EXPECT_EQ(line["error"], "out of \"luck\"");
    EXPECT_EQ(only(lines, "Describe").is_null(), std::string(level) == "error");
  }
}

TEST(Log, ShortCallsThatSucceedHaveNoLineAtInfo) {
  const Lines lines = logged([] {
    const server::Log log("info", true);
    grpc::ServerContext context;
    for (int i = 0; i < 100; ++i) server::CallLog(log, context, "Step").finish(grpc::Status::OK);
    server::CallLog(log, context, "GetSession").finish({grpc::NOT_FOUND, "no such session"});
    server::CallLog slow(log, context, "Stream");
    std::this_thread::sleep_for(server::CallLog::is_long);
    slow.finish(grpc::Status::OK);
  });
  for (const auto& line : lines)
    EXPECT_TRUE(line["code"] == "NOT_FOUND" || line["milliseconds"] >= 10.0) << line;
  EXPECT_FALSE(only(lines, "GetSession").is_null());
  EXPECT_FALSE(only(lines, "Stream").is_null());
}

}  // namespace
}  // namespace stiefel
