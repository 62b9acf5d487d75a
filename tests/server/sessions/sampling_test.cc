#include "server/sessions/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

class SamplingTest : public testing::Test {
 protected:
  struct All {
    std::vector<std::int64_t> steps;
    std::string Q;
    std::vector<std::size_t> batches;
  };
  static All collect(Session& session, Sampling::Range range) {
    Sampling sampling(session, {0}, range);
    Batch batch;
    All all;
    while (!sampling.done()) {
      sampling.clear(batch);
      while (!sampling.done() && !sampling.full(batch)) sampling.fill(batch);
      sampling.trim(batch);
      all.steps.insert(all.steps.end(), batch.steps.begin(), batch.steps.end());
      all.Q += batch.fields[0];
      all.batches.push_back(batch.size());
    }
    return all;
  }

  Session session_{test::scene()};
};

TEST_F(SamplingTest, AlwaysTheLastOne) {
  EXPECT_EQ(collect(session_, {3, 10, 3}).steps, (std::vector<std::int64_t>{3, 6, 9, 10}));
  EXPECT_EQ(collect(session_, {3, 9, 3}).steps, (std::vector<std::int64_t>{3, 6, 9}));
  EXPECT_EQ(collect(session_, {5, 5, 1}).steps, (std::vector<std::int64_t>{5}));
  EXPECT_EQ(collect(session_, {0, 5, std::int64_t{1} << 62}).steps,
            (std::vector<std::int64_t>{0, 5}));
}

TEST_F(SamplingTest, GoesOnAfterASuspensionWithTheSameBits) {
  Session large(test::scene({.method = "munthe_kaas4", .dimension = 70}));
  const auto walk_to = [&](bool suspends) {
    Sampling sampling(large, {0}, {0, 4, 4});
    Batch batch;
    sampling.clear(batch);
    while (!sampling.done()) {
      if (suspends) sampling.suspend();
      sampling.fill(batch);
    }
    if (suspends) sampling.suspend();
    return batch.fields[0];
  };
  EXPECT_EQ(walk_to(true), walk_to(false));

  Sampling stopped(large, {0}, {0, 4, 1});
  Batch batch;
  stopped.clear(batch);
  stopped.suspend();
  EXPECT_FALSE(stopped.save(batch));
  EXPECT_EQ(stopped.cursor().run_status().outcome, Outcome::cancelled);
}

TEST_F(SamplingTest, TheBytesAreTheStates) {
  const All all = collect(session_, {0, 5000, 1});
  const auto simulation = make_simulation(session_.scene());
  ASSERT_EQ(all.steps.size(), 5001u);
  ASSERT_EQ(all.Q.size(), 5001u * 72);
  for (std::size_t i = 0; i < all.steps.size(); ++i) {
    std::array<double, 9> Q;
    simulation->advance(static_cast<std::int64_t>(i) - simulation->step());
    simulation->write(0, Q);
    ASSERT_EQ(std::memcmp(Q.data(), all.Q.data() + i * 72, 72), 0) << "step " << i;
  }
}

TEST_F(SamplingTest, BatchesAreFullButTheLast) {
  const std::size_t full = Sampling::batch_bytes / (72 + 16);
  const All all = collect(session_, {0, static_cast<std::int64_t>(2 * full + 9), 1});
  EXPECT_EQ(all.batches, (std::vector<std::size_t>{full, full, 10}));
}

TEST_F(SamplingTest, WhatStopsEarlySavesTheLastGoodStateOnce) {
  Sampling sampling(session_, {0}, {0, 1'000'000'000, 1'000'000'000, 0, true});
  Batch batch;
  sampling.clear(batch);
  sampling.fill(batch);
  EXPECT_TRUE(sampling.save(batch));
  EXPECT_FALSE(sampling.done());
  EXPECT_EQ(batch.steps, std::vector<std::int64_t>{0}) << "the samples asked for, and no other";
  const EncodedCheckpoint last = sampling.take_checkpoint();
  EXPECT_EQ(last.step, sampling.cursor().step());
  EXPECT_EQ(decode_checkpoint(session_, last.bytes)->saved,
            test::expected_state(session_.scene(), last.step));
  sampling.clear(batch);
  EXPECT_FALSE(sampling.save(batch));
}

TEST_F(SamplingTest, ANumericalStopEndsWithTheLastGoodState) {
  SceneDescription wild = test::description();
  wild.step = 40;
  Session session(Scene::resolve(wild).value());
  Sampling sampling(session, {0}, {50, 100, 1});
  Batch batch;
  sampling.clear(batch);
  sampling.fill(batch);
  EXPECT_TRUE(sampling.done());
  EXPECT_EQ(sampling.cursor().run_status().outcome, Outcome::left_domain);
  EXPECT_EQ(batch.steps, (std::vector<std::int64_t>{sampling.cursor().step()}));
}

TEST_F(SamplingTest, CheckpointsAreOfTheSamplesTheyFollow) {
  Sampling sampling(session_, {0}, {100, 1000, 70, 300, true});
  Batch batch;
  std::vector<std::int64_t> steps;
  while (!sampling.done()) {
    sampling.clear(batch);
    while (!sampling.done() && !sampling.full(batch)) sampling.fill(batch);
    const auto [step, bytes] = sampling.take_checkpoint();
    ASSERT_FALSE(bytes.empty());
    EXPECT_TRUE(sampling.take_checkpoint().bytes.empty()) << "once";
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
