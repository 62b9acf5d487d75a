// Every failpoint that calls pass, failing once: each call ends with a typed error or the right
// answer, what a stream said before its error is the beginning of the right answer, and all calls
// after it are as if nothing had failed.
#include "tests/server/failpoints/failpoints.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "server/connections/callers.h"
#include "tests/server/failpoints/every_call.h"
#include "tests/server/store/folder.h"

namespace stiefel::test {
namespace {

using namespace std::chrono_literals;

/// A status that names its reason or the field at fault.
bool is_typed(const grpc::Status& status) {
  v1::Status details;
  return status.error_code() != grpc::UNKNOWN && status.error_code() != grpc::UNIMPLEMENTED &&
         status.error_code() != grpc::DEADLINE_EXCEEDED &&
         details.ParseFromString(status.error_details()) &&
         (details.details_size() > 0 || details.code() == status.error_code());
}

server::Options with_store(const std::string& file) {
  server::Options options;
  options.threads = 2;
  options.log_level = "off";
  options.store.file = file;
  return options;
}

class Server {
 public:
  Server() : harness_(with_store(folder_.file("store"))) {}
  std::vector<Heard> call_all() { return test::call_all(harness_.server.in_process_channel()); }

 private:
  Folder folder_;
  Harness harness_;
};

/// A list misses sessions whose creation failed, and a fork or a checkpoint needs one.
void expect_right(const std::vector<Heard>& heard, const std::vector<Heard>& right) {
  ASSERT_EQ(heard.size(), right.size());
  bool failed = false;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    const Heard& call = heard[i];
    if (!call.status.ok()) {
      failed = true;
      EXPECT_TRUE(is_typed(call.status))
          << call.call << ": " << call.status.error_code() << " " << call.status.error_message();
      EXPECT_TRUE(right[i].said.starts_with(call.said)) << call.call << ": wrong before its error";
    } else if (!(failed && call.call == "list_sessions")) {
      EXPECT_TRUE(call.said == right[i].said) << call.call << ": wrong answer";
    }
  }
}

/// The first of a run, and one in its middle.
std::vector<int> passes_of(int count) {
  std::vector<int> at = {1};
  if (count > 1) at.push_back(count / 2 + 1);
  return at;
}

TEST(Failpoints, EveryOneThatCallsPass) {
  Failpoints failpoints;
  Server server;
  const std::vector<Heard> right = server.call_all();
  for (const Heard& call : right)
    ASSERT_TRUE(call.status.ok()) << call.call << ": " << call.status.error_message();
  failpoints.arm("none", 1, Failure::no_memory);
  expect_right(server.call_all(), right);
  const std::map<std::string, int> passes = Failpoints::passes();
  int armed = 0, failed = 0, refused = 0;
  for (const auto& [name, count] : passes) {
    int which = 0;
    for (const int at : passes_of(count)) {
      SCOPED_TRACE(name + " at pass " + std::to_string(at));
      failpoints.arm(name, at, which++ % 2 == 0 ? Failure::no_memory : Failure::exception);
      const std::vector<Heard> heard = server.call_all();
      ++armed;
      failed += failpoints.disarm();
      refused += std::ranges::any_of(heard, [](const Heard& call) { return !call.status.ok(); });
      expect_right(heard, right);
    }
    SCOPED_TRACE("after " + name);
    const std::vector<Heard> again = server.call_all();
    for (const Heard& call : again)
      EXPECT_TRUE(call.status.ok()) << call.call << ": " << call.status.error_message();
    expect_right(again, right);
    if (HasFailure()) return;
  }
  EXPECT_GE(passes.size(), 25u) << "failpoints that calls pass";
  EXPECT_GE(failed, armed * 3 / 4);  // which passes are made depends on the threads' pace
  EXPECT_GE(refused, failed / 2);
  RecordProperty("failpoints", static_cast<int>(passes.size()));
  RecordProperty("failed", failed);
}

/// What a caller hears of a server's connections, one by one.
grpc::Status describe(const std::string& address, const std::string& token = "") {
  const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
  const auto stub = v1::SimulationService::NewStub(channel);
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  context.set_deadline(std::chrono::system_clock::now() + 30s);
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  v1::DescribeResponse response;
  return stub->Describe(&context, {}, &response);
}

TEST(Failpoints, OfConnections) {
  Failpoints failpoints;
  const Folder folder;
  server::Options options;
  options.listen = {"unix:" + folder.file("socket")};
  options.log_level = "off";
  const server::Server server(options);
  for (const char* name : {"accept.take", "accept.give_away"}) {
    for (const Failure how : {Failure::no_memory, Failure::exception}) {
      failpoints.arm(name, 1, how);
      EXPECT_TRUE(describe(options.listen[0]).ok()) << name;
      EXPECT_TRUE(failpoints.disarm()) << name;
      EXPECT_TRUE(describe(options.listen[0]).ok()) << name;
    }
  }
}

/// New tokens are taken at the next look where the first one fails, and those before stay until
/// then.
TEST(Failpoints, OfTokens) {
  Failpoints failpoints;
  const Folder folder;
  const std::string file = folder.file("tokens");
  const auto alice = server::make_token("alice"), bob = server::make_token("bob");
  std::ofstream(file) << alice.line << '\n';
  server::Options options;
  options.listen = {"unix:" + folder.file("socket")};
  options.log_level = "off";
  options.access.tokens = file;
  const server::Server server(options);
  const std::string& address = options.listen[0];
  EXPECT_TRUE(describe(address, alice.token).ok());
  for (const Failure how : {Failure::no_memory, Failure::exception}) {
    failpoints.arm("tokens.admit", 1, how);
    const grpc::Status refused = describe(address, alice.token);
    EXPECT_FALSE(refused.ok());
    EXPECT_TRUE(is_typed(refused)) << refused.error_message();
    EXPECT_TRUE(failpoints.disarm());
    EXPECT_TRUE(describe(address, alice.token).ok());
  }
  failpoints.arm("tokens.reload", 1, Failure::exception);
  std::ofstream(file) << bob.line << '\n';
  bool taken = false;
  for (int i = 0; i < 100 && !taken; ++i) {
    std::this_thread::sleep_for(100ms);
    taken = describe(address, bob.token).ok();
  }
  EXPECT_TRUE(failpoints.disarm());
  EXPECT_TRUE(taken);
  EXPECT_EQ(describe(address, alice.token).error_code(), grpc::UNAUTHENTICATED);
}

/// The answer of an HTTP server at 127.0.0.1:port to GET /metrics; empty where there is none.
std::string get_metrics(int port) {
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    constexpr std::string_view request = "GET /metrics HTTP/1.0\r\n\r\n";
    if (write(connection, request.data(), request.size()) > 0) {
      char buffer[4096];
      for (ssize_t got; (got = read(connection, buffer, sizeof buffer)) > 0;)
        answer.append(buffer, static_cast<std::size_t>(got));
    }
  }
  close(connection);
  return answer;
}

