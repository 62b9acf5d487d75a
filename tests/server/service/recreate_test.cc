#include <gtest/gtest.h>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

TEST(Recreate, AStreamSendsCheckpointsBetweenDistantSamples) {
  test::Harness harness;
  harness.create("s", test::wire_scene());
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_from(1000);
  request.set_to(5000);
  request.set_every(3000);
  request.set_checkpoint_every(900);
  std::vector<std::int64_t> steps, checkpoints;
  std::string last;
  for (const auto& message : harness.stream(request)) {
    steps.insert(steps.end(), message.steps().begin(), message.steps().end());
    if (!message.has_checkpoint()) continue;
    checkpoints.push_back(message.checkpoint().step());
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

TEST(Recreate, AClosedFormNeedsNoCheckpointBetweenSamples) {
  test::Harness harness;
  harness.create("s", test::wire_scene({.method = "exact"}));
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(1'000'000'000);
  request.set_every(1'000'000'000);
  request.set_checkpoint_every(10);
  const auto messages = harness.stream(request);
  int checkpoints = 0;
  for (const auto& message : messages) checkpoints += message.has_checkpoint();
  EXPECT_EQ(checkpoints, 0);
}

}  // namespace
}  // namespace stiefel
