// The line that a call leaves in the log.
#include <nlohmann/json.hpp>
#include <sstream>

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

TEST(Log, ACallIsALineOfTheSameMessageHoweverItEnds) {
  const Lines lines = logged([] {
    test::Harness harness({.log_level = "debug", .log_json = true});
    harness.create("s", test::wire_scene());
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id("nobody");
    v1::GetSessionResponse response;
    EXPECT_EQ(harness.stub->GetSession(&context, request, &response).error_code(), grpc::NOT_FOUND);
  });
  const auto good = only(lines, "CreateSession"), bad = only(lines, "GetSession");
  EXPECT_EQ(good["message"], "rpc");
  EXPECT_EQ(good["code"], "OK");
  EXPECT_EQ(good["session"], "s");
  EXPECT_FALSE(good.contains("error"));
  EXPECT_EQ(bad["message"], "rpc");
  EXPECT_EQ(bad["level"], "info") << "the first failures of a second are told at info";
  EXPECT_EQ(bad["code"], "NOT_FOUND");
  EXPECT_EQ(bad["session"], "nobody");
  EXPECT_EQ(bad["error"], "session_id: nobody: there is no such session");
  for (const char* key : {"time", "request_id", "milliseconds", "steps"})
    EXPECT_TRUE(bad.contains(key)) << key;
}

TEST(Log, AnInternalErrorIsToldAtEveryLevel) {
  for (const char* level : {"debug", "error"}) {
    const Lines lines = logged([&] {
      const server::Log log(level, true);
      const grpc::ServerContext context;
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

/// Calls below 10 ms are counted; of those that fail the first ten of a second are told as well.
TEST(Log, ShortCallsAreCountedTogether) {
  constexpr int good = 300, bad = 50;
  const Lines lines = logged([] {
    const server::Log log("info", true);
    const grpc::ServerContext context;
    for (int i = 0; i < good; ++i) server::CallLog(log, context, "Step").finish(grpc::Status::OK);
    for (int i = 0; i < bad; ++i)
      server::CallLog(log, context, "GetSession").finish({grpc::NOT_FOUND, "no such session"});
    log.tell_counted();
    log.tell_counted();
  });
  std::int64_t told = 0, failed = 0, counted = 0, counted_failed = 0;
  for (const auto& line : lines) {
    if (line["message"] == "rpc") {
      ++told;
      failed += line["code"] == "NOT_FOUND";
      EXPECT_TRUE(line["code"] == "NOT_FOUND" || line["milliseconds"] >= 10.0);
    } else {
      EXPECT_EQ(line["message"], "short rpcs");
      counted += line["count"].get<std::int64_t>();
      counted_failed += line["failed"].get<std::int64_t>();
    }
  }
  EXPECT_EQ(told + counted, good + bad);
  EXPECT_EQ(failed + counted_failed, bad);
  EXPECT_GE(failed, 10);
  EXPECT_LT(failed, bad) << "unless fifty calls take five seconds";
}

TEST(Log, LinesOfAKindAreLimitedEachSecond) {
  server::LineRate rate;
  auto now = server::LineRate::Clock::now();
  const auto taken = [&](int asked) {
    int lines = 0;
    for (int i = 0; i < asked; ++i) lines += rate.take(now);
    return lines;
  };
  EXPECT_EQ(taken(25), 10);
  EXPECT_EQ(rate.take_left_out(), 15);
  EXPECT_EQ(rate.take_left_out(), 0);
  now += std::chrono::milliseconds(999);
  EXPECT_EQ(taken(1), 0);
  now += std::chrono::milliseconds(1);
  EXPECT_EQ(taken(3), 3);
}

}  // namespace
}  // namespace stiefel
