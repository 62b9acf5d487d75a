// Addresses: what is none is refused before anything listens on a port near it.
#include "server/connections/listener.h"

#include <gtest/gtest.h>

namespace stiefel::server {
namespace {

TEST(Address, TakesHostsPortsAndPaths) {
  for (const std::string address :
       {"127.0.0.1:0", "127.0.0.1:65535", "0.0.0.0:50551", "localhost:1", "[::1]:0", "[::]:50551",
        "[fe80::1%eth0]:5", "unix:/run/s.sock", "unix:s", "unix:///run/s"})
    EXPECT_EQ(address_fault(address), std::nullopt) << address;
  EXPECT_EQ(address_fault("unix:" + std::string(107, 'x')), std::nullopt);
  EXPECT_EQ(address_fault("unix://" + std::string(107, '/')), std::nullopt)
      << "two are the scheme's";
}

TEST(Address, RefusesWhatIsNoPort) {
  for (const std::string port : {"65536", "99999", "-1", "-0", "+1", "", " 80", "80 ", "0x50",
                                 "1e3", "http", "99999999999999999999", "1.5"}) {
    const auto fault = address_fault("127.0.0.1:" + port);
    ASSERT_TRUE(fault) << port;
    EXPECT_NE(fault->find("'" + port + "'"), std::string::npos) << *fault;
    EXPECT_NE(fault->find("0 to 65535"), std::string::npos) << *fault;
  }
}

TEST(Address, RefusesWhatIsNoAddress) {
  for (const std::string address : {"", ":", "127.0.0.1", "localhost", "[::1]", ":80", "::1:80",
                                    "[::1:80", "http://x:80", "unix:"})
    EXPECT_TRUE(address_fault(address)) << address;
}

TEST(Address, RefusesPathsThatNoSocketHolds) {
  const auto fault = address_fault(std::string("unix:/").append(107, 'x'));
  ASSERT_TRUE(fault);
  EXPECT_EQ(*fault, "the path of 108 bytes must have at most 107");
}

}  // namespace
}  // namespace stiefel::server
