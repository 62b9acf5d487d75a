// The machine stops at every moment, and what was not synchronized is lost.
#include <gtest/gtest.h>

#include <random>

#include "server/sessions/store/journal.h"
#include "tests/server/store/folder.h"
#include "tests/server/store/forgetful_vfs.h"
#include "tests/server/store/write_ahead_logs.h"

namespace stiefel::server {
namespace {

using test::everybody;

using test::ForgetfulVfs;
using test::outcome;
using test::Written;

/// Of one id: what the caller was told last, and what it asked for after that without an answer.
struct Told {
  std::optional<int> scene;  ///< none: deleted, or never created
  bool asked = false;
  std::optional<int> asked_for = {};
};
using Expected = std::map<std::string, Told>;

/// Creates and deletes sessions in an order that `seed` draws, one call after another or several at
/// once, until it is done or the machine stops.
Expected run(const StoreOptions& options, ForgetfulVfs& vfs, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto draw = [&](int below) {
    return static_cast<int>(random() % static_cast<unsigned>(below));
  };
  Expected expected;
  Written written(options, std::chrono::milliseconds(1));
  for (int round = 0; round < 12 && !vfs.crashed(); ++round) {
    struct Call {
      std::string id;
      std::optional<int> scene;
      std::shared_ptr<PendingWrite> pending_write;
    };
    std::vector<Call> calls;
    for (int i = 0, count = 1 + draw(4); i < count; ++i) {
      const std::string id = std::to_string(10 * i + draw(3));
      const bool there = written.registry.find(everybody, id).has_value();
      if (there)
        calls.push_back({id, std::nullopt, written.registry.erase(everybody, id).pending_write});
      else
        calls.push_back({id, round, written.create(id, round)});
    }
    for (const Call& call : calls) {
      Told& told = expected[call.id];
      const auto fault = outcome(*call.pending_write);
      if (fault) {
        told.asked = true;
        told.asked_for = call.scene;
      } else {
        told = {call.scene};
      }
    }
  }
  return expected;
}

/// Acknowledged sessions are there with their bits, acknowledged deletions are deleted, and a call
/// that was not answered has happened or not.
void expect_stored(const std::string& file, const Expected& expected, const std::string& where) {
  const auto stored = test::stored(file);
  const auto bytes = [](const std::optional<int>& scene) {
    return scene ? identity_of(test::numbered_scene(*scene).description()) : "";
  };
  for (const auto& [id, told] : expected) {
    const auto found = stored.find(id);
    const std::string is = found == stored.end() ? "" : found->second;
    EXPECT_TRUE(is == bytes(told.scene) || (told.asked && is == bytes(told.asked_for)))
        << "session " << id << ", " << where;
  }
  for (const auto& [id, scene] : stored) EXPECT_TRUE(expected.contains(id)) << id << ", " << where;
}

/// One run that stops at call `crash` of the file system; false if it came to its end before.
bool crashes(std::uint64_t seed, std::int64_t crash, double kept) {
  const test::Folder folder;
  const std::string file = folder.file();
  { Store made({file}); }
  std::mt19937_64 random(seed + static_cast<std::uint64_t>(crash));
  ForgetfulVfs vfs;
  const StoreOptions options{file, 0, ForgetfulVfs::name};
  Expected expected;
  vfs.crash_at(crash);
  try {
    expected = run(options, vfs, seed);
  } catch (const std::runtime_error&) {  // it stopped while it was opened
  }
  const bool crashed = vfs.crashed();
  vfs.restart(kept, random);
  expect_stored(file, expected,
                "crash at call " + std::to_string(crash) + ", kept " + std::to_string(kept));
  return crashed;
}

class Crash : public testing::TestWithParam<double> {};

TEST_P(Crash, AtEveryCallOfTheFileSystemLosesNothingAcknowledged) {
  std::int64_t crash = 0;
  while (crashes(1, crash, GetParam()) && !HasFailure()) ++crash;
  EXPECT_GT(crash, 50) << "the run is long enough to be interrupted in all of its parts";
}

TEST_P(Crash, AtRandomCallsOfOtherRunsLosesNothingAcknowledged) {
  std::mt19937_64 random(2);
  for (std::uint64_t seed = 100; seed < 160 && !HasFailure(); ++seed)
    crashes(seed, static_cast<std::int64_t>(random() % 150), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Kept, Crash, testing::Values(0.0, 0.5, 1.0), [](const auto& kept) {
  return kept.param == 0 ? "Nothing" : kept.param == 1 ? "All" : "Half";
});

/// The test would notice a store that answers before it is synchronized.
TEST(CrashTest, WithoutSynchronizationAcknowledgedSessionsAreLost) {
  const test::Folder folder;
  { Store made({folder.file()}); }
  ForgetfulVfs vfs;
  std::mt19937_64 random(1);
  {
    Database database(folder.file(), Database::Mode::existing, ForgetfulVfs::name);
    database.run("PRAGMA synchronous=OFF");
    database.run("INSERT INTO deleted_name VALUES (0, '', 'a', 1)");
    vfs.crash_at(0);
  }
  vfs.restart(0, random);
  Store store({folder.file()});
  EXPECT_TRUE(store.deleted_names(0).empty());
}

}  // namespace
}  // namespace stiefel::server
