// What a server answers of the sessions of the one before it.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "server/sessions/store/store.h"
#include "tests/server/store/durable.h"

namespace stiefel::test {
namespace {

using google::protobuf::util::MessageDifferencer;
using RestartTest = DurabilityTest;

TEST_F(RestartTest, ANewServerAnswersAsTheOldOne) {
  std::map<std::string, v1::Session> full, filled;
  std::string bits;
  {
    Harness harness(with_store(file_));
    v1::Scene tolerant = wire_scene();
    tolerant.clear_method();
    tolerant.set_tolerance(1e-6);
    tolerant.set_horizon(0.1);
    ASSERT_TRUE(create(*harness.stub, "chosen", tolerant).ok());
    ASSERT_TRUE(create(*harness.stub, "plain", numbered(1)).ok());
    ASSERT_TRUE(create(*harness.stub, "deleted", numbered(2)).ok());
    ASSERT_TRUE(fork(*harness.stub, "forked", "plain", 77).ok());
    ASSERT_TRUE(erase(*harness.stub, "deleted").ok());
    for (const char* id : {"chosen", "plain", "forked"}) {
      full[id] = get(*harness.stub, id, v1::SCENE_VIEW_FULL).value();
      filled[id] = get(*harness.stub, id, v1::SCENE_VIEW_FILLED_IN).value();
    }
    EXPECT_TRUE(full["chosen"].has_choice());
    bits = bytes_of(harness.step("forked", 1000).sample());
  }
  Harness harness(with_store(file_));
  for (const auto& [id, session] : full) {
    const auto now = get(*harness.stub, id, v1::SCENE_VIEW_FULL);
    ASSERT_TRUE(now) << id;
    EXPECT_TRUE(MessageDifferencer::Equals(*now, session))
        << now->DebugString() << session.DebugString();
    EXPECT_TRUE(
        MessageDifferencer::Equals(*get(*harness.stub, id, v1::SCENE_VIEW_FILLED_IN), filled[id]));
  }
  EXPECT_FALSE(get(*harness.stub, "deleted", v1::SCENE_VIEW_NONE));
  EXPECT_EQ(bytes_of(harness.step("forked", 1000).sample()), bits);
  EXPECT_FALSE(harness.create("plain", numbered(1)).created());
  EXPECT_EQ(create(*harness.stub, "plain", numbered(3)).status.error_code(), grpc::ALREADY_EXISTS);
}

TEST_F(RestartTest, ALongRunGoesOnFromItsCheckpoint) {
  constexpr std::int64_t far = 200'000;
  std::string bits;
  {
    Harness harness(with_store(file_));
    harness.create("a", numbered(0));
    bits = bytes_of(harness.step("a", far).sample());
  }
  Harness harness(with_store(file_));
  const auto reply = harness.step("a", far);
  EXPECT_EQ(bytes_of(reply.sample()), bits);
  EXPECT_LT(reply.computed_steps(), far / 2);
}

TEST_F(RestartTest, AServerStartsWithLessMemoryThanItsSessionsTake) {
  auto options = with_store(file_);
  constexpr int sessions = 60;
  v1::Scene large = wire_scene({.method = "rk4", .dimension = 96});
  large.set_step(1e-5);  // rk4 leaves the numbers at 0.01
  {
    Harness harness(options);
    for (int i = 0; i < sessions; ++i) harness.create(std::to_string(i), large);
  }
  options.memory = std::uint64_t{64} << 20;
  Harness harness(options);
  for (int i = 0; i < sessions; ++i)
    EXPECT_TRUE(get(*harness.stub, std::to_string(i), v1::SCENE_VIEW_NONE)) << i;
  EXPECT_EQ(create(*harness.stub, "more", large).reason(), "MEMORY_LIMIT");
  for (int i = 0; i < sessions - 5; ++i) EXPECT_TRUE(erase(*harness.stub, std::to_string(i)).ok());
  EXPECT_EQ(harness.step(std::to_string(sessions - 1), 3).sample().step(), 3);
}

TEST_F(RestartTest, ADeletedSessionStaysDeletedAfterARestart) {
  for (int restart = 0; restart < 3; ++restart) {
    Harness harness(with_store(file_));
    if (restart == 0) {
      for (const char* id : {"a", "b"}) harness.create(id, numbered(0));
      for (const char* id : {"a", "b", "never-there"}) EXPECT_TRUE(erase(*harness.stub, id).ok());
      harness.create("b", numbered(0));
    }
    for (const char* id : {"a", "never-there"})
      EXPECT_EQ(recreate(*harness.stub, id, numbered(0)), "SESSION_DELETED") << restart;
    EXPECT_EQ(recreate(*harness.stub, "b", numbered(0)), "OK") << "it was created anew";
  }
  Harness harness(with_store(file_));
  EXPECT_FALSE(get(*harness.stub, "a", v1::SCENE_VIEW_NONE));
  EXPECT_TRUE(create(*harness.stub, "a", numbered(1)).ok()) << "a new creation may use the name";
}

TEST_F(RestartTest, ADeletedNameEndsWithTheIdleTimeout) {
  auto options = with_store(file_);
  options.idle_timeout = std::chrono::milliseconds(1500);
  const auto start = std::chrono::steady_clock::now();
  {
    Harness harness(options);
    EXPECT_TRUE(erase(*harness.stub, "a").ok());
  }
  {
    Harness harness(options);
    const std::string told = recreate(*harness.stub, "a", numbered(0));
    const bool over = std::chrono::steady_clock::now() - start >= options.idle_timeout;
    EXPECT_TRUE(over || told == "SESSION_DELETED") << told;
    EXPECT_TRUE(erase(*harness.stub, "b").ok());
  }
  std::this_thread::sleep_for(options.idle_timeout);
  { EXPECT_EQ(recreate(*Harness(options).stub, "b", numbered(0)), "OK"); }
  server::Store store({file_});
  EXPECT_TRUE(store.deleted_names(0).empty()) << "a server that starts removes what is over";
}

TEST_F(RestartTest, RestoredSessionsTakeTheirPermits) {
  auto options = with_store(file_);
  {
    Harness harness(options);
    for (const char* id : {"a", "b", "c"}) harness.create(id, numbered(0));
  }
  std::atomic<int> minutes = 0;
  options.quota.sessions = 2;
  options.idle_timeout = std::chrono::seconds(2);
  options.clock = [&] {
    return std::chrono::steady_clock::time_point(std::chrono::minutes(minutes));
  };
  Harness harness(options);
  EXPECT_TRUE(get(*harness.stub, "c", v1::SCENE_VIEW_NONE)) << "beyond the quota";
  EXPECT_EQ(create(*harness.stub, "d", numbered(0)).reason(), "OVER_QUOTA");
  EXPECT_TRUE(create(*harness.stub, "a", numbered(0)).ok()) << "it is there";
  EXPECT_TRUE(erase(*harness.stub, "a").ok());
  EXPECT_EQ(create(*harness.stub, "d", numbered(0)).reason(), "OVER_QUOTA") << "two are there";
  EXPECT_TRUE(erase(*harness.stub, "b").ok());
  EXPECT_TRUE(create(*harness.stub, "d", numbered(0)).ok());
  EXPECT_EQ(create(*harness.stub, "e", numbered(0)).reason(), "OVER_QUOTA");
  ++minutes;  // "c" and "d" expire
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  bool expired = false;
  while (!expired && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    expired = create(*harness.stub, "e", numbered(0)).ok();
  }
  EXPECT_TRUE(expired);
}

TEST_F(RestartTest, RestoredSessionsCountInTheirPrincipalsMemory) {
  auto options = with_store(file_);
  {
    Harness harness(options);
    for (int i = 0; i < 40; ++i) harness.create(std::to_string(i), numbered(i));
  }
  options.quota.memory = 40 * 10'000;  // the sessions without their simulations, and little more
  // A call that has just ended may still hold its memory, so the quota is full at the 20th refusal.
  const auto count = [](Stub& stub) {
    int more = 0;
    for (int refused = 0; more < 1000 && refused < 20;) {
      const bool made = create(stub, std::to_string(1000 + more), numbered(more)).ok();
      if (made) ++more;
      refused = made ? 0 : refused + 1;
    }
    return more;
  };
  int with = 0, without = 0;
  with = count(*Harness(options).stub);
  std::filesystem::remove(file_);
  without = count(*Harness(options).stub);
  EXPECT_GT(without, 20);
  EXPECT_LE(with, without - 20);
}

}  // namespace
}  // namespace stiefel::test
