// The client's messages about a server that it cannot reach.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <regex>
#include <stop_token>
#include <thread>

#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/error_of.h"
#include "tests/client/wire_scenes.h"

namespace stiefel::client {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace std::chrono_literals;

TEST(Address, IsRefusedBeforeAnythingIsSent) {
  for (const auto& [address, fault] : std::vector<std::pair<std::string, std::string>>{
           {"", "empty"},
           {"localhost", "the port is missing"},
           {"localhost:", "the port is missing"},
           {"localhost:0", "the port 0 is not between 1 and 65535"},
           {"localhost:65536", "the port 65536 is not between 1 and 65535"},
           {"localhost:99999999999999999999", "is not between 1 and 65535"},
           {"localhost:-1", "the port '-1' is not a number"},
           {"localhost:http", "the port 'http' is not a number"},
           {"localhost:50551 ", "HOST:PORT"},
           {":50551", "the host is missing"},
           {"::1:50551", "[IPv6]:PORT"},
           {"[::1]", "the port is missing"},
           {"[::1:50551", "[IPv6]:PORT"},
           {"[::1]50551", "[IPv6]:PORT"},
           {"http://localhost:50551", "without 'http://'"},
           {"/run/stiefel", "unix:PATH"},
           {"unix:", "the socket's path is missing"},
           {"unix:/" + std::string(200, 'x'), "longer than 107 bytes"}}) {
    const Error error = error_of([&] { Client::connect(address); });
    EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT) << address;
    EXPECT_THAT(error.what(), HasSubstr(fault)) << address;
  }
  for (const char* address : {"localhost:1", "10.0.0.1:65535", "[::1]:50551", "unix:/run/stiefel",
                              "unix:relative", "dns:///localhost:50551", "ipv4:127.0.0.1:50551"}) {
    EXPECT_NO_THROW(Client::connect(address)) << address;
  }
}

/// A port of this machine where nothing listens: bound, so that nobody else gets it.
class SilentPort {
 public:
  SilentPort() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in here = {};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    auto* any = reinterpret_cast<sockaddr*>(&here);
    EXPECT_EQ(::bind(socket_, any, size), 0);
    EXPECT_EQ(::getsockname(socket_, any, &size), 0);
    port_ = ntohs(here.sin_port);
  }
  ~SilentPort() { ::close(socket_); }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  int socket_;
  int port_ = 0;
};

TEST(Unreachable, IsToldInPlainWords) {
  const SilentPort silent;
  const Options hasty{.patience = 0ms};
  for (const auto& [address, reason] : std::vector<std::pair<std::string, std::string>>{
           {silent.address(), "the connection is refused, nothing listens there"},
           {"no-such-host.invalid:50551", ""},
           {"unix:" + testing::TempDir() + "nobody-here", "there is no such socket"}}) {
    const Error error = error_of([&] { Client::connect(address, hasty).describe(); });
    EXPECT_EQ(error.code(), grpc::StatusCode::UNAVAILABLE);
    EXPECT_THAT(error.what(), StartsWith("cannot reach " + address + ": " + reason));
    for (const char* jargon : {"ares", "ARES", "addresses", "DNS", "ipv4:", "UNKNOWN"})
      EXPECT_THAT(error.what(), Not(HasSubstr(jargon)));
  }
}

TEST(Unreachable, GrpcsOwnWordsAreTranslated) {
  const auto told = [](const std::string& message) {
    return in_plain_words({grpc::StatusCode::UNAVAILABLE, message}, "host:1", false)
        .error_message();
  };
  EXPECT_EQ(told("DNS resolution failed for host:1: C-ares status is not ARES_SUCCESS qtype=A "
                 "name=host is_balancer=0: Domain name not found"),
            "cannot reach host:1: the name is unknown");
  EXPECT_EQ(told("DNS resolution failed for host:1: C-ares status is not ARES_SUCCESS qtype=AAAA "
                 "name=host is_balancer=0: Could not contact DNS servers"),
            "cannot reach host:1: no name server answers");
  EXPECT_EQ(told("failed to connect to all addresses; last error: UNKNOWN: ipv4:10.0.0.1:1: Failed "
                 "to connect to remote host: No route to host"),
            "cannot reach host:1: there is no route to this host");
  EXPECT_EQ(told("failed to connect to all addresses; last error: UNKNOWN: ipv4:10.0.0.1:1: Failed "
                 "to connect to remote host: Some new trouble"),
            "cannot reach host:1: Some new trouble");
  const std::string last =
      "failed to connect to all addresses; last error: UNKNOWN: ipv4:10.0.0.1:1: ";
  EXPECT_EQ(told(last + "Ssl handshake failed: SSL_ERROR_SSL: error:0A00010B:SSL routines::wrong "
                        "version number"),
            "cannot reach host:1: it does not speak TLS");
  EXPECT_EQ(told(last + "Trying to connect an http1.x server"),
            "cannot reach host:1: nothing that speaks gRPC answers there");
  EXPECT_EQ(told(last + "Socket closed"),
            "cannot reach host:1: it closes the connection, as a server with TLS does to a client "
            "without");
}

