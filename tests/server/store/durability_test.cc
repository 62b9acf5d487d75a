// Servers with a store: what they answer after the one before them has ended, however it ended.
#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>

#include <atomic>
#include <mutex>
#include <random>
#include <thread>

#include "server/durability/stored_session.h"
#include "server/sessions/identity.h"
#include "tests/server/harness.h"
#include "tests/server/store/folder.h"
#include "tests/server/store/forgetful_vfs.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"

namespace stiefel::test {
namespace {

using google::protobuf::util::MessageDifferencer;
using ::testing::HasSubstr;

server::Options with_store(const std::string& file, std::uint64_t limit = 0,
                           const char* vfs = nullptr) {
  server::Options options;
  options.threads = 2;
  options.log_level = "off";
  options.store = {file, limit, vfs};
  return options;
}

/// A scene for each number.
v1::Scene numbered(int number) {
  v1::Scene scene = wire_scene();
  scene.set_step(0.01 + 1e-6 * number);
  return scene;
}

/// The call's end; the reason of the store's errors.
struct End {
  grpc::Status status;
  bool ok() const { return status.ok(); }
  std::string reason() const {
    v1::Status details;
    v1::ErrorInfo info;
    details.ParseFromString(status.error_details());
    if (details.details_size() > 0) info.ParseFromString(details.details(0).value());
    return info.reason();
  }
};

End create(Stub& stub, const std::string& id, const v1::Scene& scene) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  return {stub.CreateSession(&context, request, &response)};
}

End fork(Stub& stub, const std::string& id, const std::string& from, std::int64_t step) {
  v1::ForkSessionRequest request;
  request.set_session_id(id);
  request.set_from_session_id(from);
  request.set_from_step(step);
  grpc::ClientContext context;
  v1::ForkSessionResponse response;
  return {stub.ForkSession(&context, request, &response)};
}

End erase(Stub& stub, const std::string& id) {
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  grpc::ClientContext context;
  v1::DeleteSessionResponse response;
  return {stub.DeleteSession(&context, request, &response)};
}

/// What GetSession answers, without what a restart may change.
std::optional<v1::Session> get(Stub& stub, const std::string& id, v1::SceneView view) {
  v1::GetSessionRequest request;
  request.set_session_id(id);
  request.mutable_view()->set_scene(view);
  request.mutable_view()->set_checksum(true);
  grpc::ClientContext context;
  v1::GetSessionResponse response;
  if (!stub.GetSession(&context, request, &response).ok()) return std::nullopt;
  response.mutable_session()->clear_cached_steps();
  response.mutable_session()->clear_cursor();
  response.mutable_session()->clear_expire_time();
  return response.session();
}

v1::DescribeResponse describe(Stub& stub) {
  grpc::ClientContext context;
  v1::DescribeResponse response;
  EXPECT_TRUE(stub.Describe(&context, {}, &response).ok());
  return response;
}

TEST(StoredSession, KeepsTheBitsOfEverySystemAndMethod) {
  const auto clock = std::make_shared<const server::Clock>(&std::chrono::steady_clock::now);
  int number = 0;
  for (const auto& [system, method, N] : stiefel::testing::every_pair()) {
    const auto given = stiefel::testing::any_scene(system, method, 1, 0.02, N);
    const auto scene = Scene::resolve(given);
    ASSERT_TRUE(scene) << system << " " << method;
    server::Resolution resolution{server::difference(given, scene->description()), std::nullopt};
    if (number++ % 2)
      resolution.choice = server::ChosenMethod{0.1, 3, "for a reason\nof two lines"};
    server::Session session("a", *scene, clock, resolution);
    session.restored(server::Principal{"p"}, std::chrono::system_clock::now());
    const auto row = server::to_row(session);
    const auto again = server::from_row({row, std::nullopt}, clock);
    ASSERT_TRUE(again) << system << " " << method << ": " << again.error();
    EXPECT_EQ((*again)->identity(), session.identity()) << system << " " << method;
    EXPECT_EQ((*again)->owner(), session.owner());
    EXPECT_EQ((*again)->create_time(), session.create_time());
    const server::Resolution& read = (*again)->resolution();
    EXPECT_EQ(read.difference.filled_in, resolution.difference.filled_in);
    EXPECT_EQ(read.difference.cleared, resolution.difference.cleared);
    ASSERT_EQ(read.choice.has_value(), resolution.choice.has_value());
    EXPECT_TRUE(!read.choice || read.choice->reason == resolution.choice->reason);
  }
  EXPECT_GT(number, 30);
}

TEST(StoredSession, OfAnotherSceneIsNotTakenForIt) {
  const auto clock = std::make_shared<const server::Clock>(&std::chrono::steady_clock::now);
  const server::Session session("a", scene(), clock);
  auto row = server::to_row(session);
  row.identity ^= 1;
  EXPECT_FALSE(server::from_row({row, std::nullopt}, clock));
  row.numerics_id = "another build";  // whose scenes may have more fields
  EXPECT_TRUE(server::from_row({row, std::nullopt}, clock));
  row.scene = "no message";
  EXPECT_FALSE(server::from_row({row, std::nullopt}, clock));
}

class DurabilityTest : public ::testing::Test {
 protected:
  Folder folder_;
  const std::string file_ = folder_.file();
};

TEST_F(DurabilityTest, DescribeSaysWhetherSessionsLast) {
  EXPECT_FALSE(describe(*Harness().stub).durable());
  EXPECT_TRUE(describe(*Harness(with_store(file_)).stub).durable());
}

TEST_F(DurabilityTest, ANewServerAnswersAsTheOldOne) {
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

TEST_F(DurabilityTest, ALongRunGoesOnFromItsCheckpoint) {
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

/// The reason why a handle that has lost this session may not create it again; OK if it did.
std::string recreate(Stub& stub, const std::string& id, const v1::Scene& scene) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  request.set_recreate(true);
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  const End end{stub.CreateSession(&context, request, &response)};
  return end.ok() ? "OK" : end.reason();
}

TEST_F(DurabilityTest, ADeletedSessionStaysDeletedAfterARestart) {
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

TEST_F(DurabilityTest, ATombstoneEndsWithTheIdleTimeout) {
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
  EXPECT_TRUE(store.tombstones(0).empty()) << "a server that starts removes what is over";
}

TEST_F(DurabilityTest, RestoredSessionsTakeTheirSeats) {
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

TEST_F(DurabilityTest, RestoredSessionsCountInTheirPrincipalsMemory) {
  auto options = with_store(file_);
  {
    Harness harness(options);
    for (int i = 0; i < 40; ++i) harness.create(std::to_string(i), numbered(i));
  }
  options.quota.memory = 40 * 10'000;  // the sessions without their simulations, and little more
  const auto count = [](Stub& stub) {
    int more = 0;
    while (more < 1000 && create(stub, std::to_string(1000 + more), numbered(more)).ok()) ++more;
    return more;
  };
  int with = 0, without = 0;
  with = count(*Harness(options).stub);
  std::filesystem::remove(file_);
  without = count(*Harness(options).stub);
  EXPECT_GT(without, 20);
  EXPECT_LE(with, without - 20);
}

TEST_F(DurabilityTest, EverySessionIsRestoredHoweverSmallTheLimitOfAPrincipal) {
  auto options = with_store(file_);
  {
    Harness harness(options);
    for (int i = 0; i < 40; ++i) harness.create(std::to_string(i), numbered(i));
  }
  options.quota.memory = 50'000;
  Harness harness(options);
  for (int i = 0; i < 40; ++i)
    EXPECT_TRUE(get(*harness.stub, std::to_string(i), v1::SCENE_VIEW_NONE)) << i;
  const End end = create(*harness.stub, "more", numbered(0));
  EXPECT_EQ(end.reason(), "OVER_QUOTA");
}

TEST_F(DurabilityTest, AStoreOfASecondServerIsRefused) {
  const Harness harness(with_store(file_));
  try {
    const server::Server second(with_store(file_));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("in use by process"));
  }
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
