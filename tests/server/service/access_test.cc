// What guards the service, without sockets: tokens and addresses.
#include <gtest/gtest.h>

#include "server/connections/callers.h"
#include "server/connections/listener.h"

namespace stiefel::server {
namespace {

const std::string digits(64, 'a');

TEST(Tokens, OfEachLine) {
  const auto alice = make_token("alice"), second = make_token("alice"), bob = make_token("bob");
  const auto [table, faults] =
      parse_tokens("# comment\n\n  " + alice.line + "\t\r\n" + second.line + '\n' + bob.line);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(table.size(), 3u);
  for (const auto& [token, name] :
       {std::pair{alice.token, "alice"}, {second.token, "alice"}, {bob.token, "bob"}})
    EXPECT_EQ(table.at(*digest_of_bearer("Bearer " + token)).name, name);
  EXPECT_FALSE(table.contains(""));
}

TEST(Tokens, LinesThatAreNoneLetNobodyIn) {
  const auto good = make_token("good");
  const auto [table, faults] = parse_tokens("a\n" + good.line + "\nb " + digits + "b\nc/d " +
                                            digits + "\ne " + digits + " more\n" + good.line);
  EXPECT_EQ(table.size(), 1u);
  ASSERT_EQ(faults.size(), 5u);
  const char* lines[] = {"line 1: ", "line 3: ", "line 4: ", "line 5: ", "line 6: "};
  for (std::size_t i = 0; i < faults.size(); ++i) {
    EXPECT_TRUE(faults[i].starts_with(lines[i])) << faults[i];
    EXPECT_EQ(faults[i].find(digits), std::string::npos) << "it shows what may be a secret";
  }
}

TEST(Tokens, OfTheMetadata) {
  const auto expected = digest_of_bearer("Bearer x.y");
  ASSERT_TRUE(expected);
  for (const char* text : {"bearer x.y", "BEARER   x.y ", " Bearer\tx.y"})
    EXPECT_EQ(digest_of_bearer(text), expected) << text;
  for (const char* text : {"", "Bearer", "Bearer ", "x.y", "Basic x.y", "Bearerx.y", "Bearer x y"})
    EXPECT_EQ(digest_of_bearer(text), std::nullopt) << text;
}

TEST(Exposure, OfAddresses) {
  for (const char* here :
       {"127.0.0.1:1", "127.255.255.254:1", "[::1]:1", "[::ffff:127.0.0.1]:1", "unix:/x"})
    EXPECT_FALSE(is_exposed(here)) << here;
  for (const char* beyond : {"0.0.0.0:1", "[::]:1", "192.0.2.1:1", "10.0.0.1:1", "128.0.0.1:1",
                             "126.0.0.255:1", "[2001:db8::1]:1"})
    EXPECT_TRUE(is_exposed(beyond)) << beyond;
}

}  // namespace
}  // namespace stiefel::server