TEST(Unreachable, AnAnswerWithoutDetailsIsTranslatedToo) {
  const auto told = [](grpc::StatusCode code, const std::string& message) {
    return in_plain_words({code, message}, "host:1", true).error_message();
  };
  using enum grpc::StatusCode;
  EXPECT_THAT(told(RESOURCE_EXHAUSTED, "Received RST_STREAM with error code 11"),
              HasSubstr("such as its token, is too large, or too many calls or bytes come at once"));
  EXPECT_EQ(told(RESOURCE_EXHAUSTED, "received initial metadata size exceeds limit"),
            "the call's metadata, such as its token, is larger than the server takes");
  EXPECT_EQ(told(UNIMPLEMENTED, "Received http2 header with status: 404"),
            "a web server answers there, not a stiefel server");
  EXPECT_EQ(told(DEADLINE_EXCEEDED, "Deadline Exceeded"), "the call took longer than its timeout");
  EXPECT_EQ(told(UNAVAILABLE, "Socket closed"), "cannot reach host:1: the connection broke");
}

TEST(Unreachable, TooMuchAtOnceIsTriedAgainUntilThePausesAreUsedUp) {
  using enum grpc::StatusCode;
  const grpc::Status calm(RESOURCE_EXHAUSTED, "Received RST_STREAM with error code 11");
  Patience patience(nullptr, 60ms);
  EXPECT_TRUE(patience.allows_another(calm));
  EXPECT_TRUE(patience.allows_another(calm));
  EXPECT_FALSE(patience.allows_another(calm)) << "after 25 and 50 ms";
  for (const auto& other : {grpc::Status(RESOURCE_EXHAUSTED, "received initial metadata size"),
                            grpc::Status(RESOURCE_EXHAUSTED, calm.error_message(), "details"),
                            grpc::Status(UNIMPLEMENTED, calm.error_message())})
    EXPECT_FALSE(Patience(nullptr, 1min).allows_another(other)) << other.error_message();
}

TEST(Unreachable, WhatAServerSaysItselfIsLeftAsItIs) {
  const grpc::Status said(grpc::StatusCode::UNAVAILABLE, "the server is shutting down", "details");
  EXPECT_EQ(in_plain_words(said, "host:1", true).error_message(), said.error_message());
  const grpc::Status other(grpc::StatusCode::NOT_FOUND, "session_id: x: there is no such session");
  EXPECT_EQ(in_plain_words(other, "host:1", true).error_message(), other.error_message());
}

TEST(Late, SaysWhereTheSessionStandsAndHowLongTheStepsTake) {
  server::Server server({.listen = {"127.0.0.1:0"}, .log_level = "off"});
  const Client client(server.in_process_channel(), {.compute_timeout = 300ms});
  const auto session = client.create(tumbling());
  constexpr std::int64_t to = 1'000'000'000'000;
  const double each = session.description().step_price().work();
  const std::vector<std::function<void()>> calls = {
      [&] { session.step(to); }, [&] { session.diagnose(to); },
      [&] {
        auto stream = session.stream({.to = to, .every = to});
        while (stream.next_batch() != nullptr) {
        }
      },
      [&] {
        v1::SummarizeRequest request;
        request.set_to(to);
        request.set_every(to);
        session.summarize(request, [](const v1::SummarizeResponse&) { return true; });
      }};
  const std::regex told(
      "the call took longer than its timeout; it takes about (\\S+) s of one core \\((\\S+) "
      "instructions\\): step 1000000000000 was not reached; the session stands at step ([0-9]+), "
      "from where the same call goes on");
  for (const auto& call : calls) {
    const Error error = error_of(call);
    EXPECT_EQ(error.code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    const std::string text = error.what();
    std::smatch found;
    ASSERT_TRUE(std::regex_match(text, found, told)) << text;
    const double work = each * static_cast<double>(to);
    EXPECT_NEAR(std::stod(found[2]), work, 0.1 * work);
    EXPECT_NEAR(std::stod(found[1]), work / 5e9, 0.1 * work / 5e9);
    EXPECT_LT(std::stoll(found[3]), to);
  }
}

TEST(Stop, CancelsWhatRunsAndWhatIsYetToBegin) {
  server::Server server({.listen = {"127.0.0.1:0"}, .log_level = "off"});
  std::stop_source source;
  const Client client(server.in_process_channel(), {.stop = source.get_token()});
  auto session = client.create(tumbling());
  auto stream = session.stream({.to = 1'000'000'000'000, .every = 1'000'000'000});
  std::jthread stopper([&] {
    std::this_thread::sleep_for(100ms);
    source.request_stop();
  });
  const Error error = error_of([&] {
    while (stream.next_batch() != nullptr) {
    }
  });
  EXPECT_EQ(error.code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(error_of([&] { session.step(1'000'000'000'000); }).code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(error_of([&] { client.describe(); }).code(), grpc::StatusCode::CANCELLED);
}

}  // namespace
}  // namespace stiefel::client
