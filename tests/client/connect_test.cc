// Addresses, TLS and tokens: what the client refuses, and what reaches a server.
#include <gmock/gmock.h>
#include <stdlib.h>

#include "server/connections/callers.h"
#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/error_of.h"
#include "tests/support/folder.h"

namespace stiefel::client {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Returns why the client refuses to connect; empty if it does not.
std::string refusal(const std::string& address, const Options& options = {}) {
  try {
    Client::connect(address, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT);
    return error.what();
  }
  return "";
}

TEST(Address, IsRefusedBeforeAnythingIsSent) {
  for (const auto& [address, fault] : std::vector<std::pair<std::string, std::string>>{
           {"", "empty"},
           {"localhost", "the port is missing"},
           {"localhost:0", "the port 0 is not between 1 and 65535"},
           {"localhost:99999999999999999999", "is not between 1 and 65535"},
           {"localhost:http", "the port 'http' is not a number"},
           {":50551", "the host is missing"},
           {"::1:50551", "[IPv6]:PORT"},
           {"[::1]", "the port is missing"},
           {"[::1]50551", "[IPv6]:PORT"},
           {"http://localhost:50551", "without 'http://'"},
           {"unix:", "the socket's path is missing"},
           {"unix:/" + std::string(200, 'x'), "longer than 107 bytes"}}) {
    EXPECT_THAT(refusal(address), HasSubstr(fault)) << address;
  }
  for (const char* address : {"localhost:1", "10.0.0.1:65535", "[::1]:50551", "unix:/run/stiefel",
                              "unix:relative", "dns:///localhost:50551", "ipv4:127.0.0.1:50551"})
    EXPECT_EQ(refusal(address), "") << address;
}

TEST(Token, StaysOnThisMachineWithoutTls) {
  const Options secret{.token = "secret-one"};
  for (const char* here :
       {"127.0.0.1:1", "127.9.9.9:1", "[::1]:1", "localhost:1", "unix:/run/stiefel"})
    EXPECT_EQ(refusal(here, secret), "") << here;
  for (const char* beyond : {"0.0.0.0:1", "10.0.0.1:1", "[::]:1", "example.org:1", "128.0.0.1:1",
                             "localhost.example.org:1", "dns:///localhost:1"}) {
    EXPECT_THAT(refusal(beyond, secret),
                HasSubstr("over TLS, to this machine or over a Unix socket only"))
        << beyond;
    EXPECT_THAT(refusal(beyond, secret), Not(HasSubstr("secret-one")));
    EXPECT_EQ(refusal(beyond, {.tls = Tls{}, .token = "secret-one"}), "") << beyond;
  }
}

TEST(Security, WhatIsRefused) {
  EXPECT_THAT(refusal("unix:/x", {.tls = Tls{}}), HasSubstr("a Unix socket has no TLS"));
  EXPECT_THAT(refusal("h:1", {.tls = Tls{.ca = "/none"}}), HasSubstr("tls: ca: /none: No such"));
  EXPECT_THAT(refusal("h:1", {.tls = Tls{.key = "/none"}}), HasSubstr("one needs the other"));
  EXPECT_THAT(refusal("127.0.0.1:1", {.token = "a b"}), HasSubstr("printable ASCII"));
}

class SecurityTest : public testing::Test {
 protected:
  SecurityTest() {
    test::write_file(folder_.file("tokens"), made_.line);
    test::write_file(folder_.file("token"), "  " + made_.token + " \n");
    known_.token = read_token(folder_.file("token"));
  }

  const test::Folder folder_;
  const server::NewToken made_ = server::make_token("me");
  Options known_;
};

TEST_F(SecurityTest, TheTokenReachesTheServer) {
  const std::string socket = "unix:" + folder_.file("socket");
  server::Server server({.listen = {"127.0.0.1:0", socket},
                         .log_level = "off",
                         .access = {.tokens = folder_.file("tokens")}});
  for (const std::string& address : server.addresses()) {
    EXPECT_NO_THROW(Client::connect(address, known_).describe()) << address;
    const Error error = error_of([&] { Client::connect(address).describe(); });
    EXPECT_EQ(error.code(), grpc::StatusCode::UNAUTHENTICATED);
    EXPECT_EQ(error.reason(), "TOKEN_MISSING");
  }
  setenv("STIEFEL_TOKEN", made_.token.c_str(), 1);
  EXPECT_NO_THROW(Client::connect(server.addresses().front()).describe());
  unsetenv("STIEFEL_TOKEN");
}

TEST_F(SecurityTest, TheTokenTravelsOverTlsToAServerOfTheName) {
  const std::string certificate = folder_.file("certificate"), key = folder_.file("key");
  const std::string command =
      "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=stiefel "
      "-addext subjectAltName=DNS:stiefel -out '" +
      certificate + "' -keyout '" + key + "' 2>/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  server::Server server(
      {.listen = {"127.0.0.1:0"},
       .log_level = "off",
       .access = {.tls = {certificate, key, ""}, .tokens = folder_.file("tokens")}});
  const std::string address = server.addresses().front();
  known_.tls = Tls{.ca = certificate, .name = "stiefel"};
  EXPECT_NO_THROW(Client::connect(address, known_).describe());
  known_.tls->name = "another";
  EXPECT_EQ(error_of([&] { Client::connect(address, known_).describe(); }).code(),
            grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace stiefel::client
