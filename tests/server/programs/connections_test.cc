// Connections whose peer is silent, or pings: what the server does with them, with short times.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <string>
#include <thread>

#include "server/scheduling/process.h"
#include "server/server.h"

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;
using namespace std::string_literals;
using Clock = std::chrono::steady_clock;

const std::string preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0"s;
const std::string settings_taken = "\0\0\0\4\1\0\0\0\0"s;
const std::string ping = "\0\0\10\6\0\0\0\0\0stiefel!"s;

Options on_a_free_port(ConnectionOptions connections) {
  return {.listen = {"127.0.0.1:0"}, .connections = std::move(connections)};
}

/// A client that says hello and from then on only what it is told to.
Descriptor hello(const Server& server) {
  const std::string& address = server.addresses()[0];
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<in_port_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  inet_pton(AF_INET, "127.0.0.1", &at.sin_addr);
  Descriptor socket(::socket(AF_INET, SOCK_STREAM, 0));
  EXPECT_EQ(connect(socket.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  send(socket.get(), preface.data(), preface.size(), MSG_NOSIGNAL);
  send(socket.get(), settings_taken.data(), settings_taken.size(), MSG_NOSIGNAL);
  return socket;
}

/// The bytes received within `time`; `ended` when the connection was closed.
struct Heard {
  std::string bytes;
  bool ended = false;
};
Heard hear(const Descriptor& socket, std::chrono::milliseconds time) {
  Heard heard;
  const auto until = Clock::now() + time;
  while (!heard.ended) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
    pollfd one{socket.get(), POLLIN, 0};
    if (left.count() <= 0 || poll(&one, 1, static_cast<int>(left.count())) != 1) break;
    char bytes[4096];
    const ssize_t got = recv(socket.get(), bytes, sizeof bytes, 0);
    if (got <= 0) heard.ended = true;
    if (got > 0) heard.bytes.append(bytes, static_cast<std::size_t>(got));
  }
  return heard;
}

TEST(Connections, APeerThatAnswersNoPingIsGone) {
  const Server server(on_a_free_port({.keepalive = 300ms, .keepalive_timeout = 300ms}));
  const Descriptor socket = hello(server);
  const auto start = Clock::now();
  EXPECT_TRUE(hear(socket, 5s).ended);
  EXPECT_GT(Clock::now() - start, 400ms) << "it was given the time to answer";
  EXPECT_LT(Clock::now() - start, 3s);
}

/// The third ping without data between is the one that gRPC holds back by default.
TEST(Connections, APeerThatAnswersPingsStays) {
  const Server server(on_a_free_port({.keepalive = 200ms, .keepalive_timeout = 2s}));
  const Descriptor socket = hello(server);
  int pings = 0;
  for (const auto start = Clock::now(); Clock::now() - start < 3s;) {
    const Heard heard = hear(socket, 50ms);
    ASSERT_FALSE(heard.ended) << "after " << pings << " pings";
    for (std::size_t at = 0; at + 17 <= heard.bytes.size(); ++at) {
      if (heard.bytes.compare(at, 9, "\0\0\10\6\0\0\0\0\0"s) != 0) continue;
      const std::string answer = "\0\0\10\6\1\0\0\0\0"s + heard.bytes.substr(at + 9, 8);
      send(socket.get(), answer.data(), answer.size(), MSG_NOSIGNAL);
      ++pings;
    }
  }
  EXPECT_GE(pings, 5);
}

Heard ping_every(std::chrono::milliseconds interval, const Descriptor& socket) {
  for (int i = 0; i < 8; ++i) {
    send(socket.get(), ping.data(), ping.size(), MSG_NOSIGNAL);
    std::this_thread::sleep_for(interval);
  }
  return hear(socket, 200ms);
}

TEST(Connections, PingsAreWelcomeUpToARate) {
  EXPECT_LE(ConnectionOptions().least_ping_interval, 10s);
  EXPECT_LT(ConnectionOptions().keepalive + ConnectionOptions().keepalive_timeout, 30s);
  const Server server(on_a_free_port({.least_ping_interval = 100ms}));
  const Heard slow = ping_every(300ms, hello(server));
  EXPECT_FALSE(slow.ended);
  EXPECT_EQ(slow.bytes.find("too_many_pings"), std::string::npos);
  EXPECT_NE(ping_every(5ms, hello(server)).bytes.find("too_many_pings"), std::string::npos);
}

}  // namespace
}  // namespace stiefel::server
