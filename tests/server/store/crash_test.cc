// The machine stops at every moment, and what was not synchronized is lost.
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <random>

#include "tests/support/folder.h"
#include "tests/server/store/forgetful_vfs.h"
#include "tests/server/store/stores.h"

namespace stiefel::server {
namespace {

using test::ForgetfulVfs;

/// Of one id: the version that the caller was told last, and what it asked for after that without
/// an answer.
struct Told {
  std::optional<int> version;  ///< none: deleted, or never created
  bool asked = false;
  std::optional<int> asked_for = {};
};
using Expected = std::map<std::string, Told>;

StoredSession version(const std::string& id, int number) {
  auto row = test::row(id);
  row.create_time = number;
  return row;
}

/// Makes a store, and creates and deletes sessions in an order that `seed` draws, one call after
/// another or several at once, until it is done or the machine stops.
void run(const std::string& file, const ForgetfulVfs& vfs, std::uint64_t seed, Expected& expected) {
  std::mt19937_64 random(seed);
  const auto draw = [&](int below) {
    return static_cast<int>(random() % static_cast<unsigned>(below));
  };
  Store store(file);
  StoreWriter writer(store);
  for (int round = 0; round < 12 && !vfs.crashed(); ++round) {
    struct Call {
      std::string id;
      std::optional<int> version;
      PendingWrite end;
    };
    std::vector<Call> calls;
    for (int i = 0, count = 1 + draw(4); i < count; ++i) {
      Call call{std::to_string(10 * i + draw(3)), std::nullopt, {}};
      if (!expected[call.id].version) call.version = round;
      call.end = writer.submit(
          [call](Store& to) {
            if (call.version) return to.put(version(call.id, *call.version));
            to.erase({}, call.id);
          },
          [](const WriteFault&) {});
      calls.push_back(std::move(call));
    }
    for (const Call& call : calls) {
      Told& told = expected[call.id];
      if (call.end.get()) {
        told.asked = true;
        told.asked_for = call.version;
      } else {
        told = {call.version};
      }
    }
  }
}

/// Acknowledged sessions are there with their bits, acknowledged deletions are deleted, and a call
/// that was not answered has happened or not.
void expect_stored(const std::string& file, const Expected& expected, const std::string& where) {
  Store store(file);
  const auto all = test::rows(store);
  for (const auto& [id, told] : expected) {
    const auto found = all.find("/" + id);
    std::optional<int> is;
    if (found != all.end()) is = static_cast<int>(found->second.session.create_time);
    EXPECT_TRUE(is == told.version || (told.asked && is == told.asked_for))
        << "session " << id << ", " << where;
  }
  for (const auto& [name, row] : all)
    EXPECT_TRUE(expected.contains(row.session.id)) << name << ", " << where;
}

/// One run that stops at call `crash` of the file system; false if it came to its end before.
bool crashes(std::uint64_t seed, std::int64_t crash, double kept) {
  const test::Folder folder;
  std::mt19937_64 random(seed + static_cast<std::uint64_t>(crash));
  ForgetfulVfs vfs;
  Expected expected;
  vfs.crash_at(crash);
  try {
    run(folder.file(), vfs, seed, expected);
  } catch (const std::runtime_error&) {  // it stopped while it was opened
  }
  const bool crashed = vfs.crashed();
  vfs.restart(kept, random);
  expect_stored(folder.file(), expected,
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

}  // namespace
}  // namespace stiefel::server
