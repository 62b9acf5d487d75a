// What a server answers of the sessions of the one before it.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "tests/server/store/durable.h"

namespace stiefel::test {
namespace {

using RestartTest = DurabilityTest;

TEST_F(RestartTest, ANewServerAnswersAsTheOldOne) {
  std::map<std::string, std::string> before;
  const auto answers = [](Stub& stub) {
    std::map<std::string, std::string> all;
    for (const char* id : {"chosen", "plain", "forked"})
      if (const auto session = get(stub, id, true)) all[id] = session->DebugString();
    return all;
  };
  std::string bits;
  {
    Harness harness(with_store(file_));
    Stub& stub = *harness.stub;
    v1::Scene tolerant = wire_scene();
    tolerant.clear_method();
    tolerant.set_tolerance(1e-6);
    tolerant.set_horizon(0.1);
    EXPECT_EQ(create(stub, "chosen", tolerant), "");
    EXPECT_EQ(create(stub, "plain", numbered(1)), "");
    EXPECT_EQ(create(stub, "deleted", numbered(2)), "");
    EXPECT_EQ(fork(stub, "forked", "plain", 77), "");
    EXPECT_EQ(erase(stub, "deleted"), "");
    EXPECT_TRUE(get(stub, "chosen")->has_choice());
    before = answers(stub);
    EXPECT_EQ(before.size(), 3u);
    bits = bytes_of(harness.step("forked", 1000).sample());
  }
  Harness harness(with_store(file_));
  EXPECT_EQ(answers(*harness.stub), before);
  EXPECT_FALSE(get(*harness.stub, "deleted"));
  EXPECT_EQ(bytes_of(harness.step("forked", 1000).sample()), bits);
  EXPECT_FALSE(harness.create("plain", numbered(1)).created());
  EXPECT_EQ(create(*harness.stub, "plain", numbered(3)), "SESSION_HAS_OTHER_SCENE");
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
  for (int i = 0; i < sessions; ++i) EXPECT_TRUE(get(*harness.stub, std::to_string(i))) << i;
  EXPECT_EQ(create(*harness.stub, "more", large), "MEMORY_LIMIT");
  for (int i = 0; i < sessions - 5; ++i) EXPECT_EQ(erase(*harness.stub, std::to_string(i)), "");
  EXPECT_EQ(harness.step(std::to_string(sessions - 1), 3).sample().step(), 3);
}

TEST_F(RestartTest, RestoredSessionsCountInTheirPrincipalsQuota) {
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
  Stub& stub = *harness.stub;
  EXPECT_TRUE(get(stub, "c")) << "beyond the quota";
  EXPECT_EQ(create(stub, "a", numbered(0)), "") << "it is there";
  EXPECT_EQ(erase(stub, "a"), "");
  EXPECT_EQ(create(stub, "d", numbered(0)), "OVER_QUOTA") << "two are there";
  EXPECT_EQ(erase(stub, "b"), "");
  EXPECT_EQ(create(stub, "d", numbered(0)), "");
  EXPECT_EQ(create(stub, "e", numbered(0)), "OVER_QUOTA");
  ++minutes;  // "c" and "d" expire
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  std::string refusal = "OVER_QUOTA";
  while (!refusal.empty() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    refusal = create(stub, "e", numbered(0));
  }
  EXPECT_EQ(refusal, "");
}

TEST_F(RestartTest, RestoredSessionsCountInTheirPrincipalsMemory) {
  auto options = with_store(file_);
  {
    Harness harness(options);
    for (int i = 0; i < 40; ++i) harness.create(std::to_string(i), numbered(i));
  }
  options.quota.memory = 40 * 10'000;  // the sessions without their simulations, and little more
  // A call that has just ended may still hold its memory, so the quota is full
  // at the 20th refusal.
  const auto count = [](Stub& stub) {
    int more = 0;
    for (int refused = 0; more < 1000 && refused < 20;) {
      const bool made = create(stub, std::to_string(1000 + more), numbered(more)).empty();
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