TEST(Failpoints, OfMetrics) {
  Failpoints failpoints;
  server::Options options;
  options.log_level = "off";
  options.metrics = "127.0.0.1:0";
  const Harness harness(options);
  const std::string url = harness.server.metrics_url();
  const int port = std::stoi(url.substr(url.rfind(':') + 1));
  ASSERT_NE(get_metrics(port).find("stiefel_sessions"), std::string::npos);
  for (const Failure how : {Failure::no_memory, Failure::exception}) {
    failpoints.arm("metrics.collect", 1, how);
    EXPECT_EQ(get_metrics(port).find("stiefel_sessions"), std::string::npos);
    EXPECT_TRUE(failpoints.disarm());
    EXPECT_NE(get_metrics(port).find("stiefel_sessions"), std::string::npos);
  }
}

TEST(Failpoints, OfTheSweeper) {
  Failpoints failpoints;
  server::Options options;
  options.log_level = "off";
  options.idle_timeout = 40ms;
  Harness harness(options);
  harness.create("s", wire_scene());
  failpoints.arm("registry.expire", 1, Failure::exception);
  bool there = true;
  for (int i = 0; i < 500 && there; ++i) {
    std::this_thread::sleep_for(20ms);
    v1::ListSessionsResponse response;
    grpc::ClientContext context;
    ASSERT_TRUE(harness.stub->ListSessions(&context, {}, &response).ok());
    there = response.sessions_size() > 0;
  }
  EXPECT_TRUE(failpoints.disarm());
  EXPECT_FALSE(there);
}

}  // namespace
}  // namespace stiefel::test
