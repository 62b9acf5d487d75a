// Calls that are repeated, when and how often.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <limits>
#include <memory>
#include <thread>

#include "client/cpp/uuid.h"
#include "tests/client/unreliable.h"

namespace stiefel::client {
namespace {

using RetryTest = UnreliableTest;

TEST_F(RetryTest, ACallIsRepeatedWhileTheServerIsUnavailable) {
  service_.failures = 3;
  EXPECT_EQ(Client(channel_).describe().version(), "1");
  EXPECT_EQ(service_.calls, 4);
}

TEST_F(RetryTest, PatienceEnds) {
  service_.failures = 1'000'000;
  Options options;
  options.patience = std::chrono::milliseconds(60);
  const Client client(channel_, options);
  EXPECT_THROW(client.describe(), Error);
  EXPECT_EQ(service_.calls, 3);  // at 0, 25 and 75 ms
}

TEST_F(RetryTest, AServerThatComesLateIsFound) {
  const std::string address = "unix:" + testing::TempDir() + "stiefel_" + make_uuid();
  Options options;
  options.patience = std::chrono::milliseconds(0);
  EXPECT_THROW(Client::connect(address, options).describe(), Error);

  std::unique_ptr<grpc::Server> server;
  const std::jthread late([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address, grpc::InsecureServerCredentials());
    builder.RegisterService(&service_);
    server = builder.BuildAndStart();
  });
  options.patience = std::chrono::minutes(1);
  EXPECT_EQ(Client::connect(address, options).describe().version(), "1");
}

TEST_F(RetryTest, AWrongRequestIsNotRepeated) {
  service_.failures = 1;
  service_.failure = {grpc::StatusCode::INVALID_ARGUMENT, "no"};
  EXPECT_THROW(Client(channel_).describe(), Error);
  EXPECT_EQ(service_.calls, 1);
}

TEST_F(RetryTest, ARefusalWithATimeIsRepeatedAfterIt) {
  service_.failures = 3;
  service_.failure = refusal(std::chrono::milliseconds(20));
  Options options;
  options.patience = std::chrono::milliseconds(0);  // of a server that is not there
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Client(channel_, options).describe().version(), "1");
  EXPECT_EQ(service_.calls, 4);
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(60));
}

TEST_F(RetryTest, ARefusalWithoutATimeIsNotRepeated) {
  service_.failures = 1;
  service_.failure = refusal(std::chrono::milliseconds(0));
  EXPECT_THROW(Client(channel_).describe(), Error);
  EXPECT_EQ(service_.calls, 1);
}

TEST_F(RetryTest, ARefusalUntilAfterTheDeadlineIsToldAtOnce) {
  service_.failures = 1;
  service_.failure = refusal(std::chrono::hours(1));
  const auto start = std::chrono::steady_clock::now();
  try {
    Client(channel_).describe();
    ADD_FAILURE() << "no Error was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << error.what();
    EXPECT_EQ(error.retry_delay(), std::chrono::hours(1));
  }
  EXPECT_EQ(service_.calls, 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(RetryTest, AttemptsForBothReasonsAddUp) {
  service_.failures = 1'000'000;
  int refused = 0;
  service_.next_failure = [&](int call) {
    if (call % 2) return unavailable;
    ++refused;
    return refusal(std::chrono::milliseconds(1));
  };
  Options options;
  options.patience = std::chrono::milliseconds(60);
  EXPECT_THROW(Client(channel_, options).describe(), Error);
  EXPECT_EQ(service_.calls, 5) << "two pauses of patience, and a refusal before each and the end";
  EXPECT_EQ(refused, 2);
}

TEST_F(RetryTest, ARefusedRequestOfADriveIsRepeatedOnIt) {
  service_.failures = 3;
  service_.failure = refusal(std::chrono::milliseconds(1));
  v1::Session description;
  description.set_session_id("any");
  const Session session(connection(), description, {}, true);
  Drive drive = session.drive();
  EXPECT_EQ(drive.step(7).sample().step(), 7);
  EXPECT_EQ(service_.calls, 4);
  service_.failures = 1;
  service_.failure = refusal(std::chrono::milliseconds(0));
  EXPECT_THROW(drive.step(8), Error);
  EXPECT_EQ(drive.step(9).sample().step(), 9) << "the drive lives";
}

TEST(RefusalsTest, AreBounded) {
  Refusals refusals;
  const grpc::Status status = refusal(std::chrono::milliseconds(5));
  for (int i = 0; i < Refusals::most; ++i) {
    const auto pause = refusals.next(status);
    ASSERT_TRUE(pause);
    EXPECT_GE(*pause, std::chrono::milliseconds(5));
    EXPECT_LE(*pause, std::chrono::milliseconds(5 + std::min(10 << std::min(i, 7), 1000)));
  }
  EXPECT_FALSE(refusals.next(status));
  EXPECT_FALSE(Refusals().next(unavailable));
}

TEST(RefusalsTest, AreNotWaitedForForEver) {
  using std::chrono::seconds;
  EXPECT_TRUE(Refusals().next(refusal(seconds(300))));
  for (const auto delay : {seconds(301), seconds(1'000'000), seconds(1'000'000'000)})
    EXPECT_FALSE(Refusals().next(refusal(delay))) << delay.count();
}

TEST(RefusalsTest, WithANumberThatNoClockHasAreOnlyLong) {
  v1::RetryInfo retry;
  v1::Status status;
  auto& any = *status.add_details();
  any.set_type_url("type.googleapis.com/google.rpc.RetryInfo");
  const auto delay = [&](std::int64_t seconds, int nanoseconds) {
    retry.mutable_retry_delay()->set_seconds(seconds);
    retry.mutable_retry_delay()->set_nanos(nanoseconds);
    any.set_value(retry.SerializeAsString());
    return *Error(status).retry_delay();
  };
  EXPECT_GT(delay(std::numeric_limits<std::int64_t>::max(), 999'999'999), Refusals::longest);
  EXPECT_EQ(delay(std::numeric_limits<std::int64_t>::min(), -5), std::chrono::seconds(0));
  EXPECT_EQ(delay(3, 500'000'000), std::chrono::milliseconds(3500));
}

TEST_F(RetryTest, ACallWithoutADeadlineIsNotRefusedForYears) {
  service_.failures = 1'000'000;
  service_.failure = refusal(std::chrono::hours(100'000));
  v1::Session description;
  description.set_session_id("any");
  const Session session(connection(), description, {}, true);
  EXPECT_THROW(session.drive().step(7), Error);
  EXPECT_THROW(session.stream({.to = 3}).next_batch(), Error);
}

/// gRPC's own threads must not keep a program from ending whose client is open.
TEST(ExitDeathTest, WithAClientThatIsOpen) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        static const Client client =
            Client::connect("127.0.0.1:1", {.patience = std::chrono::milliseconds(100)});
        try {
          client.describe();
        } catch (const Error& error) {
          std::exit(error.code() == grpc::StatusCode::UNAVAILABLE ? 0 : 1);
        }
      },
      testing::ExitedWithCode(0), "");
}

TEST_F(RetryTest, APauseEndsWithTheDeadline) {
  service_.failures = 1'000'000;
  Options options;
  options.timeout = std::chrono::milliseconds(100);
  options.patience = std::chrono::hours(1);
  try {
    Client(channel_, options).describe();
    ADD_FAILURE() << "no Error was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::DEADLINE_EXCEEDED) << error.what();
  }
}

}  // namespace
}  // namespace stiefel::client
