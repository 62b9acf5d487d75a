#include <gtest/gtest.h>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Recreate : public testing::Test {
 protected:
  grpc::Status create(bool recreate) {
    v1::CreateSessionRequest request;
    request.set_session_id("s");
    *request.mutable_scene() = test::wire_scene();
    request.set_recreate(recreate);
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    return harness_.stub->CreateSession(&context, request, &response);
  }
  void erase() {
    v1::DeleteSessionRequest request;
    request.set_session_id("s");
    grpc::ClientContext context;
    v1::DeleteSessionResponse response;
    EXPECT_TRUE(harness_.stub->DeleteSession(&context, request, &response).ok());
  }
  grpc::Status get() {
    v1::GetSessionRequest request;
    request.set_session_id("s");
    grpc::ClientContext context;
    v1::GetSessionResponse response;
    return harness_.stub->GetSession(&context, request, &response);
  }
  static std::string reason(const grpc::Status& status) {
    v1::Status details;
    v1::ErrorInfo info;
    EXPECT_TRUE(details.ParseFromString(status.error_details()));
    if (details.details_size() > 0) info.ParseFromString(details.details(0).value());
    return info.reason();
  }

  test::Harness harness_;
};

TEST_F(Recreate, ADeletedSessionHasAReasonOfItsOwn) {
  EXPECT_EQ(reason(get()), "SESSION_NOT_FOUND");
  EXPECT_TRUE(create(false).ok());
  erase();
  const grpc::Status gone = get();
  EXPECT_EQ(gone.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(reason(gone), "SESSION_DELETED");
  EXPECT_EQ(gone.error_message(), "session_id: s: this session was deleted");
}

TEST_F(Recreate, OnlyWhoCreatesAnewMayUseTheNameOfADeletedSession) {
  EXPECT_TRUE(create(true).ok()) << "the session of another server";
  erase();
  const grpc::Status refused = create(true);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(reason(refused), "SESSION_DELETED");
  EXPECT_TRUE(create(false).ok());
  EXPECT_TRUE(get().ok());
}

TEST_F(Recreate, AStreamSendsCheckpointsBetweenDistantSamples) {
  harness_.create("s", test::wire_scene());
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_from(1000);
  request.set_to(5000);
  request.set_every(3000);
  request.set_checkpoint_every(900);
  std::vector<std::int64_t> steps, checkpoints;
  std::string last;
  for (const auto& message : harness_.stream(request)) {
    steps.insert(steps.end(), message.steps().begin(), message.steps().end());
    if (!message.has_checkpoint()) continue;
    checkpoints.push_back(message.checkpoint().step());
    EXPECT_EQ(message.checkpoint().size(), message.checkpoint().data().size());
    last = message.checkpoint().data();
  }
  EXPECT_EQ(steps, (std::vector<std::int64_t>{1000, 4000, 5000}));
  EXPECT_EQ(checkpoints, (std::vector<std::int64_t>{900, 1800, 2700, 3600, 4500}));

  test::Harness other;
  other.create("s", test::wire_scene(), last);
  const auto reply = other.step("s", 5000);
  EXPECT_EQ(reply.computed_steps(), 500);
  EXPECT_EQ(test::bytes_of(reply.sample()), test::expected_bytes(test::scene(), 5000));
}

TEST_F(Recreate, AClosedFormNeedsNoCheckpointBetweenSamples) {
  harness_.create("s", test::wire_scene({.method = "exact"}));
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(1'000'000'000);
  request.set_every(1'000'000'000);
  request.set_checkpoint_every(10);
  const auto messages = harness_.stream(request);
  int checkpoints = 0;
  for (const auto& message : messages) checkpoints += message.has_checkpoint();
  EXPECT_EQ(checkpoints, 0);
}

}  // namespace
}  // namespace stiefel
