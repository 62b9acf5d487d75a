#include "server/sessions/sampling.h"

#include <gtest/gtest.h>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

class SamplingTest : public testing::Test {
 protected:
  Session session_{test::scene()};
};

TEST_F(SamplingTest, GoesOnAfterASuspensionWithTheSameBits) {
  Session large(test::scene({.method = "munthe_kaas4", .dimension = 70}));
  const auto walk_to = [&](bool suspends) {
    Sampling sampling(large, {0}, {0, 4, 4});
    while (!sampling.done()) {
      if (suspends) sampling.suspend();
      sampling.fill();
    }
    if (suspends) sampling.suspend();
    return sampling.take().fields[0];
  };
  EXPECT_EQ(walk_to(true), walk_to(false));

  Sampling stopped(large, {0}, {0, 4, 1});
  stopped.suspend();
  EXPECT_FALSE(stopped.save());
  EXPECT_EQ(stopped.cursor().run_status().outcome, Outcome::cancelled);
}

TEST_F(SamplingTest, WhatStopsEarlySavesTheLastGoodStateOnce) {
  Sampling sampling(session_, {0}, {0, 1'000'000'000, 1'000'000'000, 0, true});
  sampling.fill();
  EXPECT_TRUE(sampling.save());
  EXPECT_FALSE(sampling.done());
  const Batch batch = sampling.take();
  EXPECT_EQ(batch.steps, std::vector<std::int64_t>{0}) << "the samples asked for, and no other";
  const EncodedCheckpoint& last = batch.checkpoint;
  EXPECT_EQ(last.step, sampling.cursor().step());
  EXPECT_EQ(decode_checkpoint(session_, last.bytes)->saved,
            test::expected_state(session_.scene(), last.step));
  EXPECT_FALSE(sampling.save());
}

TEST_F(SamplingTest, CheckpointsAreOfTheSamplesTheyFollow) {
  Sampling sampling(session_, {0}, {100, 1000, 70, 300, true});
  std::vector<std::int64_t> steps;
  while (!sampling.done()) {
    while (!sampling.done() && !sampling.full()) sampling.fill();
    const Batch batch = sampling.take();
    const auto& [step, bytes] = batch.checkpoint;
    ASSERT_FALSE(bytes.empty());
    EXPECT_TRUE(sampling.take().checkpoint.bytes.empty()) << "once";
    const auto checkpoint = decode_checkpoint(session_, bytes);
    ASSERT_TRUE(checkpoint);
    EXPECT_EQ(checkpoint->step, batch.steps.back());
    EXPECT_EQ(checkpoint->step, step);
    EXPECT_EQ(checkpoint->saved, test::expected_state(session_.scene(), checkpoint->step));
    EXPECT_EQ(bytes.size(), checkpoint_bytes(session_));
    steps.push_back(checkpoint->step);
  }
  // 300 past 100 is 400, the first sample there 450; 300 past that 750, the first sample 800.
  EXPECT_EQ(steps, (std::vector<std::int64_t>{450, 800, 1000}));
}

}  // namespace
}  // namespace stiefel::server
