#include "server/sessions/registry.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <latch>
#include <string>
#include <thread>

#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

using test::everybody;

class RegistryTest : public testing::Test {
 protected:
  auto create(const std::string& id, const Principal& principal = everybody) {
    return registry_.create(principal, id, test::scene(), "");
  }
  /// As a handle does that had the session.
  auto recreate(const std::string& id) {
    return registry_.create(everybody, id, test::scene(), "", {}, true);
  }
  static Scene other_scene() {
    auto other = test::description();
    other.step = std::nextafter(*other.step, 1);
    return Scene::resolve(other).value();
  }
  template <class Result>
  static Registry::Conflict conflict(const Result& result) {
    return std::get<Registry::Conflict>(result.error());
  }

  std::chrono::steady_clock::time_point now_{};
  Registry registry_{3, 1h, [this] { return now_; }};
};

TEST_F(RegistryTest, TheSameSceneIsTheSameSessionAndAnotherAConflict) {
  const auto first = create("a");
  const Scene resolved = Scene::resolve(first->session->scene().description()).value();
  const auto again = registry_.create(everybody, "a", resolved, "");
  ASSERT_TRUE(first && again);
  EXPECT_TRUE(first->created);
  EXPECT_FALSE(again->created);
  EXPECT_EQ(&*first->session, &*again->session);
  EXPECT_EQ(conflict(registry_.create(everybody, "a", other_scene(), "")),
            Registry::Conflict::other_scene);
}

TEST_F(RegistryTest, HoldsSoManyAndNoMore) {
  for (const char* id : {"a", "b", "c"}) EXPECT_TRUE(create(id));
  EXPECT_EQ(conflict(create("d")), Registry::Conflict::too_many);
  EXPECT_TRUE(create("b")) << "an old one is still found";
  registry_.erase(everybody, "a");
  EXPECT_TRUE(create("d"));
}

TEST_F(RegistryTest, PrincipalsDoNotMeet) {
  const Principal alice{"alice"}, bob{"bob"}, nearly{"alic"};
  const auto hers = create("a", alice);
  const auto his = registry_.create(bob, "a", other_scene(), "");
  ASSERT_TRUE(hers && his);
  EXPECT_TRUE(hers->created && his->created) << "another scene of the same id is no conflict";
  EXPECT_TRUE(create("b", alice));
  EXPECT_FALSE(registry_.find(bob, "b"));
  EXPECT_FALSE(registry_.find(nearly, "ea"));
  registry_.erase(bob, "b");
  EXPECT_TRUE(registry_.page(everybody, "", 9).empty());
  EXPECT_TRUE(registry_.page(nearly, "", 9).empty());
  EXPECT_EQ(registry_.page(alice, "", 9).size(), 2u);
  EXPECT_TRUE(registry_.page(bob, "a", 9).empty());
  registry_.erase(bob, "a");
  EXPECT_FALSE(registry_.find(bob, "a"));
  EXPECT_TRUE(registry_.find(alice, "a"));
}

TEST_F(RegistryTest, PagesInOrder) {
  for (const char* id : {"c", "a", "b"}) create(id);
  const auto first = registry_.page(everybody, "", 2);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0]->id(), "a");
  EXPECT_EQ(first[1]->id(), "b");
  EXPECT_EQ(registry_.page(everybody, "b", 2).at(0)->id(), "c");
  EXPECT_TRUE(registry_.page(everybody, "c", 2).empty());
}

TEST_F(RegistryTest, DropsWhatIsIdle) {
  for (const char* id : {"called", "listed"}) create(id);
  now_ += 59min;
  EXPECT_EQ(registry_.expire(), 0u);
  EXPECT_TRUE(registry_.find(everybody, "called"));
  EXPECT_EQ(registry_.page(everybody, "", 9).size(), 2u);
  now_ += 1min;
  EXPECT_EQ(registry_.expire(), 1u);
  EXPECT_FALSE(registry_.find(everybody, "listed"));
  EXPECT_TRUE(registry_.find(everybody, "called")) << "a call renews";
  EXPECT_TRUE(recreate("listed")->created) << "what expired is not deleted";
}

TEST_F(RegistryTest, DropsNothingInUse) {
  create("a");
  {
    const auto hold = registry_.find(everybody, "a");
    now_ += 5h;
    EXPECT_EQ(registry_.expire(), 0u);
  }
  EXPECT_EQ(registry_.expire(), 0u) << "the idle time starts when the call ends";
  now_ += 1h;
  EXPECT_EQ(registry_.expire(), 1u);
}

TEST_F(RegistryTest, CreatedByEightThreadsIsOneSession) {
  std::atomic<int> created = 0;
  std::latch start(8);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i)
      threads.emplace_back([&] {
        start.arrive_and_wait();
        created += create("a").value().created;
      });
  }
  EXPECT_EQ(created, 1);
  EXPECT_EQ(registry_.size(), 1u);
}

