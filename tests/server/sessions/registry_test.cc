#include "server/sessions/registry.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <thread>

#include "server/scheduling/process.h"
#include "server/sessions/checkpoints/secrets.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

using test::everybody;

class RegistryTest : public testing::Test {
 protected:
  std::chrono::steady_clock::time_point now_{};
  Registry registry_{3, 1h, [this] { return now_; }};
};

TEST_F(RegistryTest, TheSameSceneIsTheSameSession) {
  const auto first = registry_.create(everybody, "a", test::scene(), "");
  const auto again = registry_.create(everybody, "a", test::scene(), "");
  ASSERT_TRUE(first && again);
  EXPECT_TRUE(first->created);
  EXPECT_FALSE(again->created);
  EXPECT_EQ(&*first->session, &*again->session);
}

TEST_F(RegistryTest, TheResolvedSceneIsTheSameSession) {
  const Scene scene = test::scene();
  registry_.create(everybody, "a", scene, "");
  const auto again =
      registry_.create(everybody, "a", Scene::resolve(scene.description()).value(), "");
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->created);
}

TEST_F(RegistryTest, AnotherSceneIsAConflict) {
  registry_.create(everybody, "a", test::scene(), "");
  auto other = test::description();
  other.step = std::nextafter(*other.step, 1);
  const auto result = registry_.create(everybody, "a", Scene::resolve(other).value(), "");
  ASSERT_FALSE(result);
  EXPECT_EQ(std::get<Registry::Conflict>(result.error()), Registry::Conflict::other_scene);
}

TEST_F(RegistryTest, HoldsSoManyAndNoMore) {
  for (const char* id : {"a", "b", "c"})
    EXPECT_TRUE(registry_.create(everybody, id, test::scene(), ""));
  const auto result = registry_.create(everybody, "d", test::scene(), "");
  ASSERT_FALSE(result);
  EXPECT_EQ(std::get<Registry::Conflict>(result.error()), Registry::Conflict::too_many);
  EXPECT_TRUE(registry_.create(everybody, "b", test::scene(), "")) << "an old one is still found";
  EXPECT_TRUE(registry_.erase(everybody, "a"));
  EXPECT_FALSE(registry_.erase(everybody, "a"));
  EXPECT_TRUE(registry_.create(everybody, "d", test::scene(), ""));
}

TEST_F(RegistryTest, PrincipalsDoNotMeet) {
  const Principal alice{"alice"}, bob{"bob"}, nearly{"alic"};
  auto other = test::description();
  other.step = std::nextafter(*other.step, 1);
  const auto hers = registry_.create(alice, "a", test::scene(), "");
  const auto his = registry_.create(bob, "a", Scene::resolve(other).value(), "");
  ASSERT_TRUE(hers && his);
  EXPECT_TRUE(hers->created && his->created) << "another scene of the same id is no conflict";
  EXPECT_NE(&*hers->session, &*his->session);
  EXPECT_TRUE(registry_.create(alice, "b", test::scene(), ""));
  EXPECT_FALSE(registry_.find(bob, "b"));
  EXPECT_FALSE(registry_.find(nearly, "ea"));
  EXPECT_FALSE(registry_.erase(bob, "b"));
  EXPECT_TRUE(registry_.page(everybody, "", 9).empty());
  EXPECT_TRUE(registry_.page(nearly, "", 9).empty());
  EXPECT_EQ(registry_.page(alice, "", 9).size(), 2u);
  EXPECT_EQ(registry_.page(bob, "", 9).size(), 1u);
  EXPECT_TRUE(registry_.page(bob, "a", 9).empty());
  EXPECT_TRUE(registry_.erase(bob, "a"));
  EXPECT_TRUE(registry_.find(alice, "a"));
}

TEST_F(RegistryTest, WhatOneDeletesDoesNotBringAnothersBack) {
  const Principal alice{"alice"}, bob{"bob"};
  registry_.create(alice, "a", test::scene(), "");
  registry_.erase(alice, "a");
  for (std::size_t i = 0; i < 2 * DeletedNames::max_count; ++i)
    registry_.erase(bob, std::to_string(i));
  EXPECT_TRUE(registry_.deleted(alice, "a"));
  EXPECT_FALSE(registry_.deleted(bob, "a"));
  EXPECT_FALSE(registry_.create(alice, "a", test::scene(), "", {}, true));
  now_ += 1h;
  registry_.expire();
  EXPECT_FALSE(registry_.deleted(alice, "a"));
}

