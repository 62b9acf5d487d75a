// What a server with a store acknowledges is on the disk; what cannot be is
// refused.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <thread>
#include <vector>

#include "tests/server/store/durable.h"
#include "tests/server/store/forgetful_vfs.h"
#include "tests/server/store/stores.h"

namespace stiefel::test {
namespace {

TEST_F(DurabilityTest, DescribeSaysWhetherSessionsLast) {
  for (const std::string& file : {std::string(), file_}) {
    grpc::ClientContext context;
    v1::DescribeResponse response;
    ASSERT_TRUE(Harness(with_store(file)).stub->Describe(&context, {}, &response).ok());
    EXPECT_EQ(response.durable(), !file.empty());
  }
}

TEST_F(DurabilityTest, OnAFullDiskItRefusesNewSessionsAndServesTheOld) {
  Harness harness(with_store(file_));
  int made = 0;
  {
    const FullDisk disk(150'000);
    std::string refusal;
    for (; made < 1000 && refusal.empty(); ++made)
      refusal = create(*harness.stub, std::to_string(made), numbered(made));
    EXPECT_EQ(refusal, "STORE_FULL");
    EXPECT_GT(made, 10);
    EXPECT_FALSE(get(*harness.stub, std::to_string(made - 1)));
    harness.step("0", 100);
  }
  EXPECT_EQ(create(*harness.stub, "new", numbered(5000)), "");
}

TEST_F(DurabilityTest, AChangeIsAnsweredWhenItIsOnDisk) {
  // No writes reach the disk: nothing is acknowledged, and a deletion that
  // failed does not become one that was acknowledged by being asked for again.
  { Harness(with_store(file_)).create("a", numbered(0)); }
  ForgetfulVfs vfs;
  std::mt19937_64 random(1);
  {
    Harness harness(with_store(file_));
    vfs.crash_at(0);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(erase(*harness.stub, "a"), "STORE_UNAVAILABLE");
    EXPECT_EQ(create(*harness.stub, "b", numbered(1)), "STORE_UNAVAILABLE");
    EXPECT_FALSE(get(*harness.stub, "b"));
  }
  vfs.restart(0, random);
  EXPECT_TRUE(get(*Harness(with_store(file_)).stub, "a"));
}

TEST_F(DurabilityTest, NamesOfManyThreadsEndAsTheServerHadThem) {
  const auto sessions = [](Stub& stub) {
    std::map<std::string, std::string> all;
    for (int id = 0; id < 5; ++id)
      if (const auto session = get(stub, std::to_string(id), true))
        all[session->session_id()] = session->DebugString();
    return all;
  };
  std::map<std::string, std::string> expected;
  {
    Harness harness(with_store(file_));
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (int i = 0; i < 100; ++i) {
          const std::string id = std::to_string(i % 5);
          if ((i + t) % 3 == 0)
            erase(*harness.stub, id);
          else
            create(*harness.stub, id, numbered(i + t));
        }
      });
    threads.clear();
    expected = sessions(*harness.stub);
  }
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(sessions(*Harness(with_store(file_)).stub), expected);
}

}  // namespace
}  // namespace stiefel::test
