// The names of a store's files: one of each, and they stay.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "server/sessions/store/store.h"
#include "tests/server/store/folder.h"
#include "tests/server/store/one_store.h"

namespace stiefel::server {
namespace {

using test::put;
using test::refusal;
using test::session;
using testing::HasSubstr;

class FileNamesTest : public testing::Test {
 protected:
  test::Folder folder_;
  const StoreOptions options_{folder_.file()};
};

TEST_F(FileNamesTest, AStoreWithASecondNameIsRefused) {
  { Store store(options_); }
  const std::string link = folder_.file("link");
  std::filesystem::create_hard_link(options_.file, link);
  for (const std::string& name : {options_.file, link})
    EXPECT_EQ(refusal({name}), "the store " + name +
                                   ": it has 2 names (hard links), must have 1: the log belongs to "
                                   "one name");
  std::filesystem::remove(link);
  EXPECT_EQ(refusal(options_), "");
}

TEST_F(FileNamesTest, WithoutItsLockFileASecondServerIsRefusedToo) {
  const Store store(options_);
  std::filesystem::remove(options_.file + "-lock");
  EXPECT_THAT(refusal(options_), HasSubstr("in use by another process"));
}

/// What a change of the store is refused with, or "" if it is made.
std::string refused_change(Store& store) {
  try {
    put(store, session("a"));
    return "";
  } catch (const StoreError& error) {
    EXPECT_EQ(error.kind(), WriteFault::Kind::unavailable);
    EXPECT_EQ(error.what(), store.fault());
    return error.what();
  }
}

TEST_F(FileNamesTest, WithoutItsFilesItTakesNoChange) {
  for (const std::string suffix : {"", "-wal", "-shm"}) {
    const std::string file = folder_.file("store" + (suffix.empty() ? "-main" : suffix));
    Store store({file});
    EXPECT_EQ(refused_change(store), "");
    std::filesystem::rename(file + suffix, folder_.file("elsewhere"));
    EXPECT_THAT(refused_change(store), HasSubstr(file + suffix + " was removed"));
    test::write_file(file + suffix, test::read_file(folder_.file("elsewhere")));
    EXPECT_THAT(refused_change(store), HasSubstr(file + suffix + " was replaced"));
    std::filesystem::rename(folder_.file("elsewhere"), file + suffix);
    EXPECT_EQ(refused_change(store), "") << "the file is back";
    std::filesystem::create_hard_link(file + suffix, folder_.file("link"));
    EXPECT_THAT(refused_change(store), HasSubstr(file + suffix + " has 2 names (hard links)"));
    std::filesystem::remove(folder_.file("link"));
    EXPECT_EQ(refused_change(store), "");
  }
}

}  // namespace
}  // namespace stiefel::server
