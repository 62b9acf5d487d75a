#include "server/sessions/registry.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

using test::everybody;

using namespace std::chrono_literals;

constexpr DeletedNames::Time start{};

TEST(DeletedNames, LastForTheirLifetime) {
  DeletedNames deleted_names(1h);
  deleted_names.put("a", start);
  deleted_names.put("b", start + 30min);
  EXPECT_TRUE(deleted_names.contains("a", start + 59min));
  EXPECT_FALSE(deleted_names.contains("a", start + 1h)) << "though nothing dropped it yet";
  EXPECT_TRUE(deleted_names.contains("b", start + 1h));
  EXPECT_FALSE(deleted_names.contains("c", start));
  deleted_names.expire(start + 1h);
  EXPECT_EQ(deleted_names.size(), 1u);
}

TEST(DeletedNames, ADeletionAgainStartsAnew) {
  DeletedNames deleted_names(1h);
  deleted_names.put("a", start);
  deleted_names.put("b", start + 1min);
  deleted_names.put("a", start + 30min);
  EXPECT_EQ(deleted_names.size(), 2u);
  deleted_names.expire(start + 80min);
  EXPECT_EQ(deleted_names.size(), 1u);
  EXPECT_TRUE(deleted_names.contains("a", start + 80min));
  deleted_names.remove("a");
  deleted_names.remove("a");
  EXPECT_EQ(deleted_names.size(), 0u);
}

TEST(DeletedNames, TheOldestGoFirstWhenThereAreTooMany) {
  DeletedNames many(1h);
  for (std::size_t i = 0; i < DeletedNames::max_count + 5; ++i) many.put(std::to_string(i), start);
  EXPECT_EQ(many.size(), DeletedNames::max_count);
  EXPECT_FALSE(many.contains("4", start));
  EXPECT_TRUE(many.contains("5", start));

  DeletedNames long_names(1h);
  const std::size_t size = 4000, fit = DeletedNames::max_bytes / (size + DeletedNames::entry_bytes);
  for (std::size_t i = 0; i < fit + 3; ++i)
    long_names.put(std::to_string(i) + std::string(size - std::to_string(i).size(), 'x'), start);
  EXPECT_EQ(long_names.size(), fit);
}

TEST(DeletedNames, CountAgainstTheMemory) {
  MemoryBudget memory(3 * DeletedNames::bytes("a"));
  DeletedNames deleted_names(1h);
  const auto put = [&](const std::string& name) {
    deleted_names.put(name, start, DeletedNames::lease(name, memory));
  };
  for (const char* name : {"a", "b", "c"}) put(name);
  EXPECT_EQ(memory.used(), memory.limit());
  put("d");
  EXPECT_FALSE(deleted_names.contains("a", start)) << "the oldest made room";
  for (const char* name : {"b", "c", "d"}) EXPECT_TRUE(deleted_names.contains(name, start)) << name;
  deleted_names.remove("b");
  EXPECT_LT(memory.used(), memory.limit());
  DeletedNames others(1h);
  others.put("e", start, DeletedNames::lease("a long name", memory));
  EXPECT_TRUE(others.contains("e", start)) << "the newest stays";
}

class RegistryDeletedNames : public testing::Test {
 protected:
  auto create(bool recreate) {
    return registry_.create(everybody, "a", test::scene(), "", {}, recreate);
  }

  std::chrono::steady_clock::time_point now_{};
  Registry registry_{3, 1h, [this] { return now_; }};
};

TEST_F(RegistryDeletedNames, ADeletedSessionDoesNotComeBack) {
  create(false);
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  registry_.erase(everybody, "a");
  EXPECT_TRUE(registry_.deleted(everybody, "a"));
  const auto back = create(true);
  ASSERT_FALSE(back);
  EXPECT_EQ(std::get<Registry::Conflict>(back.error()), Registry::Conflict::deleted);
  now_ += 1h;
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  EXPECT_TRUE(create(true));
}

TEST(RegistryMemory, DeletedNamesCountAndGiveUpCaches) {
  MemoryBudget memory(std::uint64_t{1} << 20);
  Registry registry(3, 1h, {}, memory);
  registry.create(everybody, "cached", test::scene(), "", {}, false);
  const MemoryLease others(memory, memory.limit() - memory.used());
  for (int i = 0; i < 10; ++i) registry.erase(everybody, std::to_string(i));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(registry.deleted(everybody, std::to_string(i))) << i;
  EXPECT_LE(memory.used(), memory.limit());
  EXPECT_GE(memory.used(), others.bytes() + 10 * DeletedNames::bytes("0"));
}

TEST_F(RegistryDeletedNames, ADeletionMayComeBeforeTheSession) {
  EXPECT_FALSE(registry_.erase(everybody, "a"));
  EXPECT_FALSE(create(true));
}

TEST_F(RegistryDeletedNames, ANewCreationMayUseTheName) {
  create(false);
  registry_.erase(everybody, "a");
  EXPECT_TRUE(create(false)->created);
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  EXPECT_FALSE(create(true)->created) << "which is then there for every handle";
}

TEST_F(RegistryDeletedNames, ASessionThatCouldNotBeWrittenLeavesTheDeletedName) {
  registry_.erase(everybody, "a");
  const auto made = create(false);
  ASSERT_TRUE(made);
  registry_.drop(*made->session);
  EXPECT_TRUE(registry_.deleted(everybody, "a"));
  EXPECT_FALSE(create(true));
}

TEST_F(RegistryDeletedNames, ADeletedNameEndsBeforeTheSessionAfterIt) {
  registry_.erase(everybody, "a");
  create(false);
  now_ += 1h;
  EXPECT_EQ(registry_.expire(), 1u);
  EXPECT_FALSE(registry_.deleted(everybody, "a"));
  EXPECT_TRUE(create(true)) << "it expired and was not deleted again";
}

TEST_F(RegistryDeletedNames, OnesOfAServerBeforeLastForWhatIsLeft) {
  const auto now = std::chrono::system_clock::now();
  registry_.mark_deleted(everybody, "over", now - 1s);
  registry_.mark_deleted(everybody, "a", now + 30min);
  registry_.mark_deleted(everybody, "long", now + 5h);
  EXPECT_FALSE(registry_.deleted(everybody, "over"));
  EXPECT_TRUE(registry_.deleted(everybody, "a"));
  now_ += 29min;
  EXPECT_FALSE(create(true));
  now_ += 2min;
  registry_.expire();
  EXPECT_TRUE(create(true));
  EXPECT_TRUE(registry_.deleted(everybody, "long"));
  now_ += 29min;
  EXPECT_FALSE(registry_.deleted(everybody, "long")) << "the idle timeout has become shorter";
}

TEST_F(RegistryDeletedNames, AnExpiredSessionComesBack) {
  create(false);
  now_ += 1h;
  EXPECT_EQ(registry_.expire(), 1u);
  EXPECT_TRUE(create(true)->created);
}

TEST_F(RegistryDeletedNames, ACheckpointReachesASessionThatIsThere) {
  Registry other(1, 1h, {});
  const auto ahead = other.create(everybody, "a", test::scene(), "");
  auto simulation = ahead->session->lease(0);
  simulation->advance(5000);
  const std::string checkpoint = encode_checkpoint(*ahead->session, *simulation);

  create(false);
  const auto again = registry_.create(everybody, "a", test::scene(), checkpoint, {}, true);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->created);
  EXPECT_EQ(again->session->lease(5001)->step(), 5000);
}

}  // namespace
}  // namespace stiefel::server
