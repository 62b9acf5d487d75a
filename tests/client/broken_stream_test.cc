// Streams that break and are asked for again: no sample is lost, none comes twice.
#include <gmock/gmock.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "tests/client/unreliable.h"

namespace stiefel::client {
namespace {

class BrokenStreamTest : public UnreliableTest {
 protected:
  std::vector<std::int64_t> steps(Range range) {
    client::Stream stream(connection(), "any", std::move(range));
    std::vector<std::int64_t> steps;
    for (const SampleView sample : stream) steps.push_back(sample.step());
    EXPECT_TRUE(stream.run_status());
    return steps;
  }
};

TEST_F(BrokenStreamTest, AStreamThatIsRefusedBegins) {
  service_.failures = 2;
  service_.failure = refusal(std::chrono::milliseconds(1));
  EXPECT_THAT(steps({3, 5, 1}), testing::ElementsAre(3, 4, 5));
  EXPECT_EQ(service_.calls, 3);
}

TEST_F(BrokenStreamTest, ABrokenStreamGoesOnWhereItBroke) {
  for (const Range& range : {Range{0, 9, 1}, Range{2, 11, 4}, Range{0, 10, 3}, Range{5, 5, 1}}) {
    service_.streams_to_break = 0;
    const auto whole = steps(range);
    service_.streams_to_break = 1'000'000;
    for (const int messages : {1, 2, 3}) {
      service_.messages_a_stream = messages;
      // Every stream breaks after so many messages; the one that only lacks its run status must not
      // break for ever.
      service_.streams_to_break = static_cast<int>(whole.size() / 2 + 1);
      EXPECT_EQ(steps(range), whole) << range.from << ' ' << range.to << ' ' << range.every;
    }
  }
}

TEST_F(BrokenStreamTest, TheStepsOfEveryStreamAreCounted) {
  service_.messages_a_stream = 1;  // two samples: 0 and 1, 2 and 3, 4 and 5, and the rest at once
  service_.streams_to_break = 3;
  Stream stream(connection(), "any", {0, 9, 1});
  while (stream.next_batch()) {
  }
  EXPECT_EQ(service_.calls, 4);
  EXPECT_EQ(stream.computed_steps(), 1 + 1 + 1 + 3);
}

TEST_F(BrokenStreamTest, TheDeadlineIsThatOfAllStreamsTogether) {
  service_.messages_a_stream = 1;
  service_.pause_a_message = std::chrono::milliseconds(100);
  Options options;
  options.compute_timeout = std::chrono::seconds(2);
  const auto start = std::chrono::steady_clock::now();
  Stream stream(connection(options), "any", {0, 1'000'000, 1});
  int batches = 0;
  try {
    while (stream.next_batch()) ++batches;
    ADD_FAILURE() << "no Error was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::DEADLINE_EXCEEDED) << error.what();
  }
  EXPECT_GE(batches, 1);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(BrokenStreamTest, AStreamThatNeverBeganIsRepeated) {
  service_.failures = 2;
  EXPECT_THAT(steps({3, 5, 1}), testing::ElementsAre(3, 4, 5));
}

TEST_F(BrokenStreamTest, ASampleInPartsIsSentAgainWhenItsStreamBreaks) {
  for (const int messages : {1, 2, 3, 4, 5, 6, 7}) {
    service_.messages_a_stream = messages;
    service_.streams_to_break = messages < 3 ? 1 : 2;
    Stream stream(connection(), "any", {.from = 3, .to = 5, .fields = {"large"}});
    std::vector<std::int64_t> steps;
    for (const SampleView sample : stream) {
      steps.push_back(sample.step());
      const auto numbers = sample.field("large").values;
      ASSERT_EQ(numbers.size(), 5u);
      for (std::size_t i = 0; i < 5; ++i)
        EXPECT_EQ(numbers[i], static_cast<double>(sample.step()) + static_cast<double>(i));
    }
    EXPECT_THAT(steps, testing::ElementsAre(3, 4, 5)) << messages;
    EXPECT_TRUE(stream.run_status());
  }
}

TEST_F(BrokenStreamTest, AStateTooLargeForAReplyComesOverAStream) {
  v1::Session description;
  description.set_session_id("any");
  for (const int messages : {3, 4, 5, 100}) {
    service_.messages_a_stream = messages;
    service_.streams_to_break = 1;
    const Session session(connection(), description, {}, true);
    const auto reply = session.step(4, {"large"});
    EXPECT_EQ(reply.sample().step(), 4);
    EXPECT_EQ(field(reply.sample(), "large").values[4], 8);
    EXPECT_EQ(reply.run_status().outcome(), v1::OUTCOME_REACHED);
    EXPECT_EQ(reply.sample().fields(0).value().shape_size(), 2);
  }
}

TEST_F(BrokenStreamTest, ACheckpointInPartsIsPutTogether) {
  for (const int messages : {3, 4, 5, 100}) {
    service_.messages_a_stream = messages;
    service_.streams_to_break = 1;
    Stream stream(connection(), "any",
                  {.from = 4, .to = 4, .fields = {"large"}, .return_checkpoint = true});
    while (stream.next_batch() != nullptr) {
    }
    ASSERT_TRUE(stream.checkpoint()) << messages;
    EXPECT_EQ(stream.checkpoint()->step, 4);
    EXPECT_EQ(stream.checkpoint()->bytes, "a checkpoint");
  }
}

}  // namespace
}  // namespace stiefel::client
