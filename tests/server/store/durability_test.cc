// What a server with a store acknowledges is on the disk; what cannot be is refused.
#include <gmock/gmock.h>

#include <map>
#include <random>
#include <thread>
#include <vector>

#include "tests/server/store/durable.h"
#include "tests/server/store/forgetful_vfs.h"

namespace stiefel::test {
namespace {

v1::DescribeResponse describe(Stub& stub) {
  grpc::ClientContext context;
  v1::DescribeResponse response;
  EXPECT_TRUE(stub.Describe(&context, {}, &response).ok());
  return response;
}

TEST_F(DurabilityTest, DescribeSaysWhetherSessionsLast) {
  EXPECT_FALSE(describe(*Harness().stub).durable());
  EXPECT_TRUE(describe(*Harness(with_store(file_)).stub).durable());
}

TEST_F(DurabilityTest, AFullStoreRefusesNewSessionsAndServesTheOld) {
  Harness harness(with_store(file_, 150'000));
  std::vector<std::string> made;
  End end{grpc::Status::OK};
  for (int i = 0; i < 1000 && end.ok(); ++i) {
    end = create(*harness.stub, std::to_string(i), numbered(i));
    if (end.ok()) made.push_back(std::to_string(i));
  }
  EXPECT_EQ(end.status.error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(end.reason(), "STORE_FULL");
  ASSERT_GT(made.size(), 20u);
  EXPECT_FALSE(get(*harness.stub, std::to_string(made.size()), v1::SCENE_VIEW_NONE));
  harness.step("0", 100);
  for (int i = 1; i < 20; ++i) EXPECT_TRUE(erase(*harness.stub, std::to_string(i)).ok());
  EXPECT_TRUE(create(*harness.stub, "new", numbered(5000)).ok());
}

TEST_F(DurabilityTest, ADeletionIsAnsweredWhenItIsOnDisk) {
  // No writes reach the disk: nothing is acknowledged, and a deletion that failed does not become
  // one that was acknowledged by being asked for again.
  { Harness(with_store(file_)).create("a", numbered(0)); }
  ForgetfulVfs vfs;
  std::mt19937_64 random(1);
  {
    Harness harness(with_store(file_, 0, ForgetfulVfs::name));
    vfs.crash_at(0);
    for (int i = 0; i < 2; ++i) {
      const End end = erase(*harness.stub, "a");
      EXPECT_EQ(end.status.error_code(), grpc::UNAVAILABLE) << end.status.error_message();
      EXPECT_EQ(end.reason(), "STORE_UNAVAILABLE");
    }
    EXPECT_EQ(create(*harness.stub, "b", numbered(1)).reason(), "STORE_UNAVAILABLE");
    EXPECT_FALSE(get(*harness.stub, "b", v1::SCENE_VIEW_NONE));
  }
  vfs.restart(0, random);
  EXPECT_TRUE(get(*Harness(with_store(file_)).stub, "a", v1::SCENE_VIEW_NONE));
}

/// Each thread creates, forks and deletes sessions of its own until the machine stops, and notes
/// what it was told.
struct Caller {
  std::map<std::string, int> there;                  // the scene's number
  std::map<std::string, std::string> forked;         // where a fork came from
  std::map<std::string, bool> deleted, in_question;  // in_question: asked for, not answered

  void run(Stub& stub, int self, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    for (int i = 0; i < 400; ++i) {
      const std::string id = std::to_string(self) + "-" + std::to_string(i);
      const auto pick = there.begin() == there.end() ? std::string() : there.begin()->first;
      const auto which = random() % 4;
      if (which == 0 && !pick.empty()) {
        in_question[pick] = true;
        there.erase(pick);
        if (!erase(stub, pick).ok()) return;
        in_question.erase(pick);
        deleted[pick] = true;
      } else if (which == 1 && !pick.empty()) {
        in_question[id] = true;
        if (!fork(stub, id, pick, 10).ok()) return;
        in_question.erase(id);
        forked[id] = pick;
      } else {
        in_question[id] = true;
        if (!create(stub, id, numbered(1000 * self + i)).ok()) return;
        in_question.erase(id);
        there[id] = 1000 * self + i;
      }
    }
  }
};

TEST_F(DurabilityTest, NothingAcknowledgedIsLostWhenTheMachineStops) {
  std::mt19937_64 random(3);
  std::size_t verified = 0;
  for (int cycle = 0; cycle < 12; ++cycle) {
    const Folder folder;
    { const server::Server made(with_store(folder.file())); }
    ForgetfulVfs vfs;
    std::vector<Caller> callers(4);
    {
      Harness harness(with_store(folder.file(), 0, ForgetfulVfs::name));
      vfs.crash_at(static_cast<std::int64_t>(random() % 400));
      std::vector<std::jthread> threads;
      for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t, seed = random()] {
          callers[static_cast<std::size_t>(t)].run(*harness.stub, t, seed);
        });
      threads.clear();
    }
    vfs.restart(cycle % 2 ? 0.5 : 0.0, random);
    Harness harness(with_store(folder.file()));
    for (const Caller& caller : callers) {
      for (const auto& [id, number] : caller.there) {
        ASSERT_TRUE(get(*harness.stub, id, v1::SCENE_VIEW_NONE)) << id;
        EXPECT_FALSE(harness.create(id, numbered(number)).created()) << id << " has other bits";
      }
      for (const auto& [id, from] : caller.forked)
        EXPECT_TRUE(get(*harness.stub, id, v1::SCENE_VIEW_NONE)) << id;
      for (const auto& [id, gone] : caller.deleted) {
        EXPECT_FALSE(get(*harness.stub, id, v1::SCENE_VIEW_NONE)) << id;
        EXPECT_EQ(recreate(*harness.stub, id, numbered(0)), "SESSION_DELETED") << id;
      }
      verified += caller.there.size() + caller.forked.size() + caller.deleted.size();
    }
  }
  EXPECT_GT(verified, 100u);
}

}  // namespace
}  // namespace stiefel::test
