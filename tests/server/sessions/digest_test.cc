// SHA-256 and HMAC-SHA256 against the published vectors.
#include "server/sessions/checkpoints/secrets.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace stiefel::server {
namespace {

TEST(Digest, OfFips180) {
  EXPECT_EQ(to_hexadecimal(sha256("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(to_hexadecimal(sha256("")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Digest, InHexadecimal) {
  const Bytes32 secret = random_secret();
  EXPECT_EQ(from_hexadecimal(to_hexadecimal(secret)), secret);
  Bytes32 all;
  all.fill(0xff);
  EXPECT_EQ(from_hexadecimal(std::string(64, 'F')), all);
  for (const std::string& none :
       {std::string(), std::string(63, '0'), std::string(65, '0'), std::string(64, 'g')})
    EXPECT_EQ(from_hexadecimal(none), std::nullopt) << none;
  EXPECT_NE(random_secret(), secret);
  EXPECT_TRUE(equal_secrets(secret, secret));
  Bytes32 other = secret;
  other.back() ^= 1;
  EXPECT_FALSE(equal_secrets(secret, other));
}

}  // namespace
}  // namespace stiefel::server