/// Notes who owned what is erased; a session that is deleted is another matter.
struct Erasures final : WriteAheadLog {
  std::shared_ptr<PendingWrite> put(std::shared_ptr<Session>) override { return nullptr; }
  std::shared_ptr<PendingWrite> erase(const Principal& principal, std::string id) override {
    erased.push_back(principal.name + '/' + id);
    return nullptr;
  }
  std::shared_ptr<PendingWrite> mark_deleted(const Principal&, std::string, Time) override {
    return nullptr;
  }
  void cached(std::weak_ptr<Session>) noexcept override {}

  std::vector<std::string> erased;
};

TEST_F(RegistryTest, WhatExpiresIsErasedAsItsOwners) {
  Erasures log;
  Registry registry(3, 1h, [this] { return now_; });
  registry.write_to(log);
  registry.create(Principal{"alice"}, "a", test::scene(), "");
  registry.create(everybody, "a", test::scene(), "");
  now_ += 1h;
  EXPECT_EQ(registry.expire(), 2u);
  EXPECT_EQ(log.erased, (std::vector<std::string>{"/a", "alice/a"}));
}

TEST_F(RegistryTest, PagesInOrder) {
  for (const char* id : {"c", "a", "b"}) registry_.create(everybody, id, test::scene(), "");
  const auto first = registry_.page(everybody, "", 2);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0]->id(), "a");
  EXPECT_EQ(first[1]->id(), "b");
  EXPECT_EQ(registry_.page(everybody, "b", 2).at(0)->id(), "c");
  EXPECT_TRUE(registry_.page(everybody, "c", 2).empty());
}

TEST_F(RegistryTest, DropsWhatIsIdle) {
  registry_.create(everybody, "a", test::scene(), "");
  registry_.create(everybody, "b", test::scene(), "");
  now_ += 59min;
  EXPECT_EQ(registry_.expire(), 0u);
  EXPECT_TRUE(registry_.find(everybody, "b"));
  now_ += 1min;
  EXPECT_EQ(registry_.expire(), 1u);
  EXPECT_FALSE(registry_.find(everybody, "a"));
  EXPECT_TRUE(registry_.find(everybody, "b")) << "a call renews";
}

TEST_F(RegistryTest, DropsNothingInUse) {
  registry_.create(everybody, "a", test::scene(), "");
  {
    const auto hold = registry_.find(everybody, "a");
    now_ += 5h;
    EXPECT_EQ(registry_.expire(), 0u);
  }
  EXPECT_EQ(registry_.expire(), 0u) << "the idle time starts when the call ends";
  now_ += 1h;
  EXPECT_EQ(registry_.expire(), 1u);
}

TEST_F(RegistryTest, LookingAtThePageRenewsNothing) {
  registry_.create(everybody, "a", test::scene(), "");
  now_ += 59min;
  EXPECT_EQ(registry_.page(everybody, "", 9).size(), 1u);
  now_ += 1min;
  EXPECT_EQ(registry_.expire(), 1u);
}

TEST_F(RegistryTest, CreatedByEightThreadsIsOneSession) {
  std::atomic<int> created = 0;
  std::latch start(8);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] {
        start.arrive_and_wait();
        created += registry_.create(everybody, "a", test::scene(), "").value().created;
      });
    }
  }
  EXPECT_EQ(created, 1);
  EXPECT_EQ(registry_.size(), 1u);
}

TEST(Registry, ExpiresAtItsInterval) {
  Registry registry(3, 1ms, {});
  registry.create(everybody, "a", test::scene(), "");
  std::latch expired(1);
  const Periodic sweeper("sweep", registry.sweep_interval(), [&](const auto&) {
    if (registry.expire() > 0) expired.count_down();
  });
  expired.wait();
  EXPECT_EQ(registry.size(), 0u);
}

}  // namespace
}  // namespace stiefel::server
