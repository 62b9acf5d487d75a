// Where the client sends a token, and where it refuses to.
#include "stiefel/client/security.h"

#include <gmock/gmock.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "client/cpp/channel.h"
#include "server/connections/callers.h"
#include "server/server.h"
#include "stiefel/client/client.h"

namespace stiefel::client {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string refusal(const std::string& address, const Security& security) {
  try {
    make_channel(address, security);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT);
    return error.what();
  }
  return "";
}

TEST(Security, WhichAddressesAreOfThisMachine) {
  for (const char* here : {"127.0.0.1:1", "127.9.9.9:1", "[::1]:1", "localhost:1", "unix:/x"})
    EXPECT_TRUE(is_local(here)) << here;
  for (const char* beyond : {"0.0.0.0:1", "10.0.0.1:1", "[::]:1", "example.org:1", "128.0.0.1:1",
                             "localhost.example.org:1", "dns:///localhost:1"})
    EXPECT_FALSE(is_local(beyond)) << beyond;
}

TEST(Security, ATokenStaysOnThisMachineWithoutTls) {
  const std::string fault = refusal("example.org:1", {.token = "secret-one"});
  EXPECT_THAT(fault, HasSubstr("over TLS, to this machine or over a Unix socket only"));
  EXPECT_THAT(fault, Not(HasSubstr("secret-one")));
  EXPECT_EQ(refusal("127.0.0.1:1", {.token = "secret-one"}), "");
  EXPECT_EQ(refusal("unix:/x", {.token = "secret-one"}), "");
  EXPECT_EQ(refusal("example.org:1", {.tls = Tls{}, .token = "secret-one"}), "");
}

TEST(Security, WhatIsRefused) {
  EXPECT_THAT(refusal("unix:/x", {.tls = Tls{}}), HasSubstr("a Unix socket has no TLS"));
  EXPECT_THAT(refusal("h:1", {.tls = Tls{.ca = "/none"}}), HasSubstr("tls: ca: /none: No such"));
  EXPECT_THAT(refusal("h:1", {.tls = Tls{.key = "/none"}}), HasSubstr("one needs the other"));
  EXPECT_THAT(refusal("127.0.0.1:1", {.token = "a b"}), HasSubstr("printable ASCII"));
}

/// A server with one token, over plaintext on this machine.
TEST(Security, TheTokenReachesTheServer) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "security_test";
  std::filesystem::create_directories(folder);
  const server::NewToken made = server::make_token("me");
  std::ofstream(folder / "tokens") << made.line;
  std::ofstream(folder / "token") << "  " << made.token << " \n";
  const std::string socket = "unix:" + (folder / "socket").string();
  server::Server server({.listen = {"127.0.0.1:0", socket},
                         .log_level = "off",
                         .access = {.tokens = folder / "tokens"}});
  const Options known{.security = {.token = read_token(folder / "token")}};
  for (const std::string& address : server.addresses()) {
    EXPECT_NO_THROW(Client::connect(address, known).describe()) << address;
    try {
      Client::connect(address).describe();
      ADD_FAILURE() << "let in without a token";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), grpc::StatusCode::UNAUTHENTICATED);
      EXPECT_EQ(error.reason(), "TOKEN_MISSING");
    }
  }
  setenv("STIEFEL_TOKEN", made.token.c_str(), 1);
  EXPECT_NO_THROW(Client::connect(server.addresses().front()).describe());
  unsetenv("STIEFEL_TOKEN");
}

}  // namespace
}  // namespace stiefel::client