TEST_F(RegistryTest, RecordsEveryChangeInOrder) {
  std::vector<std::string> changes;
  registry_.record_with([&](const Registry::Change& change) {
    if (change.session)
      changes.push_back("+" + change.session->owner().name + "/" + change.session->id());
    else
      changes.push_back((change.until ? "-" : "expired ") + change.principal.name + "/" +
                        change.id);
    std::promise<std::optional<WriteFault>> done;
    done.set_value(std::nullopt);
    return PendingWrite(done.get_future());
  });
  const Principal alice{"alice"};
  EXPECT_TRUE(create("a", alice)->pending_write.valid());
  EXPECT_TRUE(create("a", alice)->pending_write.valid()) << "that of the first call";
  create("a");
  registry_.erase(everybody, "a");
  registry_.erase(everybody, "never there");
  now_ += 1h;
  EXPECT_EQ(registry_.expire(), 1u);
  EXPECT_EQ(changes, (std::vector<std::string>{"+alice/a", "+/a", "-/a", "-/never there",
                                               "expired alice/a"}));
}

TEST_F(RegistryTest, NewStatesAreTakenOnce) {
  const auto made = create("a");
  EXPECT_TRUE(registry_.with_new_states().empty());
  auto simulation = made->session->acquire(0);
  const std::int64_t step = made->session->next_checkpoint(0);
  simulation->advance(step);
  made->session->put_checkpoint(*simulation);
  ASSERT_EQ(registry_.with_new_states().size(), 1u);
  EXPECT_EQ(made->session->take_new_state()->step, step);
  EXPECT_FALSE(made->session->take_new_state());
  EXPECT_TRUE(registry_.with_new_states().empty());
}

TEST_F(RegistryTest, ACheckpointReachesASessionThatIsThere) {
  Registry other(1, 1h, {});
  const auto ahead = other.create(everybody, "a", test::scene(), "");
  auto simulation = ahead->session->acquire(0);
  simulation->advance(5000);
  const std::string checkpoint = encode_checkpoint(*ahead->session, *simulation);
  create("a");
  const auto again = registry_.create(everybody, "a", test::scene(), checkpoint, {}, true);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->created);
  EXPECT_EQ(again->session->acquire(5001)->step(), 5000);
}

TEST_F(RegistryTest, ADeletedSessionDoesNotComeBackWithinTheTimeout) {
  create("a");
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  registry_.erase(everybody, "a");
  registry_.erase(everybody, "before it came");  // it may be on its way here
  for (const char* id : {"a", "before it came"}) {
    EXPECT_TRUE(registry_.deleted(everybody, id));
    EXPECT_EQ(conflict(recreate(id)), Registry::Conflict::deleted);
  }
  now_ += 1h;
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  EXPECT_TRUE(recreate("a"));
}

TEST_F(RegistryTest, ANewCreationMayUseTheNameOfADeletedSession) {
  registry_.erase(everybody, "a");
  auto made = create("a");
  EXPECT_TRUE(made->created);
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  EXPECT_FALSE(recreate("a")->created) << "which is then there for every handle";
  registry_.drop(*made->session);
  EXPECT_TRUE(registry_.deleted(everybody, "a")) << "it could not be written";
  EXPECT_FALSE(recreate("a"));
  now_ += 1h;
  EXPECT_TRUE(recreate("a"));
}

TEST_F(RegistryTest, StoredDeletionsLastForWhatIsLeft) {
  const auto now = std::chrono::system_clock::now();
  registry_.restore_deletion(everybody, "over", now - 1s);
  registry_.restore_deletion(everybody, "a", now + 30min);
  registry_.restore_deletion(everybody, "long", now + 5h);
  EXPECT_FALSE(registry_.deleted(everybody, "over"));
  EXPECT_TRUE(registry_.deleted(everybody, "a"));
  now_ += 29min;
  EXPECT_FALSE(recreate("a"));
  now_ += 2min;
  registry_.expire();
  EXPECT_TRUE(recreate("a"));
  EXPECT_TRUE(registry_.deleted(everybody, "long"));
  now_ += 29min;
  EXPECT_FALSE(registry_.deleted(everybody, "long")) << "the idle timeout has become shorter";
}

TEST_F(RegistryTest, ManyDeletionsPushOutTheOldestOfTheirPrincipalAlone) {
  const Principal bob{"bob"};
  registry_.erase(everybody, "a");
  for (std::size_t i = 0; i < Tombstones::max_count + 5; ++i)
    registry_.erase(bob, std::to_string(i));
  EXPECT_FALSE(registry_.deleted(bob, "4"));
  EXPECT_TRUE(registry_.deleted(bob, "5"));
  EXPECT_TRUE(registry_.deleted(everybody, "a"));
}

TEST(RegistryMemory, TombstonesCountAndGiveUpCaches) {
  MemoryBudget memory(std::uint64_t{1} << 20);
  Registry registry(3, 1h, {}, memory);
  registry.create(everybody, "cached", test::scene(), "");
  const MemoryLease others(memory, memory.limit() - memory.used());
  for (int i = 0; i < 10; ++i) registry.erase(everybody, std::to_string(i));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(registry.deleted(everybody, std::to_string(i))) << i;
  const std::uint64_t of_ten = memory.used() - others.bytes();
  EXPECT_LE(memory.used(), memory.limit());
  const MemoryLease rest(memory, memory.limit() - memory.used());
  registry.erase(everybody, "new");
  EXPECT_TRUE(registry.deleted(everybody, "new")) << "the newest stays";
  EXPECT_FALSE(registry.deleted(everybody, "0")) << "the oldest made room";
  EXPECT_GT(of_ten, 10u * 100);
}

}  // namespace
}  // namespace stiefel::server
