// What guards the service, without sockets: tokens, keys, addresses.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <latch>

#include "server/connections/callers.h"
#include "server/connections/listener.h"
#include "server/connections/watched_files.h"
#include "tests/server/harness.h"

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

const std::string digits(64, 'a');

TEST(Tokens, OfEachLine) {
  const auto alice = make_token("alice"), second = make_token("alice"), bob = make_token("bob");
  const auto [table, faults] =
      parse_tokens("# comment\n\n  " + alice.line + "\t\r\n" + second.line + '\n' + bob.line);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(table.size(), 3u);
  for (const auto& [token, name] :
       {std::pair{alice.token, "alice"}, {second.token, "alice"}, {bob.token, "bob"}})
    EXPECT_EQ(table.at(*digest_of_bearer("Bearer " + token)).name, name);
  EXPECT_FALSE(table.contains(""));
}

TEST(Tokens, LinesThatAreNoneLetNobodyIn) {
  const auto good = make_token("good");
  const auto [table, faults] = parse_tokens("a\n" + good.line + "\nb " + digits + "b\nc/d " +
                                            digits + "\ne " + digits + " more\n" + good.line);
  EXPECT_EQ(table.size(), 1u);
  ASSERT_EQ(faults.size(), 5u);
  const char* lines[] = {"line 1: ", "line 3: ", "line 4: ", "line 5: ", "line 6: "};
  for (std::size_t i = 0; i < faults.size(); ++i) {
    EXPECT_TRUE(faults[i].starts_with(lines[i])) << faults[i];
    EXPECT_EQ(faults[i].find(digits), std::string::npos) << "it shows what may be a secret";
  }
}

TEST(Tokens, OfTheMetadata) {
  const auto expected = digest_of_bearer("Bearer x.y");
  ASSERT_TRUE(expected);
  for (const char* text : {"bearer x.y", "BEARER   x.y ", " Bearer\tx.y"})
    EXPECT_EQ(digest_of_bearer(text), expected) << text;
  for (const char* text : {"", "Bearer", "Bearer ", "x.y", "Basic x.y", "Bearerx.y", "Bearer x y"})
    EXPECT_EQ(digest_of_bearer(text), std::nullopt) << text;
}

TEST(Exposure, OfAddresses) {
  for (const char* here :
       {"127.0.0.1:1", "127.255.255.254:1", "[::1]:1", "[::ffff:127.0.0.1]:1", "unix:/x"})
    EXPECT_FALSE(is_exposed(here)) << here;
  for (const char* beyond : {"0.0.0.0:1", "[::]:1", "192.0.2.1:1", "10.0.0.1:1", "128.0.0.1:1",
                             "126.0.0.255:1", "[2001:db8::1]:1"})
    EXPECT_TRUE(is_exposed(beyond)) << beyond;
}

struct Folder {
  Folder() {
    char name[] = "/tmp/stiefel-access-XXXXXX";
    path = mkdtemp(name);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string write(const std::string& name, const std::string& text) const {
    const auto file = path / name;
    std::ofstream(file) << text;
    return file;
  }
  std::filesystem::path path;
};

TEST(WatchedFiles, TellOfWhatIsWhole) {
  const Folder folder;
  const std::vector paths = {folder.write("a", "1"), folder.write("b", "1")};
  std::mutex mutex;
  std::vector<std::string> heard;
  const auto changed = [&](const WatchedFiles::Contents& now) {
    const std::lock_guard lock(mutex);
    heard.push_back(now[0].value_or("none") + now[1].value_or("none"));
  };
  const auto last = [&] {
    const std::lock_guard lock(mutex);
    return heard.empty() ? "" : heard.back();
  };
  const auto wait_for = [&](const std::string& text) {
    for (int i = 0; i < 2000 && last() != text; ++i) std::this_thread::sleep_for(5ms);
    return last() == text;
  };
  const Log log("off", false);
  const WatchedFiles watch(paths, log, "files", changed, 5ms);
  EXPECT_EQ(last(), "11") << "at the start";
  folder.write("a", "2");
  EXPECT_TRUE(wait_for("21"));
  std::filesystem::remove(paths[1]);
  EXPECT_TRUE(wait_for("2none"));
  folder.write("b", "3");
  EXPECT_TRUE(wait_for("23"));
  EXPECT_FALSE(read_text("/dev/zero"));
  EXPECT_FALSE(read_text(folder.path));
}

TEST(Gate, EmbeddedServersHaveOneToo) {
  const Folder folder;
  const NewToken alice = make_token("alice");
  test::Harness harness({.access = {.tokens = folder.write("tokens", alice.line)}});
  const auto describe = [&](const std::string& token) {
    grpc::ClientContext context;
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    v1::DescribeResponse response;
    return harness.stub->Describe(&context, {}, &response).error_code();
  };
  EXPECT_EQ(describe(""), grpc::UNAUTHENTICATED);
  EXPECT_EQ(describe(alice.token + "0"), grpc::UNAUTHENTICATED);
  EXPECT_EQ(describe(alice.token), grpc::OK);
}

TEST(Gate, LeavesNothingOfACallBehind) {
  const Folder folder;
  const NewToken alice = make_token("alice");
  test::Harness harness({.access = {.tokens = folder.write("tokens", alice.line)}});
  std::vector<std::jthread> threads;
  std::atomic<int> passed = 0;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      for (int k = 0; k < 200; ++k) {
        grpc::ClientContext context;
        context.AddMetadata("authorization", "Bearer " + (i % 2 ? alice.token : "none"));
        v1::ListSessionsResponse response;
        passed += harness.stub->ListSessions(&context, {}, &response).ok();
      }
    });
  }
  threads.clear();
  EXPECT_EQ(passed, 400);
}

}  // namespace
}  // namespace stiefel::server
